// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// First hit of a ray with the iso surface. Bricks of 4³ cells without the threshold are skipped; in
// the others the ray is sampled every half voxel until it crosses the threshold in the required
// direction. The crossing between two samples is then located in the exact trilinear field. Walls
// thinner than half a voxel may be missed. The same traversal as in maths/rays.ts.

uniform sampler3D bricks;  // minimum and maximum of each brick, not interpolated
uniform vec3 brickCount;
uniform float iso;    // [HU]
uniform bool rising;  // the wall is brighter than the lumen

const float kBrick = 4.0;
const float kStep = 0.5;   // voxels
const int kMaxBricks = 1024;
const int kMaxSteps = 32;  // in a brick: its diagonal is 4·√3 voxels
const int kRefinements = 3;
const float kNothing = -1.0;

// Root of the field minus the threshold between a and b, which have different signs: the secant
// selects a cell, and Newton's method finds the root in its exact trilinear field.
float crossing(vec3 o, vec3 d, float a, float b, float fa, float fb) {
    float t = mix(a, b, clamp(fa / (fa - fb), 0.0, 1.0));
    ivec3 last = ivec3(size) - 1;
    ivec3 c = clamp(ivec3(o + t * d), ivec3(0), max(last - 1, 0));
    ivec3 e = min(c + 1, last);
    float v000 = texelFetch(volume, c, 0).r;
    float v100 = texelFetch(volume, ivec3(e.x, c.y, c.z), 0).r;
    float v010 = texelFetch(volume, ivec3(c.x, e.y, c.z), 0).r;
    float v110 = texelFetch(volume, ivec3(e.x, e.y, c.z), 0).r;
    float v001 = texelFetch(volume, ivec3(c.x, c.y, e.z), 0).r;
    float v101 = texelFetch(volume, ivec3(e.x, c.y, e.z), 0).r;
    float v011 = texelFetch(volume, ivec3(c.x, e.y, e.z), 0).r;
    float v111 = texelFetch(volume, e, 0).r;
    for (int i = 0; i < kRefinements; ++i) {
        vec3 f = o + t * d - vec3(c);
        vec4 x0 = vec4(v000, v010, v001, v011), dx = vec4(v100, v110, v101, v111) - x0;
        vec4 row = x0 + f.x * dx;
        vec2 face = mix(row.xz, row.yw, f.y);
        float value = mix(face.x, face.y, f.z) - iso;
        vec2 slopeX = mix(dx.xz, dx.yw, f.y), slopeY = row.yw - row.xz;
        float slope = d.x * mix(slopeX.x, slopeX.y, f.z) + d.y * mix(slopeY.x, slopeY.y, f.z) +
                      d.z * (face.y - face.x);
        if (abs(slope) > 1e-6) t = clamp(t - value / slope, a, b);
    }
    return t;
}

// Distance of the first hit along the ray [mm], or kNothing. o [voxels], d [voxels per mm]
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
    float before = quickSample(o + t * d) - iso;
    bool above = before >= 0.0;
    for (int b = 0; b < kMaxBricks && t < exit; ++b) {
        // On the plane between two bricks the direction decides: rounding may lose the nudge.
        vec3 p = (o + (t + nudge) * d) / kBrick;
        vec3 brick = clamp(mix(ceil(p) - 1.0, floor(p), forward), vec3(0.0), brickCount - 1.0);
        vec3 faces = ((brick + forward) * kBrick - o) * inverse;
        float end = min(max(min(min(faces.x, faces.y), faces.z), t + nudge), exit);
        vec2 range = texelFetch(bricks, ivec3(brick), 0).rg;
        if (range.x >= iso || range.y < iso) {
            bool now = range.x >= iso;
            if (now != above && now == rising) return t;
            above = now;
            before = now ? 1.0 : -1.0;  // only its sign is known
            t = end;
            continue;
        }
        for (int i = 0; i < kMaxSteps && t < end; ++i) {
            float next = min(t + stride, end);
            float after = quickSample(o + next * d) - iso;
            bool now = after >= 0.0;
            if (now != above && now == rising) return crossing(o, d, t, next, before, after);
            above = now;
            before = after;
            t = next;
        }
    }
    return kNothing;
}

// Gradient [HU/mm, LPS] by central differences. p [voxels]
vec3 gradientAt(vec3 p) {
    vec3 last = size - 1.0;
    vec3 slope;
    for (int a = 0; a < 3; ++a) {
        vec3 e = vec3(a == 0, a == 1, a == 2);
        vec3 before = clamp(p - e, vec3(0.0), last);
        vec3 after = clamp(p + e, vec3(0.0), last);
        float width = dot(after - before, e);
        slope[a] = width > 0.0 ? (quickSample(after) - quickSample(before)) / width : 0.0;
    }
    return transpose(mat3(voxelFromWorld)) * slope;
}

// Unit normal of the wall, towards the lumen and never along the ray.
vec3 wallNormal(vec3 p, vec3 ray) {
    vec3 world = gradientAt(p);
    float steepness = length(world);
    if (!(steepness > 1e-9)) return -ray;
    vec3 n = (rising ? -1.0 : 1.0) / steepness * world;
    float facing = dot(n, ray);
    return facing > 0.0 ? normalize(n - facing * ray + 1e-9 * ray) : n;
}
