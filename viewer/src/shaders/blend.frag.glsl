// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Volume rendering: the scan as an absorbing and emitting medium, front to back, with the equations
// of src/view/render/blend.h. A step of length s has the opacity 1 − exp(−extinction · s), so the
// picture hardly depends on the step. Samples are shifted along each ray by a share of the step
// that differs between neighbouring pixels: noise instead of rings like wood grain. Bricks without
// extinction are crossed in one step.
//
// Instruments and catheters are opaque: rays end at them. Samples lie where they lie without them.
// INSTRUMENTS, CATHETER: the scene has some.

uniform vec2 jitter;               // of all rays, -1...1 across the picture
uniform vec3 fogColour;            // background, linear
uniform bool cut;                  // nothing in front of this plane is drawn
uniform vec3 cutPlace, cutNormal;  // [mm, LPS]; towards the viewer

const int kMaxPoints = 8;
const int kMaxEmpty = 4;
uniform vec4 transfer[kMaxPoints];        // linear colour, extinction [1/mm]
uniform vec2 transferValues[kMaxPoints];  // value [HU]; 1/(value - value of the point before)
uniform int transferCount;
uniform vec2 empty[kMaxEmpty];  // intervals of values without extinction [HU]
uniform float steep;            // change of the values that is a surface [HU/mm]
uniform float stride;           // longest step [mm]
uniform float phase;            // shift of the samples, 0…1 step
uniform float dark;             // rays end below this transmittance

const int kMaxSamples = 8192;
const float kAmbientShare = 0.35;

vec4 transferAt(float value) {
    vec4 found = transfer[0];
    for (int i = 1; i < kMaxPoints; ++i) {
        if (i >= transferCount) break;
        float share = (value - transferValues[i - 1].x) * transferValues[i].y;
        found = mix(found, transfer[i], clamp(share, 0.0, 1.0));
    }
    return found;
}

bool isEmpty(vec2 range) {
    for (int i = 0; i < kMaxEmpty; ++i)
        if (range.x >= empty[i].x && range.y <= empty[i].y) return true;
    return false;
}

// Interleaved gradient noise [Jimenez2014], 0…1: neighbouring pixels differ as much as possible.
float pixelShare() {
    return fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
}

// Light of a sample. p [voxels]
vec3 sampleLight(vec3 own, vec3 p, vec3 ray) {
    vec4 over = overlayAt(p);
    own = mix(own, linearOf(over.rgb), over.a);
    vec3 gradient = gradientAt(p);
    float steepness = length(gradient);
    if (!(steepness > 0.0)) return own;
    float facing = abs(dot(gradient, ray)) / steepness;
    float surface = min(steepness / steep, 1.0);
    return (1.0 - surface * (1.0 - kAmbientShare) * (1.0 - facing)) * own;
}

// Adds light and reduces the transmittance along a ray, up to a distance [mm]. o [voxels],
// d [voxels per mm], ray: d in the world, unit
void blend(inout vec3 light, inout float transmittance, vec3 o, vec3 d, vec3 ray, float reach) {
    d += vec3(equal(d, vec3(0.0))) * 1e-9;
    vec3 inverse = 1.0 / d;
    vec3 t0 = -o * inverse, t1 = (size - 1.0 - o) * inverse;
    vec3 enter = min(t0, t1), leave = max(t0, t1);
    float begin = max(max(enter.x, enter.y), max(enter.z, 0.0));
    float end = min(min(leave.x, leave.y), leave.z);
    if (!(begin < min(end, reach))) return;
    float count = min(ceil((end - begin) / stride), float(kMaxSamples));
    float step_mm = (end - begin) / count;
    float offset = fract(pixelShare() + phase);
    vec3 forward = vec3(greaterThan(d, vec3(0.0)));
    float brickEnd = -1.0, i = 0.0;
    for (int n = 0; n < kMaxSamples; ++n) {
        if (i >= count || transmittance < dark) break;
        float t = begin + (i + offset) * step_mm;
        if (t >= reach) break;
        vec3 p = o + t * d;
        i += 1.0;
        if (t >= brickEnd) {
            vec3 brick = clamp(floor(p / kBrick), vec3(0.0), brickCount - 1.0);
            vec3 faces = ((brick + forward) * kBrick - o) * inverse;
            brickEnd = min(min(faces.x, faces.y), faces.z);
            if (isEmpty(texelFetch(bricks, ivec3(brick), 0).rg)) {
                i = max(i, ceil((brickEnd - begin) / step_mm - offset));
                continue;
            }
        }
        vec4 own = transferAt(quickSample(p));
        if (own.a <= 0.0) continue;
        float opacity = 1.0 - exp(-own.a * step_mm);
        light += transmittance * opacity * sampleLight(own.rgb, p, ray);
        transmittance *= 1.0 - opacity;
    }
}

void main() {
    vec3 ray = rayThrough((place + jitter) * vec2(aspect, 1.0));
    vec3 behind = fogColour;
    float nearest = kFar;
#ifdef CATHETER
    addCatheter(behind, nearest, eye, ray, up, false);
#endif
#ifdef INSTRUMENTS
    addInstruments(behind, nearest, eye, ray, up, false);
#endif
    float start = 0.0;
    if (cut)
        start = max(dot(cutPlace - eye, cutNormal) / min(dot(ray, cutNormal), -1e-6), 0.0);
    vec3 light = vec3(0.0);
    float transmittance = 1.0;
    blend(light, transmittance, voxelOf(eye + start * ray), voxelVectorOf(ray), ray,
          nearest - start);
    if (transmittance < dark) transmittance = 0.0;
    colour = vec4(srgbOf(light + transmittance * behind), 1.0);
}
