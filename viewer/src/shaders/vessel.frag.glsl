// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Transparent wall: clearer where it faces the camera, warmer and denser where it was displaced.

precision highp float;

in vec3 world;
in vec3 facing;
in float far;
out vec4 colour;

uniform vec3 eye;
uniform vec3 own, warm;   // sRGB
uniform float warmAt;     // [mm]
uniform float clear, rim; // opacities at normal and at grazing incidence
uniform float dense;      // opacity of displaced wall

void main() {
    vec3 ray = normalize(world - eye);
    float towards = abs(dot(normalize(facing), ray));
    float displaced = clamp(far / warmAt, 0.0, 1.0);
    vec3 shade = mix(own, warm, displaced);
    float opacity = mix(rim, clear, towards);
    colour = vec4(shade * (0.35 + 0.65 * towards), mix(opacity, max(opacity, dense), displaced));
}
