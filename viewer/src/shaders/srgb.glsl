// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Light is summed in linear red, green and blue, 0…1; pictures are in sRGB.

vec3 srgbOf(vec3 light) {
    light = clamp(light, 0.0, 1.0);
    return mix(light * 12.92, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055,
               vec3(greaterThan(light, vec3(0.0031308))));
}

vec3 linearOf(vec3 srgb) {
    return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)),
               vec3(greaterThan(srgb, vec3(0.04045))));
}
