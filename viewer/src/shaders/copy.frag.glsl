// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A picture that was drawn with fewer or more pixels, shown in full size.

precision highp float;
in vec2 place;
out vec4 colour;
uniform sampler2D picture;

void main() {
    colour = vec4(texture(picture, 0.5 * place + 0.5).rgb, 1.0);
}
