// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Labels of the deformed scan: numbers at voxels, which are never interpolated. Borders are smooth
// by weighing the colours of the eight voxels around a point. Numbers of bodies are negative in
// every other cube of the tissue at rest: where bodies touch, these cubes are drawn in two shades,
// so that bodies that slide on each other shift them.

#ifdef LABELS
uniform sampler3D labelField;     // numbers, 0: none; not interpolated
uniform highp sampler2D labelColours;  // by number: sRGB; alpha, in 255ths: kTarget + kShown + body
uniform float labelOpacity;
uniform bool labelOutlines;
uniform bool targetsOn;
uniform bool contactsOn;

const float kShown = 64.0, kTarget = 128.0;
const float kLabelBehind = 1.2;     // of the label that tints a wall [voxels]
const float kTargetReach = 40.0;    // behind the wall [mm]
const float kTargetFade = 18.0;     // depth at which a target's light falls to 1/e [mm]
const int kTargetSteps = 64;
const float kContactReach = 1.2;    // distance of the other body [voxels]
const vec3 kLight = vec3(1.0, 0.88, 0.15), kDark = vec3(0.12, 0.08, 0.02);  // sRGB

vec4 labelLook(ivec3 voxel) {
    ivec3 kept = clamp(voxel, ivec3(0), ivec3(size) - 1);
    int number = int(abs(texelFetch(labelField, kept, 0).r) + 0.5);
    return texelFetch(labelColours, ivec2(number, 0), 0);
}

bool isShown(vec4 look) {
    return mod(floor((look.a * 255.0 + 0.5) / kShown), 2.0) > 0.5;
}

float bodyOf(vec4 look) {
    return mod(floor(look.a * 255.0 + 0.5), kShown);
}

// Shade of a body where another one is near, and its opacity. p [voxels]
vec4 contactShade(vec3 p) {
    if (!contactsOn) return vec4(0.0);
    ivec3 voxel = ivec3(floor(p + 0.5));
    float own = bodyOf(labelLook(voxel));
    if (own < 0.5) return vec4(0.0);
    bool touches = false;
    for (int n = 0; n < 6 && !touches; ++n) {
        vec3 step = vec3(0.0);
        step[n / 2] = (n & 1) == 0 ? kContactReach : -kContactReach;
        float other = bodyOf(labelLook(ivec3(floor(p + step + 0.5))));
        touches = other > 0.5 && other != own;
    }
    if (!touches) return vec4(0.0);
    float number = texelFetch(labelField, clamp(voxel, ivec3(0), ivec3(size) - 1), 0).r;
    return vec4(number < 0.0 ? kDark : kLight, 0.75);
}

// Colour, and the share of labelled voxels around p [voxels].
vec4 labelShare(vec3 p) {
    vec3 low = floor(p);
    vec3 t = p - low;
    vec4 sum = vec4(0.0);
    for (int c = 0; c < 8; ++c) {
        ivec3 corner = ivec3(c & 1, c >> 1 & 1, c >> 2);
        vec4 look = labelLook(ivec3(low) + corner);
        if (!isShown(look)) continue;
        vec3 w = mix(1.0 - t, t, vec3(corner));
        sum += w.x * w.y * w.z * vec4(look.rgb, 1.0);
    }
    return vec4(sum.rgb / max(sum.a, 1e-6), sum.a);
}

// sRGB and opacity. p [voxels]
vec4 labelAt(vec3 p) {
    vec4 label = labelShare(p);
    return vec4(label.rgb, labelOpacity * smoothstep(0.4, 0.6, label.a));
}

// The same for a picture, with the border as a line. dx, dy: one pixel [voxels]
vec4 labelOutlined(vec3 p, vec3 dx, vec3 dy) {
    vec4 label = labelShare(p);
    float opacity = labelOpacity * smoothstep(0.4, 0.6, label.a);
    if (!labelOutlines) return vec4(label.rgb, opacity);
    vec4 beside = labelShare(p + dx), below = labelShare(p + dy);
    vec2 slope = vec2(beside.a, below.a) - label.a;
    float line = 1.0 - clamp(abs(label.a - 0.5) / max(length(slope), 1e-3) - 0.6, 0.0, 1.0);
    vec3 own = label.a > 0.0 ? label.rgb : beside.a > 0.0 ? beside.rgb : below.rgb;
    return vec4(own, max(opacity, 0.95 * line * step(1e-3, length(slope))));
}

vec4 labelBehind(vec3 p, vec3 normal) {
    return labelAt(p - kLabelBehind * normalize(voxelVectorOf(normal)));
}

// First target along a ray from a wall: sRGB, and its strength. o [voxels], d [voxels per mm]
vec4 targetBehind(vec3 o, vec3 d) {
    if (!targetsOn) return vec4(0.0);
    float stride = max(1.0 / length(d), kTargetReach / float(kTargetSteps));
    for (int n = 0; n < kTargetSteps; ++n) {
        float depth = float(n) * stride;
        vec3 p = o + depth * d;
        if (any(lessThan(p, vec3(0.0))) || any(greaterThan(p, size - 1.0))) break;
        vec4 look = labelLook(ivec3(p + 0.5));
        if (look.a * 255.0 > kTarget - 0.5)
            return vec4(look.rgb, 0.75 * exp(-depth / kTargetFade));
    }
    return vec4(0.0);
}
#endif
