// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The volume as a continuous field over voxel indices: trilinear between voxel centres, constant
// beyond the outermost ones. quickSample lets the texture unit interpolate, whose weights may have
// as few as eight bits; exactSample does it in full precision, where the surface is.

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

float exactSample(vec3 p) {
    p = clamp(p, vec3(0.0), size - 1.0);
    ivec3 last = ivec3(size) - 1;
    ivec3 a = min(ivec3(p), max(last - 1, 0));
    ivec3 b = min(a + 1, last);
    vec3 f = p - vec3(a);
    float v000 = texelFetch(volume, a, 0).r;
    float v100 = texelFetch(volume, ivec3(b.x, a.y, a.z), 0).r;
    float v010 = texelFetch(volume, ivec3(a.x, b.y, a.z), 0).r;
    float v110 = texelFetch(volume, ivec3(b.x, b.y, a.z), 0).r;
    float v001 = texelFetch(volume, ivec3(a.x, a.y, b.z), 0).r;
    float v101 = texelFetch(volume, ivec3(b.x, a.y, b.z), 0).r;
    float v011 = texelFetch(volume, ivec3(a.x, b.y, b.z), 0).r;
    float v111 = texelFetch(volume, b, 0).r;
    float near = mix(mix(v000, v100, f.x), mix(v010, v110, f.x), f.y);
    float far = mix(mix(v001, v101, f.x), mix(v011, v111, f.x), f.y);
    return mix(near, far, f.z);
}
