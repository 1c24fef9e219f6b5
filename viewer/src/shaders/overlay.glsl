// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Colour of an overlay's value. Tissue near rest keeps its own colour.

uniform sampler3D overlayField;  // half floats, linear
uniform bool overlayOn;
uniform float overlayRest;      // value of undeformed tissue
uniform vec2 overlayRange;      // values at the ends of the map
uniform float overlayOpacity;
const int kColours = 17;
uniform vec3 overlayColours[kColours];  // sRGB

const float kFaint = 0.06;  // share of the range, from rest on, in which the colour fades in

// sRGB and opacity. p [voxels]
vec4 overlayAt(vec3 p) {
    if (!overlayOn) return vec4(0.0);
    float value = texture(overlayField, (p + 0.5) / size).r;
    float share = clamp((value - overlayRange.x) / (overlayRange.y - overlayRange.x), 0.0, 1.0);
    float place = share * float(kColours - 1);
    int i = min(int(place), kColours - 2);
    vec3 own = mix(overlayColours[i], overlayColours[i + 1], place - float(i));
    float departure = abs(value - overlayRest) / (overlayRange.y - overlayRest);
    return vec4(own, overlayOpacity * min(departure / kFaint, 1.0));
}
