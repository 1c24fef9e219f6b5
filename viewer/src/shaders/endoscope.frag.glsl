// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Picture of the endoscope, with the camera and the light of the C++ renderer
// (src/view/render/endoscope.cpp): a lamp at the camera, specular highlights on wet tissue, light
// that falls off with the distance and fades into fog. The same rays hit instruments and catheters
// (instrument.glsl, catheter.glsl).
//
// REAL: the style; else plain. RAW: tissue was carved or cut. INSTRUMENTS, CATHETER, LABELS: the
// scene has some. Programs without them take less time, to compile and to run.
//
// OUTSIDE: the same scene from outside, cut open at a plane. Tissue on the plane is grey as in a
// section; the lumen is open behind the plane.

uniform vec2 jitter;       // of all rays, -1...1 across the picture
uniform float lightReach;  // distance at which the light is halved [mm]
uniform float fogDistance; // [mm]; 0: none
uniform vec3 surfaceColour, fogColour;  // linear
#ifdef DEPTH
uniform float reach;  // distance of depth 1, for meshes [mm]
#endif
#ifdef OUTSIDE
uniform vec3 cutPlace, cutNormal;  // nothing in front of this plane is drawn [mm, LPS]
uniform float window, level;       // of the cut face [HU]
uniform mat4 clipFromWorld;        // for the depth of meshes
#endif

const float kAmbient = 0.10;
const float kSheen = 0.10;
const float kGlint = 0.22;
const float kDepth = 0.6;
const float kSoftness = 400.0;  // [HU]
const float kBehind = 0.7;      // voxels

// Colour of the wall; an overlay shows the value of the tissue behind the surface.
vec3 wallColour(vec3 p, vec3 normal) {
    vec4 over = overlayAt(p - kBehind * normalize(voxelVectorOf(normal)));
    vec3 own = mix(surfaceColour, linearOf(over.rgb), over.a);
#ifdef LABELS
    vec4 label = labelBehind(p, normal);
    own = mix(own, linearOf(label.rgb), label.a);
    vec4 contact = contactShade(p - kLabelBehind * normalize(voxelVectorOf(normal)));
    own = mix(own, linearOf(contact.rgb), contact.a);
#endif
    return own;
}

// Ambient occlusion, 1: open … 0: closed, from the tissue up to 4 mm off the surface.
float openness(vec3 p, vec3 normal) {
    vec3 n = voxelVectorOf(normal);
    float closed = 0.0;
    for (float step = 1.0; step < 5.0; step *= 2.0) {
        float excess = (quickSample(p + step * n) - iso) / kSoftness;
        closed += clamp((rising ? excess : -excess) + 0.5, 0.0, 1.0);
    }
    return 1.0 - closed / 3.0;
}

vec3 lit(vec3 own, float t, vec3 normal, vec3 ray, float open) {
    float facing = max(0.0, -dot(normal, ray));
    float reach = t / lightReach;
    float falloff = 1.0 / (1.0 + reach * reach);
    float diffuse = falloff * (0.4 + 0.6 * open) * ((1.0 - kAmbient) * facing + kAmbient);
    float shine = falloff * (kSheen * pow(facing, 16.0) + kGlint * pow(facing, 80.0));
    float brightest = max(max(own.r, own.g), max(own.b, 1e-6));
    float share = 1.0 - kDepth * (1.0 - diffuse);  // the rest passed through the tissue
    vec3 light = diffuse * mix(own * own / brightest, own, share) + shine * vec3(1.0, 0.97, 0.95);
    float clear = fogDistance > 0.0 ? exp(-t / fogDistance) : 1.0;
    return mix(fogColour, light, clear);
}

#ifdef DEPTH
vec3 wallLight(vec3 p, float t, vec3 normal, vec3 ray) {
    vec3 face = p;
#ifdef RAW
    float raw = real ? restAt(p).w : 0.0;
    if (raw > 0.0) toRawFace(face, normal, ray, raw);
#endif
    float open = openness(face, normal);
    if (!real) return lit(wallColour(p, normal), t, normal, ray, open);
    vec3 light = realLight(p, face, t, normal, ray, open);
#ifdef LABELS
    vec4 label = labelBehind(p, normal);
    if (label.a > 0.0)
        light = mix(light, lit(linearOf(label.rgb), t, normal, ray, open), label.a);
#endif
    vec4 over = overlayAt(p - kBehind * normalize(voxelVectorOf(normal)));
    if (over.a == 0.0) return light;
    return mix(light, lit(linearOf(over.rgb), t, normal, ray, open), over.a);
}
#endif

void main() {
    vec2 uv = (place + jitter) * vec2(aspect, 1.0);
    vec3 ray = rayThrough(uv);
    float start = 0.0;
    vec3 light = real ? vec3(0.0) : fogColour;
    float shown = real ? fieldAt(uv) : 1.0;
#ifdef DEPTH
    if (shown <= 0.0) {
        gl_FragDepth = 0.0;  // hides meshes as well
        colour = vec4(0.0, 0.0, 0.0, 1.0);
        return;
    }
#endif
#ifdef OUTSIDE
    start = max(dot(cutPlace - eye, cutNormal) / min(dot(ray, cutNormal), -1e-6), 0.0);
#endif
    vec3 o = voxelOf(eye + start * ray);
    vec3 d = voxelVectorOf(ray);
    float t = kNothing;
    bool cutFace = false;
#ifdef OUTSIDE
    float value = quickSample(o);
    cutFace = all(greaterThanEqual(o, vec3(0.0))) && all(lessThanEqual(o, size - 1.0)) &&
              (value >= iso) == rising;
    if (cutFace) {
        float grey = clamp((value - level) / max(window, 1e-6) + 0.5, 0.0, 1.0);
        light = vec3(0.75, 0.72, 0.68) * pow(grey, 2.2);
        vec4 over = overlayAt(o);
        light = mix(light, linearOf(over.rgb), over.a);
#ifdef LABELS
        vec4 label = labelAt(o);
        light = mix(light, linearOf(label.rgb), label.a);
        vec4 contact = contactShade(o);
        light = mix(light, linearOf(contact.rgb), contact.a);
#endif
        t = 0.0;
    }
#endif
    if (!cutFace) t = firstHit(o, d);
    if (t != kNothing && !cutFace) {
        vec3 p = o + t * d;
        vec3 normal = wallNormal(p, ray);
#ifdef OUTSIDE
        light = lit(wallColour(p, normal), 0.0, normal, ray, openness(p, normal));
#else
        light = wallLight(p, t, normal, ray);
#endif
#ifdef LABELS
        vec4 target = targetBehind(p, d);
        light = mix(light, linearOf(target.rgb), target.a);
#endif
    }
    if (t != kNothing) t += start;
    float nearest = t != kNothing ? t : kFar;
#ifdef OUTSIDE
    bool lamp = false;
#else
    bool lamp = true;
    if (t != kNothing && !real) light *= contactAt(eye + t * ray);
#endif
#ifdef CATHETER
    addCatheter(light, nearest, eye, ray, up, lamp);
#endif
#ifdef INSTRUMENTS
    addInstruments(light, nearest, eye, ray, up, lamp);
#endif
#ifdef DEPTH
    gl_FragDepth = clamp(nearest / reach, 0.0, 1.0);
#endif
#ifdef OUTSIDE
    vec4 clip = clipFromWorld * vec4(eye + nearest * ray, 1.0);
    gl_FragDepth = nearest < kFar ? clamp(0.5 * clip.z / clip.w + 0.5, 0.0, 1.0) : 1.0;
#endif
    colour = vec4(srgbOf(shown * light), 1.0);
}
