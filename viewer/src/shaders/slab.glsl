// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Projection of a slab around a section: the largest, smallest or mean value along its normal. The
// field is linear between planes of voxels, so the values at these planes and at both faces suffice
// for each projection, exactly in grids along the axes of the sections.

uniform float slab;      // thickness [mm]; 0: a plane
uniform vec3 slabAxis;   // normal [voxels per mm]
uniform int projection;  // 0: maximum, 1: minimum, 2: mean

const int kMaxPlanes = 4096;

// Value at p [voxels], or of the slab around it.
float slabAt(vec3 p) {
    if (slab <= 0.0) return quickSample(p);
    vec3 d = slabAxis + vec3(equal(slabAxis, vec3(0.0))) * 1e-9;
    vec3 m = abs(d);
    int a = m.x >= m.y && m.x >= m.z ? 0 : m.y >= m.z ? 1 : 2;
    if (d[a] < 0.0) d = -d;
    vec3 t0 = (-0.5 - p) / d, t1 = (size - 0.5 - p) / d;
    vec3 enter = min(t0, t1), leave = max(t0, t1);
    float t = max(max(enter.x, enter.y), max(enter.z, -0.5 * slab));
    float end = min(min(leave.x, leave.y), min(leave.z, 0.5 * slab));
    float depth = end - t, plane = floor(p[a] + t * d[a]) + 1.0;
    float value = quickSample(p + t * d), found = value, sum = 0.0;
    for (int n = 0; n < kMaxPlanes && t < end; ++n) {
        float next = min((plane - p[a]) / d[a], end);
        float after = quickSample(p + next * d);
        found = projection == 0 ? max(found, after) : min(found, after);
        sum += 0.5 * (value + after) * (next - t);
        value = after;
        t = next;
        plane += 1.0;
    }
    return projection == 2 && depth > 0.0 ? sum / depth : found;
}
