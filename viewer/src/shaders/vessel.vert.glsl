// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vertices of the vessel's wall in the outside view.

precision highp float;

in vec3 position;  // [mm, LPS]
in vec3 normal;
in float moved;  // displacement [mm]
out vec3 world;
out vec3 facing;
out float far;  // displacement [mm]

uniform mat4 clipFromWorld;

void main() {
    world = position;
    facing = normal;
    far = moved;
    gl_Position = clipFromWorld * vec4(position, 1.0);
}
