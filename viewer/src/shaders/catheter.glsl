// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Intersection of rays with a catheter: a chain of capsules. Rows of the texture: points with their
// arc lengths from the tip [mm]; bounding spheres of groups of 8 segments; bounding spheres of 8
// groups. A ray that misses the catheter tests few spheres and no segment.

uniform highp sampler2D catheter;  // floats, not interpolated
uniform int catheterCount;         // points; fewer than 2: no catheter
uniform float catheterRadius;      // [mm]
uniform ivec2 catheterGap;         // range of segments left out around the eye

const int kGroup = 8;
const float kTipMark = 2.5;    // length of the radiopaque tip [mm]
const float kBandEvery = 10.0; // [mm]
const float kBand = 1.2;

bool passesBy(vec3 o, vec3 d, vec4 sphere) {
    vec3 m = o - sphere.xyz;
    float b = dot(m, d);
    vec3 off = m - b * d;
    return dot(off, off) > sphere.w * sphere.w || (b > 0.0 && dot(m, m) > sphere.w * sphere.w);
}

vec4 catheterPoint(int i) {
    return texelFetch(catheter, ivec2(clamp(i, 0, catheterCount - 1), 0), 0);
}

// Unit tangent of the curve at a point, towards the tip.
vec3 catheterTangent(int i) {
    vec3 along = catheterPoint(i + 1).xyz - catheterPoint(i - 1).xyz;
    return along / max(length(along), 1e-9);
}

#ifndef SHADOW
bool leftOut(int piece) {
    return piece >= catheterGap.x && piece < catheterGap.y;
}

// Distance of the first hit [mm], or kFar; way: arc length from the tip [mm]. Normals are
// interpolated along the curve, so that segments are not visible.
float catheterHit(vec3 o, vec3 d, out vec3 normal, out float way) {
    float best = kFar, place = 0.0;
    int found = -1;
    int last = catheterCount - 1;
    for (int s = 0; s * kGroup * kGroup < last; ++s) {
        if (passesBy(o, d, texelFetch(catheter, ivec2(s, 2), 0))) continue;
        int end = min((s + 1) * kGroup, (last + kGroup - 1) / kGroup);
        for (int g = s * kGroup; g < end; ++g) {
            if (passesBy(o, d, texelFetch(catheter, ivec2(g, 1), 0))) continue;
            vec3 a = catheterPoint(g * kGroup).xyz;
            int stop = min((g + 1) * kGroup, last);
            for (int i = g * kGroup; i < stop; ++i) {
                vec3 b = catheterPoint(i + 1).xyz;
                float k;
                float t = leftOut(i) ? kFar : capsuleHit(o, d, a, b, catheterRadius, k);
                if (t < best) {
                    best = t;
                    place = k;
                    found = i;
                }
                a = b;
            }
        }
    }
    normal = -d;
    way = 0.0;
    if (found < 0) return kFar;
    vec4 a = catheterPoint(found), b = catheterPoint(found + 1);
    way = mix(a.w, b.w, place);
    normal = (o + best * d - mix(a.xyz, b.xyz, place)) / catheterRadius;
    if (place > 0.0 && place < 1.0) {
        vec3 along = normalize(mix(catheterTangent(found), catheterTangent(found + 1), place));
        normal = normalize(normal - dot(normal, along) * along);
    }
    return best;
}

vec3 catheterColour(float way) {
    if (way < kTipMark) return vec3(0.95, 0.86, 0.62);
    float band = mod(way, kBandEvery);
    float dark = smoothstep(0.0, 0.15, band) * smoothstep(kBand, kBand - 0.15, band);
    return mix(vec3(0.16, 0.42, 0.66), vec3(0.015, 0.05, 0.10), dark);
}

void addCatheter(inout vec3 light, inout float nearest, vec3 o, vec3 d, vec3 upward, bool lamp) {
    vec3 normal;
    float way;
    float t = catheterHit(o, d, normal, way);
    if (t >= kFar) return;
    vec3 colour_ = catheterColour(way);
    float gloss_ = way < kTipMark ? 0.9 : mix(0.1, 0.45, smoothstep(0.1, 0.66, colour_.b));
    Hit hit = Hit(t, normal, colour_, gloss_, true);
    vec3 own = steel(hit, d, lamp ? t : 0.0, upward);
    light = t < nearest ? own : mix(light, own, lamp ? 0.06 : 0.3);
    nearest = min(nearest, t);
}

// Contact shading, 0…1: 1 far from instruments and catheters, less where they touch the wall.
float contactAt(vec3 world) {
    float open = 1.0;
#ifdef INSTRUMENTS
    open = nearInstruments(world);
#endif
#ifdef CATHETER
    float reach = 3.2 * catheterRadius, away = reach;
    int last = catheterCount - 1;
    for (int g = 0; g * kGroup < last; ++g) {
        vec4 sphere = texelFetch(catheter, ivec2(g, 1), 0);
        if (length(world - sphere.xyz) > sphere.w + reach) continue;
        int stop = min((g + 1) * kGroup, last);
        for (int i = g * kGroup; i < stop; ++i)
            if (!leftOut(i))
                away = min(away, awayFrom(world, catheterPoint(i).xyz, catheterPoint(i + 1).xyz));
    }
    open *= mix(0.45, 1.0, smoothstep(catheterRadius, reach, away));
#endif
    return open;
}

// Share of a lamp's light that passes instruments and catheter. A catheter close to the lens casts
// no shadow: a lamp inside of it would leave the whole picture dark.
float shadowAt(vec3 world, vec3 toLamp, float far) {
    float lit = 1.0;
#ifdef CATHETER
    int last = catheterCount - 1;
    for (int g = 0; g * kGroup < last; ++g) {
        vec4 sphere = texelFetch(catheter, ivec2(g, 1), 0);
        sphere.w += 0.15 + 0.06 * far;
        if (passesBy(world, toLamp, sphere)) continue;
        int stop = min((g + 1) * kGroup, last);
        for (int i = g * kGroup; i < stop; ++i) {
            if (leftOut(i)) continue;
            float s;
            float past = pastCapsule(world, toLamp, far, catheterPoint(i).xyz,
                                     catheterPoint(i + 1).xyz, catheterRadius, s);
            lit = min(lit, mix(past, 1.0, smoothstep(far - 5.0, far - 2.0, s)));
        }
    }
#endif
#ifdef INSTRUMENTS
    lit *= instrumentShadow(world, toLamp, far);
#endif
    return lit;
}
#endif

// Length of the ray in the catheter [mm]; the tip counts fourfold. Each segment is clipped by the
// bisecting planes to its neighbours, so that nothing counts twice.
float catheterThickness_mm(vec3 eye, vec3 ray) {
    float sum = 0.0;
    int last = catheterCount - 1;
    for (int g = 0; g * kGroup < last; ++g) {
        vec4 sphere = texelFetch(catheter, ivec2(g, 1), 0);
        if (passesBy(eye, ray, sphere)) continue;
        float shift = max(dot(sphere.xyz - eye, ray), 0.0);
        vec3 o = eye + shift * ray;
        int stop = min((g + 1) * kGroup, last);
        for (int i = g * kGroup; i < stop; ++i) {
            vec4 a = catheterPoint(i), b = catheterPoint(i + 1);
            vec3 along = normalize(b.xyz - a.xyz);
            vec3 m = o - a.xyz;
            vec3 across = m - dot(m, along) * along;
            vec3 d = ray - dot(ray, along) * along;
            float k2 = max(dot(d, d), 1e-9), k1 = dot(across, d);
            float q = k1 * k1 - k2 * (dot(across, across) - catheterRadius * catheterRadius);
            if (q <= 0.0) continue;
            float enter = (-k1 - sqrt(q)) / k2, leave = (-k1 + sqrt(q)) / k2;
            enter = max(enter, -shift);
            vec3 n = catheterTangent(i);
            float towards = dot(ray, n), off = -dot(m, n);
            if (abs(towards) < 1e-6) towards = 1e-6;
            if (towards > 0.0) enter = max(enter, off / towards);
            else leave = min(leave, off / towards);
            n = catheterTangent(i + 1);
            towards = dot(ray, n);
            off = dot(b.xyz - o, n);
            if (abs(towards) < 1e-6) towards = 1e-6;
            if (towards > 0.0) leave = min(leave, off / towards);
            else enter = max(enter, off / towards);
            float marked = 0.5 * (a.w + b.w) < kTipMark ? 4.0 : 1.0;
            sum += marked * max(leave - enter, 0.0);
        }
    }
    return sum;
}
