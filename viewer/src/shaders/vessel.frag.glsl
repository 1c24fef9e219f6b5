// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A wall that one sees through, clearer where it faces the camera, warmer where it has given way;
// or the catheter in it. SHADOW: as fluoroscopy has it, dark whatever is in front.

precision highp float;

in vec3 world;
in vec3 facing;
in float far;
out vec4 colour;

uniform vec3 eye;
uniform vec3 own, warm;   // sRGB
uniform float warmAt;     // [mm]
uniform float clear, rim; // opacities: where it faces the camera, and at its rim
uniform float reach;      // depth 1 [mm], where no matrix gives one

void main() {
    vec3 ray = normalize(world - eye);
    float towards = abs(dot(normalize(facing), ray));
    vec3 shade = mix(own, warm, clamp(far / warmAt, 0.0, 1.0));
#ifdef SHADOW
    colour = vec4(own, clear);
#else
    colour = vec4(shade * (0.35 + 0.65 * towards), mix(rim, clear, towards));
#endif
#ifdef OUTSIDE
    gl_FragDepth = gl_FragCoord.z;
#else
    gl_FragDepth = clamp(distance(world, eye) / reach, 0.0, 1.0);
#endif
}
