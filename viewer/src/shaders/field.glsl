// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The volume as a continuous field over voxel indices: trilinear between voxel centres, constant
// beyond the outermost ones. quickSample uses the texture unit, whose weights may have eight bits
// only: enough for sections and shading. The surface is located by the voxels themselves
// (surface.glsl).

precision highp float;
precision highp int;
precision highp sampler3D;

uniform sampler3D volume;  // half floats [HU], linear
uniform vec3 size;         // voxels
uniform mat4 voxelFromWorld;

vec3 voxelOf(vec3 world) {
    return (voxelFromWorld * vec4(world, 1.0)).xyz;
}

vec3 voxelVectorOf(vec3 vector) {
    return (voxelFromWorld * vec4(vector, 0.0)).xyz;
}

float quickSample(vec3 p) {
    return texture(volume, (p + 0.5) / size).r;
}
