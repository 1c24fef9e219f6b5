// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The scan as an image intensifier shows it: each ray is dimmed by what it goes through, as in
// include/pliant/fluoroscopy.h. Dense is dark; the exposure is 45 % grey.

in vec2 place;
out vec4 colour;

uniform vec3 eye, right, up, ahead;  // [mm, LPS]; perpendicular unit vectors
uniform float aspect;                // width / height
uniform float slope;                 // tan of half the field of view
uniform float absorption;            // of water, with the contrast [1/mm]
uniform float exposure;              // water that is 45 % grey [mm]

const int kMostSteps = 2048;
const float kStep = 1.0;  // voxels
const float kCatheterWater = 30.0;  // a catheter with a core of steel, as so much water

// What a ray goes through [mm of water]. o [voxels], d [voxels per mm]
float waterAlong(vec3 o, vec3 d) {
    d += vec3(equal(d, vec3(0.0))) * 1e-9;
    vec3 t0 = -o / d, t1 = (size - 1.0 - o) / d;
    vec3 enter = min(t0, t1), leave = max(t0, t1);
    float t = max(max(enter.x, enter.y), max(enter.z, 0.0));
    float length_mm = min(min(leave.x, leave.y), leave.z) - t;
    if (!(length_mm > 0.0)) return 0.0;
    float count = min(ceil(length_mm * length(d) / kStep), float(kMostSteps));
    float step_mm = length_mm / count;
    float sum = 0.0;
    for (int n = 0; n < kMostSteps; ++n) {
        if (float(n) >= count) break;
        vec3 p = o + (t + (float(n) + 0.5) * step_mm) * d;
        sum += max(0.0, 1.0 + quickSample(p) / 1000.0);
    }
    return sum * step_mm;
}

void main() {
    vec2 uv = place * vec2(aspect, 1.0);
    vec3 ray = normalize(ahead + slope * uv.x * right + slope * uv.y * up);
    float water = waterAlong(voxelOf(eye), voxelVectorOf(ray));
    if (catheterCount > 1) water += kCatheterWater * catheterThickness_mm(eye, ray);
    // Sigmoid with a window of 4 and 45 % at the exposure; the exponent is bounded for float.
    float excess = min(absorption * (water - exposure), 60.0);
    float light = 1.0 / (1.0 + 0.55 / 0.45 * exp(excess));
    colour = vec4(vec3(clamp(light, 0.0, 1.0)), 1.0);
}
