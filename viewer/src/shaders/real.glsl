// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Light of the style "real", explained in src/view/render/real_look.cpp: lamps beside the lens,
// colours by the scan behind the wall, blood vessels anchored to the tissue at rest, translucency,
// a film of liquid. Names are the same there.

#ifdef REAL
const bool real = true;
#else
const bool real = false;
#endif
uniform sampler3D noiseTile;  // gradient per cell, value; periodic, 16 cells
uniform float exposure;       // [mm²]
uniform float spacingMm;      // geometric mean of the voxel spacing
uniform float voxelMm;        // step behind the wall
uniform int fieldStop;        // 0: round, 1: octagon, 2: full
uniform vec3 mucosa, pale, fatty, bony, thinWall;  // linear
uniform float fatShare, paleShare, boneShare, thinShare, veinShare, mottle, gloss;

const float kLampAside = 1.6, kLampAbove = 0.5, kLampSize = 3.0;  // [mm]
const float kSoftHu = 300.0;
const vec3 kWrap = vec3(0.38, 0.14, 0.10);
const vec3 kClosedTint = vec3(0.30, 0.15, 0.13);
const float kAcross = 4.0;  // distance of the samples beside a slit [voxels]
const vec3 kSlit = vec3(0.045, 0.004, 0.005);
const vec3 kFlesh = vec3(0.46, 0.036, 0.038);
const vec3 kBlood = vec3(0.42, 0.10, 0.14);
const vec3 kLampColour = vec3(1.0, 0.97, 0.94);
const float kShadow = 0.35;
const float kGlintReach = 15.0;  // distance at which glints are twice as wide [mm]
const int kShadowTaps = 6;
const float kFaceNear = 2.0, kFaceFar = 3.0;  // samples around a raw face [voxels]
const float kFaceSoftHu = 1000.0;
const float kFarthest = 1.5;  // largest distance of a raw face to the voxels' wall [voxels]

vec4 noiseAt(vec3 q) {
    return texture(noiseTile, q / 16.0 + 0.5 / 64.0);
}

float excessAt(vec3 p) {
    float above = quickSample(p) - iso;
    return rising ? above : -above;
}

// A line on the wall along the level 0.5 of a noise.
float lineAtHalf(vec4 n, vec3 normal, float halfWidth) {
    float along = length(n.xyz - dot(n.xyz, normal) * normal);
    float width = halfWidth * smoothstep(0.25, 0.7, along);
    float away = abs(n.w - 0.5) / max(along, 0.25);
    return width > 0.0 ? 1.0 - smoothstep(0.3 * width, width, away) : 0.0;
}

#ifdef RAW
float tissueAt(vec3 p) {
    return clamp(excessAt(p) / kFaceSoftHu + 0.5, 0.0, 1.0);
}

// Moves a point and its normal to the face of raw tissue. Carving takes out whole voxels, which
// leaves terraces: the normal is that of the share of tissue within a few voxels, and the position
// is where that share is half.
void toRawFace(inout vec3 p, inout vec3 normal, vec3 ray, float raw) {
    float share = tissueAt(p);
    vec3 slope = vec3(0.0);
    for (int n = 0; n < 27; ++n) {
        if (n == 13) continue;
        vec3 d = normalize(vec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
        float tissue = tissueAt(p + kFaceNear * d) + tissueAt(p + kFaceFar * d);
        share += tissue;
        slope += tissue * d;
    }
    share /= 53.0;
    slope *= 3.0 / (26.0 * (kFaceNear + kFaceFar));  // the gradient of a linear field
    vec3 gradient = transpose(mat3(voxelFromWorld)) * slope;
    float steepness = length(gradient);
    if (!(steepness > 1e-6)) return;
    vec3 smoothed = -gradient / steepness;
    smoothed -= max(dot(smoothed, ray), 0.0) * ray;
    if (!(length(smoothed) > 1e-3)) return;
    smoothed = normalize(smoothed);
    float weight = smoothstep(0.1, 0.6, raw);
    float far = kFarthest * spacingMm;
    float off = clamp((share - 0.5) / steepness, -far, far);
    p += voxelVectorOf(weight * off * smoothed);
    normal = normalize(mix(normal, smoothed, weight));
}
#endif

// Share of a lamp's light that reaches a point. p [voxels]
float litBy(vec3 p, vec3 normal, vec3 toLamp, float far) {
    float step = min(far / 8.0, 1.5);
    float dark = 0.0;
    for (int n = 1; n <= kShadowTaps; ++n) {
        float way = 0.5 + float(n) * step;
        if (way > far - 0.8) break;
        float e = excessAt(p + voxelVectorOf(0.4 * normal + way * toLamp)) / kSoftHu + 0.3;
        dark = max(dark, clamp(e, 0.0, 1.0));
    }
    return mix(1.0, kShadow, dark);
}

float fatAt(float hu) {
    return smoothstep(-135.0, -95.0, hu) * (1.0 - smoothstep(-55.0, -20.0, hu));
}

// A closed cut. xyz: along the wall towards it, longest at its lips; w: darkness 0…1
vec4 slitAt(vec3 p, vec3 normal, float raw) {
    vec3 u = normalize(cross(normal, abs(normal.z) < 0.7 ? vec3(0, 0, 1) : vec3(1, 0, 0)));
    vec3 v = cross(normal, u);
    vec3 du = voxelVectorOf(kAcross * spacingMm * u), dv = voxelVectorOf(kAcross * spacingMm * v);
    float u0 = restAt(p - du).w, u1 = restAt(p + du).w;
    float v0 = restAt(p - dv).w, v1 = restAt(p + dv).w;
    float ridge = raw - min(max(u0, u1), max(v0, v1));
    return vec4((u1 - u0) * u + (v1 - v0) * v,
                clamp(ridge / 0.3, 0.0, 1.0) * smoothstep(0.85, 1.0, raw));
}

// Colour of the wall; its normal, bent at the lips of a slit; normal and wetness of the film of
// liquid.
vec3 coatAt(float t, vec3 p, vec3 world, inout vec3 normal, out vec3 film, out float wetness) {
    vec3 n = voxelVectorOf(voxelMm * normal);
    float shallow = quickSample(p - 2.5 * n);
    float deep = quickSample(p - 4.0 * n);
    float fat = min(fatAt(shallow), fatAt(deep)) *
                (1.0 - smoothstep(25.0, 70.0, abs(shallow - deep)));
    float most = max(shallow, deep);
    float dense = rising ? smoothstep(80.0, 260.0, most) : smoothstep(90.0, 160.0, deep);
    float bone = rising ? smoothstep(280.0, 650.0, most) : smoothstep(250.0, 500.0, deep);
    float thin = 1.0 - smoothstep(-750.0, -350.0, min(shallow, deep));
    vec3 own = mix(mucosa, fatty, fatShare * fat);
    own = mix(own, pale, paleShare * dense);
    own = mix(own, bony, boneShare * bone);
    own = mix(own, thinWall, thinShare * thin);

    vec4 offset = restAt(p);
    vec3 rest = world - offset.xyz;
    vec4 wide = noiseAt(0.055 * rest + vec3(3.1, 7.7, 1.3));
    vec4 middle = noiseAt(0.21 * rest);
    vec4 fine = noiseAt(0.9 * rest + vec3(5.5, 2.5, 8.5));
    own *= 1.0 + mottle * (0.5 * wide.w + 0.3 * middle.w + 0.2 * fine.w - 0.5);

    vec3 bent = rest + 1.3 * middle.xyz + 0.2 * fine.xyz;
    vec4 trunk = noiseAt(0.13 * bent + vec3(9.1, 4.3, 6.7));
    vec4 twig = noiseAt(0.36 * bent + vec3(1.9, 3.3, 0.7));
    vec4 hair = noiseAt(0.85 * bent + vec3(4.2, 0.6, 2.8));
    float where = smoothstep(0.34, 0.6, wide.w);
    float near = 1.0 - smoothstep(0.12, 0.45, abs(trunk.w - 0.5));
    float twigs = near * smoothstep(0.25, 0.55, middle.w);
    float veins = max(
        0.80 * lineAtHalf(trunk, normal, 0.034 * where) * (1.0 - smoothstep(35.0, 80.0, t)),
        max(0.55 * lineAtHalf(twig, normal, 0.050 * twigs) * (1.0 - smoothstep(16.0, 45.0, t)),
            0.34 * lineAtHalf(hair, normal, 0.080 * smoothstep(0.34, 0.6, twig.w)) *
                (1.0 - smoothstep(8.0, 24.0, t))));
    own = mix(own, own * kBlood, veinShare * veins * (1.0 - bone));
    // Cut or carved tissue has no lining.
    float ragged = offset.w + 0.15 * (fine.w - 0.5);
    float raw = offset.w > 0.0 ? smoothstep(0.65, 0.95, ragged) : 0.0;
    own = mix(own, (0.7 + 0.6 * fine.w) * kFlesh, raw);
    vec3 bentNormal = normal;
    if (raw > 0.0) {
        vec4 slit = slitAt(p, normal, offset.w);
        own = mix(own, kSlit, slit.w);
        bentNormal = normalize(normal + raw * slit.xyz);
    }

    vec4 ripple = noiseAt(1.9 * rest + vec3(2.2, 6.1, 4.4));
    vec3 bump = 0.26 * 0.9 * fine.xyz + 0.20 * 1.9 * ripple.xyz;
    float fade = 1.0 - smoothstep(8.0, 60.0, t);
    film = normalize(bentNormal - fade * (bump - dot(bump, normal) * normal));
    normal = bentNormal;
    wetness = gloss * (0.45 + 1.1 * middle.w) * (1.0 + 0.6 * raw);
    return own;
}

float facets(float cosine, float a) {
    float d = cosine * cosine * (a - 1.0) + 1.0;
    return a / (3.14159265 * d * d);
}

vec3 tone(vec3 x) {
    x *= 0.9;
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

// Light of the wall at p [voxels], at a distance of t mm; linear, after the tone curve.
// face: position for shadows [voxels]
vec3 realLight(vec3 p, vec3 face, float t, vec3 normal, vec3 ray, float open) {
    vec3 world = eye + t * ray;
    vec3 film;
    float wetness;
    vec3 bentNormal = normal;
    vec3 own = coatAt(t, p, world, bentNormal, film, wetness);
    vec3 rough = normalize(mix(bentNormal, film, 0.35));
    float blur = 1.0 + t * t / (kGlintReach * kGlintReach);
    vec3 total = vec3(0.0);
    for (int k = 0; k < 2; ++k) {
        vec3 way = eye + (k == 0 ? kLampAside : -kLampAside) * right + kLampAbove * up - world;
        float far = length(way);
        vec3 toLamp = way / max(far, 1e-6);
        float facing = dot(rough, toLamp);
        float falloff = exposure / (far * far + kLampSize * kLampSize);
        float arrives = 0.5 * falloff * litBy(face, normal, toLamp, far);
        arrives *= mix(kShadow, 1.0, shadowAt(world, toLamp, far));
        vec3 half_ = normalize(toLamp - ray);
        float cosine = max(dot(film, half_), 0.0);
        float fresnel = 0.04 + 0.96 * pow(1.0 - max(dot(half_, toLamp), 0.0), 5.0);
        float shine = fresnel * wetness * open * clamp(4.0 * facing, 0.0, 1.0) *
                      (1.5 / blur * facets(cosine, 0.0012 * blur) + 0.25 * facets(cosine, 0.05));
        vec3 through = clamp((facing + kWrap) / (1.0 + kWrap), 0.0, 1.0);
        total += arrives * (own * through * mix(kClosedTint, vec3(1.0), open) +
                            kLampColour * shine);
    }
    total *= mix(vec3(0.45, 0.25, 0.22), vec3(1.0), contactAt(world));
    return tone(total);
}

// Transmission of field stop and vignette. uv: half heights of the picture
float fieldAt(vec2 uv) {
    uv /= min(1.0, aspect);
    float away = length(uv);
    vec2 side = abs(uv);
    float place = fieldStop == 0   ? away
                  : fieldStop == 1 ? max(max(side.x, side.y), (side.x + side.y) * 0.70710678)
                                   : 0.0;
    return (1.0 - 0.35 * smoothstep(0.45, 1.05, away)) * (1.0 - smoothstep(0.985, 1.005, place));
}
