// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rest positions of the tissue, for patterns that move, stretch and are cut with it.

uniform sampler3D restField;  // half floats, linear: offset [mm, LPS] and raw, every 4th voxel
uniform bool restOn;
uniform vec3 restCount;  // nodes along each axis

const float kRestStep = 4.0;  // from one node to the next [voxels]

// Offset [mm, LPS] and raw, 0…1: position at rest = position - offset. Zero while off. p [voxels]
vec4 restAt(vec3 p) {
    if (!restOn) return vec4(0.0);
    return texture(restField, (p / kRestStep + 0.5) / restCount);
}
