// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One triangle that covers the picture; place runs from −1 to 1.

in vec3 position;
out vec2 place;

void main() {
    place = position.xy;
    gl_Position = vec4(position.xy, 0.0, 1.0);
}
