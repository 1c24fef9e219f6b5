// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Transparent wall: clearer where it faces the camera, warmer where it was displaced.

precision highp float;

in vec3 world;
in vec3 facing;
in float far;
out vec4 colour;

uniform vec3 eye;
uniform vec3 own, warm;   // sRGB
uniform float warmAt;     // [mm]
uniform float clear, rim; // opacities at normal and at grazing incidence

void main() {
    vec3 ray = normalize(world - eye);
    float towards = abs(dot(normalize(facing), ray));
    vec3 shade = mix(own, warm, clamp(far / warmAt, 0.0, 1.0));
    colour = vec4(shade * (0.35 + 0.65 * towards), mix(rim, clear, towards));
}
