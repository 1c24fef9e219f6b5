// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A picture that was drawn with fewer or more pixels, shown in full size; or as a share of a mean.

precision highp float;
in vec2 place;
out vec4 colour;
uniform sampler2D picture;
uniform float share;  // 1: replaces the pixels that are there

void main() {
    colour = vec4(texture(picture, 0.5 * place + 0.5).rgb, share);
}
