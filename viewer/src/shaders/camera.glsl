// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Camera of the endoscope: a pinhole with barrel distortion.

in vec2 place;
out vec4 colour;

uniform vec3 eye, right, up, ahead;  // [mm, LPS]; perpendicular unit vectors
uniform float aspect;                // width / height
uniform float slope;                 // tan of half the field of view
uniform float barrel;

// Unit direction of the ray through a point of the picture [half heights, from its centre].
vec3 rayThrough(vec2 uv) {
    float scale = slope * (1.0 + barrel * dot(uv, uv));
    return normalize(ahead + scale * uv.x * right + scale * uv.y * up);
}
