// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A mesh in the endoscope's or the outside view. The endoscope's lens bends it as it bends rays:
// r_ray = r·(1 + barrel·r²) is solved for r by Newton's steps.

precision highp float;

in vec3 position;  // [mm, LPS]
in vec3 normal;
in float moved;  // [mm]
out vec3 world;
out vec3 facing;
out float far;  // how far it has moved [mm]

uniform vec3 eye, right, up, ahead;
uniform float aspect, slope, barrel;
#ifdef OUTSIDE
uniform mat4 clipFromWorld;
#endif

void main() {
    world = position;
    facing = normal;
    far = moved;
#ifdef OUTSIDE
    gl_Position = clipFromWorld * vec4(position, 1.0);
#else
    vec3 v = position - eye;
    float depth = dot(v, ahead);
    vec2 bent = vec2(dot(v, right), dot(v, up)) / (max(depth, 1e-3) * slope);
    float wanted = length(bent), r = wanted;
    for (int i = 0; i < 6; ++i)
        r -= (r * (1.0 + barrel * r * r) - wanted) / (1.0 + 3.0 * barrel * r * r);
    vec2 place = wanted > 0.0 ? bent * (r / wanted) : bent;
    gl_Position = vec4(place.x / aspect * depth, place.y * depth, 0.0, depth);
#endif
}
