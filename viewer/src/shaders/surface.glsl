// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// First hit of a ray with the iso surface. Bricks of 8³ cells without the threshold are crossed in
// one step; in the others the ray is sampled every half voxel until it changes sides in the wanted
// sense, and the crossing between two samples is then found in the exact trilinear field. A wall
// thinner than half a voxel may be missed. The same walk as rays.ts.

uniform sampler3D bricks;  // minimum and maximum of each brick, not interpolated
uniform vec3 brickCount;
uniform float iso;    // [HU]
uniform bool rising;  // the wall is brighter than the lumen

const float kBrick = 8.0;
const float kStep = 0.5;   // voxels
const int kMostBricks = 1024;
const int kMostSteps = 64;  // in a brick: its diagonal is 8·√3 voxels
const int kRefinements = 6;
const float kNothing = -1.0;

float crossing(vec3 o, vec3 d, float a, float b) {
    float fa = exactSample(o + a * d) - iso;
    float fb = exactSample(o + b * d) - iso;
    for (int i = 0; i < kRefinements; ++i) {
        float s = fa * fb < 0.0 ? (a * fb - b * fa) / (fb - fa) : 0.5 * (a + b);
        float fs = exactSample(o + s * d) - iso;
        if ((fs >= 0.0) == (fb >= 0.0)) {
            b = s;
            fb = fs;
            fa *= 0.5;  // regula falsi that halves a stuck end's weight
        } else {
            a = s;
            fa = fs;
            fb *= 0.5;
        }
    }
    return 0.5 * (a + b);
}

// Distance along the ray [mm], or kNothing. o [voxels], d [voxels per mm]
float firstHit(vec3 o, vec3 d) {
    d += vec3(equal(d, vec3(0.0))) * 1e-9;
    vec3 inverse = 1.0 / d;
    vec3 t0 = -o * inverse;
    vec3 t1 = (size - 1.0 - o) * inverse;
    vec3 enter = min(t0, t1);
    vec3 leave = max(t0, t1);
    float t = max(max(enter.x, enter.y), max(enter.z, 0.0));
    float exit = min(min(leave.x, leave.y), leave.z);
    if (!(t < exit)) return kNothing;
    float stride = kStep / length(d);
    float nudge = 1e-3 / length(d);
    vec3 forward = vec3(greaterThan(d, vec3(0.0)));
    bool above = quickSample(o + t * d) >= iso;
    for (int b = 0; b < kMostBricks && t < exit; ++b) {
        vec3 brick = clamp(floor((o + (t + nudge) * d) / kBrick), vec3(0.0), brickCount - 1.0);
        vec3 faces = ((brick + forward) * kBrick - o) * inverse;
        float end = min(max(min(min(faces.x, faces.y), faces.z), t + nudge), exit);
        vec2 range = texelFetch(bricks, ivec3(brick), 0).rg;
        if (range.x >= iso || range.y < iso) {
            bool now = range.x >= iso;
            if (now != above && now == rising) return t;
            above = now;
            t = end;
            continue;
        }
        for (int i = 0; i < kMostSteps && t < end; ++i) {
            float next = min(t + stride, end);
            bool now = quickSample(o + next * d) >= iso;
            if (now != above && now == rising) return crossing(o, d, t, next);
            above = now;
            t = next;
        }
    }
    return kNothing;
}

// Unit normal of the field, towards the lumen and never along the ray.
vec3 wallNormal(vec3 p, vec3 ray) {
    vec3 last = size - 1.0;
    vec3 slope;
    for (int a = 0; a < 3; ++a) {
        vec3 e = vec3(a == 0, a == 1, a == 2);
        vec3 before = clamp(p - e, vec3(0.0), last);
        vec3 after = clamp(p + e, vec3(0.0), last);
        float width = dot(after - before, e);
        slope[a] = width > 0.0 ? (quickSample(after) - quickSample(before)) / width : 0.0;
    }
    vec3 world = transpose(mat3(voxelFromWorld)) * slope;
    float steepness = length(world);
    if (!(steepness > 1e-9)) return -ray;
    vec3 n = (rising ? -1.0 : 1.0) / steepness * world;
    float facing = dot(n, ray);
    return facing > 0.0 ? normalize(n - facing * ray + 1e-9 * ray) : n;
}
