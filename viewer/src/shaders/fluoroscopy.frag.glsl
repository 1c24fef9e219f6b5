// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fluoroscopy: each ray is attenuated by the tissue along it, as in include/pliant/render.h;
// noise, characteristic curve and collimator as in src/view/render/detector.h. Dense tissue is
// dark; the exposure is 45 % grey.

in vec2 place;
out vec4 colour;

uniform vec3 eye, right, up, ahead;  // [mm, LPS]; perpendicular unit vectors
uniform float aspect;                // width / height
uniform float slope;                 // tan of half the field of view
uniform float absorption;            // of water [1/mm]
uniform float contrast;              // factor of the line integral
uniform float exposure;              // depth of water that is 45 % grey [mm]
uniform vec2 slab;                   // range along ahead between the planes [mm]
uniform vec3 margin;                 // border in which the outermost voxels fade out [voxels]
uniform int fieldStop;               // 0: round, 1: octagon, 2: full
uniform float noise;                 // factor
uniform uint seed;
uniform vec2 pixels;  // of the view, not of the target

const int kMaxSteps = 2048;
const float kStep = 1.0, kBorderStep = 2.0;  // voxels
const float kCatheterWater = 50.0;  // absorption of a catheter with a steel core over that of water
const float kQuantumNoise = 0.05, kNoisiest = 4.0;
const float kBlade = 0.975, kOpen = 1.0;  // [radii]

// Integral from t to end [mm]. o [voxels], d [voxels per mm]; faded: outside of the scan
float integral(vec3 o, vec3 d, float t, float end, float step_voxels, bool faded) {
    float length_mm = end - t;
    if (!(length_mm > 0.0)) return 0.0;
    float count = min(ceil(length_mm * length(d) / step_voxels), float(kMaxSteps));
    float step_mm = length_mm / count;
    vec3 fade = 1.0 / max(margin, 1e-6);
    float sum = 0.0;
    for (int n = 0; n < kMaxSteps; ++n) {
        if (float(n) >= count) break;
        vec3 p = o + (t + (float(n) + 0.5) * step_mm) * d;
        float density = max(0.0, 1.0 + quickSample(p) / 1000.0);
        if (faded) {
            vec3 beyond = (p - clamp(p, vec3(0.0), size - 1.0)) * fade;
            float left = max(0.0, 1.0 - dot(beyond, beyond));
            density *= left * left;
        }
        sum += density;
    }
    return sum * step_mm;
}

// Range of a ray in the scan, enlarged by more voxels [mm].
vec2 stretchIn(vec3 o, vec3 d, vec3 more) {
    vec3 t0 = (-more - o) / d, t1 = (size - 1.0 + more - o) / d;
    vec3 enter = min(t0, t1), leave = max(t0, t1);
    return vec2(max(max(enter.x, enter.y), max(enter.z, 0.0)),
                min(min(leave.x, leave.y), leave.z));
}

// Depth of water along a ray [mm], with the border. part: cosine between ray and view
float waterAlong(vec3 o, vec3 d, float part) {
    d += vec3(equal(d, vec3(0.0))) * 1e-9;
    vec2 scan = stretchIn(o, d, vec3(0.0));
    vec2 all = stretchIn(o, d, margin);
    all = vec2(max(all.x, slab.x / part), min(all.y, slab.y / part));
    bool hit = scan.y > scan.x;
    float water = integral(o, d, all.x, hit ? scan.x : all.y, kBorderStep, true);
    if (!hit) return water;
    return water + integral(o, d, scan.x, scan.y, kStep, false) +
           integral(o, d, scan.y, all.y, kBorderStep, true);
}

float cornerNoise(uvec2 p) {
    uint h = p.x * 0x8da6b343u ^ p.y * 0xd8163841u ^ seed * 0xcb1ab31fu;
    h = (h + 1u) * 0x9e3779b1u;
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    h ^= h >> 16;
    return float(h >> 8) / 16777216.0;
}

float pixelNoise(uvec2 p) {
    float sum = cornerNoise(p) + cornerNoise(p + uvec2(1, 0)) + cornerNoise(p + uvec2(0, 1)) +
                cornerNoise(p + uvec2(1, 1));
    return 1.7320508 * (sum - 2.0);
}

// Transmission of the collimator. uv: half heights of the picture
float openAt(vec2 uv) {
    uv = abs(uv) / min(1.0, aspect);
    float away = fieldStop == 0   ? length(uv)
                 : fieldStop == 1 ? max(max(uv.x, uv.y), (uv.x + uv.y) * 0.70710678)
                                  : 0.0;
    return 1.0 - smoothstep(kBlade, kOpen, away);
}

void main() {
    vec2 uv = place * vec2(aspect, 1.0);
    float open = openAt(uv);
    if (open <= 0.0) {
        colour = vec4(0.0, 0.0, 0.0, 1.0);
        return;
    }
    vec3 ray = normalize(ahead + slope * uv.x * right + slope * uv.y * up);
    float water = waterAlong(voxelOf(eye), voxelVectorOf(ray), dot(ray, ahead));
    if (catheterCount > 1) water += kCatheterWater * catheterThickness_mm(eye, ray);
    float excess = absorption * (water - exposure);
    if (noise > 0.0) {
        uvec2 pixel = uvec2((0.5 + vec2(0.5, -0.5) * place) * pixels);
        excess += noise * kQuantumNoise * min(exp(min(0.5 * excess, 10.0)), kNoisiest) *
                  pixelNoise(pixel);
    }
    // Sigmoid with a window of 4 and 45 % at the exposure; the exponent is bounded for float.
    float light = 1.0 / (1.0 + 0.55 / 0.45 * exp(min(contrast * excess, 60.0)));
    colour = vec4(vec3(clamp(open * light, 0.0, 1.0)), 1.0);
}
