// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Instruments, hit by the endoscope's own rays: the lens distorts them like the wall, and no near
// plane clips them. A shaft is a capsule from the working channel to the wrist. The head begins at
// the wrist and ends near the centre of the tool's sphere. Heads lean away from the line of sight
// (views/instruments.ts), so that their kind is recognisable.
//
//                     jaw ⟋            h: axis of the head, unit
//   shaft ═══════ wrist ⟨   h →  o     e: side, unit, across the head and towards the lens
//                     jaw ⟍            v = h × e: jaws open and blades are wide along v
//                                      o: centre of the sphere

const float kFar = 1e9;
const int kMaxTools = 9;
const int kBall = 0, kGrasper = 1, kBlade = 2, kScoop = 3, kScope = 4;
uniform vec4 tools[kMaxTools];       // centre and radius of the head's sphere [mm]
uniform vec4 toolBases[kMaxTools];   // start of the shaft, and its radius [mm]; 0: no shaft
uniform vec3 toolWrists[kMaxTools];  // end of the shaft
uniform vec3 toolAxes[kMaxTools];    // h
uniform vec4 toolSides[kMaxTools];   // e, and half the opening of the jaws [radians]; side of a
                                      // blade: 1, or -1 with its back towards -v
uniform vec3 toolColours[kMaxTools]; // of the user, linear
uniform int toolKinds[kMaxTools];
uniform float toolOpacities[kMaxTools];  // of heads: large ones show the wall behind them
uniform int toolCount;

const vec3 kSteel = vec3(0.56, 0.59, 0.64);
const vec3 kTissueGlow = vec3(0.55, 0.16, 0.12);
const float kHeadBehind = 0.14;   // weight of a head behind the wall
const float kShaftBehind = 0.05;

struct Hit {
    float t;      // [mm]; kFar: none
    vec3 normal;  // unit
    vec3 own;     // linear
    float gloss;
    bool head;
};

// Hit of the near side of a sphere; kFar from inside.
float sphereHit(vec3 o, vec3 d, vec3 c, float r) {
    vec3 m = o - c;
    float b = dot(m, d), q = b * b - dot(m, m) + r * r;
    float t = -b - sqrt(max(q, 0.0));
    return q > 0.0 && t > 0.0 ? t : kFar;
}

// Hit of the near side of a capsule, kFar from inside; place: 0 at a … 1 at b. The origin is first
// moved next to the capsule: the squares would lose a thin capsule far away to rounding.
float capsuleHit(vec3 o, vec3 d, vec3 a, vec3 b, float r, out float place) {
    float shift = dot(0.5 * (a + b) - o, d);
    vec3 ba = b - a, oa = o + shift * d - a;
    float baba = max(dot(ba, ba), 1e-9), bard = dot(ba, d), baoa = dot(ba, oa);
    float k2 = max(baba - bard * bard, 1e-9);
    float k1 = baba * dot(d, oa) - baoa * bard;
    float h = k1 * k1 - k2 * (baba * (dot(oa, oa) - r * r) - baoa * baoa);
    place = 0.0;
    if (h < 0.0) return kFar;
    float t = (-k1 - sqrt(h)) / k2;
    place = (baoa + t * bard) / baba;
    if (place > 0.0 && place < 1.0) return t + shift > 0.0 ? t + shift : kFar;
    place = clamp(place, 0.0, 1.0);
    return sphereHit(o, d, place > 0.5 ? b : a, r);
}

// Hit of an ellipsoid. Its half axes are the columns of axes; the normal has no unit length.
float ellipsoidHit(vec3 o, vec3 d, vec3 c, mat3 axes, vec3 lengths, out vec3 normal) {
    vec3 m = ((o - c) * axes) / lengths, n = (d * axes) / lengths;
    float a = dot(n, n), b = dot(m, n), q = b * b - a * (dot(m, m) - 1.0);
    float t = (-b - sqrt(max(q, 0.0))) / a;
    normal = axes * ((m + t * n) / lengths);
    return q > 0.0 && t > 0.0 ? t : kFar;
}

void keep(inout Hit best, float t, vec3 normal, vec3 own, float gloss) {
    if (t >= best.t) return;
    best = Hit(t, normal, own, gloss, true);
}

// Two jaws on a hinge. Open jaws are as wide as the sphere; their tips meet in its centre.
void grasperHit(inout Hit best, vec3 o, vec3 d, vec4 head, vec3 hinge, vec3 h, vec4 side) {
    float r = head.w;
    float t = sphereHit(o, d, hinge, 0.28 * r);
    if (t < kFar) keep(best, t, (o + t * d - hinge) / (0.28 * r), 0.7 * kSteel, 0.8);
    vec3 v = cross(h, side.xyz);
    vec3 lengths = r * vec3(0.88, 0.16, 0.28);
    for (float sign_ = -1.0; sign_ < 2.0; sign_ += 2.0) {
        vec3 out_ = sign_ * v;
        vec3 along = cos(side.w) * h + sin(side.w) * out_;
        vec3 across = cos(side.w) * out_ - sin(side.w) * h;
        vec3 c = hinge + 0.85 * r * along + 0.14 * r * across;
        vec3 normal;
        t = ellipsoidHit(o, d, c, mat3(along, across, side.xyz), lengths, normal);
        if (t >= best.t) continue;
        vec3 q = o + t * d - c;
        // Teeth on the inner side.
        float inner = smoothstep(0.02, -0.05, dot(q, across) / r);
        float teeth = smoothstep(0.3, 0.6, abs(fract(4.0 * dot(q, along) / r) - 0.5) * 2.0);
        keep(best, t, normalize(normal), kSteel * mix(1.05, mix(0.25, 0.95, teeth), inner), 1.0);
    }
}

// A scalpel: the intersection of six half-spaces, with a bright ground edge.
void bladeHit(inout Hit best, vec3 o, vec3 d, vec4 head, vec3 h, vec4 side) {
    float r = head.w;
    vec3 e = side.xyz, v = side.w * cross(h, e);
    vec3 slant = normalize(0.5 * h - v);
    vec3 tip = 0.15 * r * h + 0.3 * r * v;
    vec3 normals[6] = vec3[6](e, -e, v, slant, -v, -h);
    float offs[6] = float[6](0.07 * r, 0.07 * r, 0.3 * r, dot(tip, slant), 0.5 * r, 2.2 * r);
    float enter = 0.0, leave = kFar;
    vec3 normal = -d;
    for (int i = 0; i < 6; ++i) {
        float towards = dot(d, normals[i]);
        float off = offs[i] - dot(o - head.xyz, normals[i]);
        if (abs(towards) < 1e-6) {
            if (off < 0.0) return;
            continue;
        }
        float t = off / towards;
        if (towards > 0.0)
            leave = min(leave, t);
        else if (t > enter) {
            enter = t;
            normal = normals[i];
        }
    }
    if (enter <= 0.0 || enter >= leave || enter >= best.t) return;
    vec3 q = o + enter * d - head.xyz;
    float edge = min(dot(tip - q, slant), dot(q, v) + 0.5 * r) / r;
    bool ground = edge < 0.2;
    normal = normalize(ground ? normal + 0.5 * slant : normal);
    keep(best, enter, normal, kSteel * (ground ? 1.6 : 0.75), ground ? 1.6 : 1.0);
}

const float kSpoon = 0.85;  // radius of the spoon over that of the sphere

// A spoon: part of a sphere, visible from outside or through its mouth.
void scoopHit(inout Hit best, vec3 o, vec3 d, vec4 head, vec3 h, vec3 e) {
    float r = kSpoon * head.w;
    vec3 m = o - head.xyz;
    float b = dot(m, d), q = b * b - dot(m, m) + r * r;
    if (q <= 0.0) return;
    vec3 mouth = normalize(0.3 * h + e);
    for (float far = -1.0; far < 2.0; far += 2.0) {
        float t = -b + far * sqrt(q);
        vec3 n = (m + t * d) / r;
        float height = dot(n, mouth);
        if (t <= 0.0 || height > 0.1) continue;
        bool rim = height > -0.06;
        vec3 own = kSteel * (rim ? 1.3 : far > 0.0 ? 0.45 : 0.9);
        keep(best, t, -far * n, own, rim ? 1.5 : far > 0.0 ? 0.5 : 1.0);
        return;
    }
}

// The shaft, with a ring in the user's colour behind the head. Endoscopes are dark with a bright
// tip.
void shaftHit(inout Hit best, vec3 o, vec3 d, int i) {
    vec4 head = tools[i], base = toolBases[i];
    if (base.w <= 0.0) return;
    int kind = toolKinds[i];
    vec3 end = toolWrists[i];
    float place;
    float t = capsuleHit(o, d, base.xyz, end, base.w, place);
    if (t >= best.t) return;
    vec3 q = o + t * d;
    vec3 a = normalize(end - base.xyz);
    float behind = dot(end - q, a);
    float from = base.w + (kind == kBall || kind == kScope ? head.w : 0.0);
    bool marked = behind > from + base.w && behind < from + 5.0 * base.w;
    vec3 own = kind == kScope ? (behind < 0.9 * head.w ? 0.9 * kSteel : vec3(0.045)) : kSteel;
    if (marked) own = toolColours[i];
    vec3 normal = place < 1.0 ? normalize(q - end + behind * a) : (q - end) / base.w;
    best = Hit(t, normal, own, marked || kind == kScope ? 0.35 : 1.0, kind == kScope);
}

Hit toolHit(int i, vec3 o, vec3 d) {
    Hit best = Hit(kFar, -d, kSteel, 1.0, false);
    vec4 head = tools[i], side = toolSides[i];
    vec3 h = toolAxes[i];
    int kind = toolKinds[i];
    shaftHit(best, o, d, i);
    if (kind == kBall) {
        float t = sphereHit(o, d, head.xyz, head.w);
        if (t < best.t) keep(best, t, (o + t * d - head.xyz) / head.w, kSteel, 1.0);
    } else if (kind == kGrasper)
        grasperHit(best, o, d, head, toolWrists[i], h, side);
    else if (kind == kBlade)
        bladeHit(best, o, d, head, h, side);
    else if (kind == kScoop)
        scoopHit(best, o, d, head, h, side.xyz);
    return best;
}

// Light of metal: dim, with a bright band like a window's reflection, and reddish at grazing
// angles. upward: up vector of the picture, unit. t: distance to the lamp [mm]
vec3 steel(Hit hit, vec3 d, float t, vec3 upward) {
    float f = max(0.0, -dot(hit.normal, d));
    vec3 mirrored = reflect(d, hit.normal);
    float height = 0.5 + 0.5 * dot(mirrored, upward);
    float band = smoothstep(0.35, 0.6, height) * smoothstep(0.95, 0.6, height);
    vec3 window = 0.35 * hit.gloss * band * f * vec3(0.9, 0.92, 1.0);
    vec3 light = hit.own * (0.10 + 0.60 * f * f) + window +
                 0.22 * kTissueGlow * (1.0 - f) * (1.0 - f) + 0.9 * hit.gloss * pow(f, 60.0);
    float reach = t / 30.0;
    return light / (1.0 + reach * reach);
}

// Adds the instruments to the light and the distance of the wall.
void addInstruments(inout vec3 light, inout float nearest, vec3 o, vec3 d, vec3 upward, bool lamp) {
    for (int i = 0; i < toolCount; ++i) {
        Hit hit = toolHit(i, o, d);
        if (hit.t >= kFar) continue;
        vec3 own = steel(hit, d, lamp ? hit.t : 0.0, upward);
        float opacity = hit.head ? toolOpacities[i] : 1.0;
        if (hit.t < nearest) {
            // The rim and reflections stay, as in glass.
            float facing = max(0.0, -dot(hit.normal, d));
            float rim = (1.0 - facing) * (1.0 - facing);
            light = mix(light, own, mix(rim, 1.0, opacity));
            if (opacity == 1.0) nearest = hit.t;
        } else
            light = mix(light, own, hit.head ? kHeadBehind : kShaftBehind);
    }
}

// Distance of a point to the segment from a to b.
float awayFrom(vec3 p, vec3 a, vec3 b) {
    vec3 ba = b - a;
    return length(p - a - clamp(dot(p - a, ba) / max(dot(ba, ba), 1e-9), 0.0, 1.0) * ba);
}

// Share of a lamp's light that passes a capsule on the way to a point of the wall. toLamp: unit;
// far: distance to the lamp [mm]. Shadows are softer, the farther the capsule is from the wall.
float pastCapsule(vec3 world, vec3 toLamp, float far, vec3 a, vec3 b, float r, out float s) {
    // Closest points of ray and axis.
    vec3 ba = b - a, w = world - a;
    float along = dot(toLamp, ba), c = max(dot(ba, ba), 1e-9), g = dot(toLamp, w);
    float h = dot(ba, w);
    s = clamp((along * h - c * g) / max(c - along * along, 1e-6), 0.0, far);
    float k = clamp((h + along * s) / c, 0.0, 1.0);
    s = clamp(along * k - g, 0.0, far);
    float soft = 0.15 + 0.06 * s;
    return smoothstep(r - soft, r + soft, length(w + s * toLamp - k * ba));
}

// Bounding capsule of a head: its start and radius.
vec4 headCapsule(int i) {
    int kind = toolKinds[i];
    float r = tools[i].w;
    if (kind == kGrasper) return vec4(toolWrists[i], 0.3 * r);
    if (kind == kBlade) return vec4(toolWrists[i], 0.25 * r);
    return vec4(tools[i].xyz, kind == kScoop ? kSpoon * r : r);
}

// Contact shading, 0…1: 1 far from instruments, less where one touches the wall.
float nearInstruments(vec3 world) {
    float open = 1.0;
    for (int i = 0; i < toolCount; ++i) {
        vec4 head = headCapsule(i), base = toolBases[i];
        float away = awayFrom(world, tools[i].xyz, head.xyz) - head.w;
        float shade = 0.65 * toolOpacities[i] * toolOpacities[i];
        open *= 1.0 - shade * (1.0 - smoothstep(0.0, 0.9 * head.w, away));
        if (base.w <= 0.0) continue;
        away = awayFrom(world, toolWrists[i], base.xyz);
        open *= mix(0.55, 1.0, smoothstep(base.w, 3.2 * base.w, away));
    }
    return open;
}

float instrumentShadow(vec3 world, vec3 toLamp, float far) {
    float lit = 1.0, s;
    for (int i = 0; i < toolCount; ++i) {
        vec4 head = headCapsule(i), base = toolBases[i];
        float passed = pastCapsule(world, toLamp, far, tools[i].xyz, head.xyz, head.w, s);
        lit *= mix(1.0, passed, toolOpacities[i]);
        if (base.w <= 0.0) continue;
        lit *= pastCapsule(world, toLamp, far, toolWrists[i], base.xyz, base.w, s);
    }
    return lit;
}
