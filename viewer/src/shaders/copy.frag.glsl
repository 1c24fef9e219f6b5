// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Copies a picture to full size, or blends it into a mean.

precision highp float;
in vec2 place;
out vec4 colour;
uniform sampler2D picture;
uniform float share;  // weight of the picture; 1: replaces the pixels

void main() {
    colour = vec4(texture(picture, 0.5 * place + 0.5).rgb, share);
}
