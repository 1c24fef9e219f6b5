// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The head around the nose: skin, skull, brain, eyes, jaw, pituitary gland.
// The front of a head; the back is outside of the cube.

#include "volume/phantom_bodies.h"
#include "volume/phantom_noise.h"
#include "volume/phantom_tubes.h"

namespace pliant::phantom {
namespace {

double head(Vec3d p) {
    const double vault = ellipsoid(p, {0, 34, 16}, {59, 84, 78});
    const double face = box(p, {0, 0, -24}, {46, 48, 66}, 30);
    const double cheek = sphere(mirrored_x(p), {27, -25, -13}, 22.5);
    const double front = smooth_union(smooth_union(vault, face, 10), cheek, 12);
    const double bridge = capsule(p, {0, -43, 20}, {0, -53, -11}, 4.5, 6.5);
    const double wings = capsule(mirrored_x(p), {6, -46, -22}, {4.5, -51, -17}, 6, 5);
    return smooth_union(front, smooth_union(bridge, wings, 5), 7);
}

/// The brain's cavity; its floor descends in three steps from front to back.
double cranium(Vec3d p, double grown_mm) {
    const double side = std::abs(p.x);
    const double over_orbit = 9 * ramp(4, 16, side) * (1 - ramp(0, 12, p.y));
    const double dx = (side - 36) / 22, dy = (p.y - 26) / 27;
    const double middle = 17 * ramp(1.1, 0.3, dx * dx + dy * dy);
    const double back = 30 * ramp(30, 50, p.y);
    const double floor = 24.5 + over_orbit - middle - back - grown_mm;
    const double vault = ellipsoid(p, {0, 34, 18}, {52, 75, 69}) - grown_mm;
    return smooth_intersection(vault, 0.6 * (floor - p.z), 5);
}

double orbit(Vec3d p) {
    const Vec3d q = mirrored_x(p);
    return 0.95 * smooth_union(capsule(q, {30, -30, 15}, {17, 4, 13}, 13, 4.5),
                               sphere(q, {31, -38, 14}, 12), 4);
}

/// The vault of the skull, between two ellipsoids.
double skull(Vec3d p) {
    const double shell = cut(ellipsoid(p, {0, 34, 18}, {56.3, 79.5, 73}),
                             ellipsoid(p, {0, 34, 18}, {51.5, 74.5, 68.5}));
    const double lower_edge = 26 - 24 * ramp(-34, -6, p.y) - 20 * ramp(20, 50, p.y);
    return std::max(shell, 0.6 * (lower_edge - p.z));
}

void add_skin(LayerStack& stack) {
    stack.add(head, tissue(28, 8), 1.1);
    stack.add([](Vec3d p) { return head(p) + 1.5; }, tissue(-95, 9, 8, 5), 1.1);
    stack.add([](Vec3d p) { return 0.85 * (head(p) + 4 + 2 * value_noise(p * 0.1, 81)); },
              tissue(50, 9, 7, 3), 1.2);
    // fat of the cheeks and under the temples
    stack.add(
        [](Vec3d p) {
            const Vec3d q = mirrored_x(p);
            return 0.85 *
                   (ellipsoid(q, {42, -8, -16}, {7, 14, 16}) + 1.5 * value_noise(p * 0.15, 82));
        },
        tissue(-90, 9), 1.2);
}

void add_bone(LayerStack& stack) {
    const auto dense = tissue(780, 30, 60, 3);
    const auto spongy = tissue(330, 30, 90, 2);
    const auto face = [](Vec3d p) {
        const Vec3d q = mirrored_x(p);
        const double cheek = std::min(capsule(q, {22, -36, -2}, {43, -22, -1}, 4.6, 3.4),
                                      capsule(q, {43, -22, -1}, {53, 14, 2}, 3.2, 2.4));
        const double rim = capsule(q, {43, -22, 0}, {43, -28, 26}, 3.2, 3.6);
        const double gum = torus({p.x, 0.9 * p.y, 0.6 * p.z}, {0, -12, -19}, 20, 4.2);
        const double upper = std::max(gum, p.y + 2);
        const double wings = capsule(q, {13, 12, -4}, {17, 15, -32}, 2.4, 1.6);
        const double jaw = capsule(q, {48, 18, -8}, {42, 10, -60}, 3.6, 4.6);
        const double side = capsule(q, {42, 10, -60}, {27, -24, -58}, 4.6, 5.2);
        const double chin = capsule(q, {27, -24, -58}, {5, -38, -57}, 5.2, 6);
        return std::min({cheek, rim, upper, wings, jaw, side, chin});
    };
    stack.add(face, dense, 1.1);
    stack.add([=](Vec3d p) { return face(p) + 1.6; }, spongy, 1.1);
    // the base around the sphenoid, with the clivus and the temporal bones
    const auto base = [](Vec3d p) {
        const Vec3d q = mirrored_x(p);
        const double middle = box(p, {0, 21, 7}, {15, 13.5, 12}, 6);
        const double clivus = capsule(p, {0, 34, 10}, {0, 46, -18}, 7, 5);
        const double temporal = capsule(q, {20, 38, 2}, {50, 40, 4}, 7, 11);
        return smooth_union(smooth_union(middle, clivus, 4), temporal, 4);
    };
    stack.add(base, dense);
    stack.add([=](Vec3d p) { return base(p) + 1.8; }, spongy);
    stack.add(
        [](Vec3d p) {
            const Vec3d q = mirrored_x(p);
            double cells = 1e9;
            for (int n = 0; n < 6; ++n)
                cells = std::min(
                    cells, sphere(q, {40.0 + 3.6 * (n % 3), 41.0 + 5 * (n / 3), 1.5 * n}, 2.2));
            return cells;
        },
        uniform(-900));
    stack.add(skull, dense, 1.1);
    stack.add([](Vec3d p) { return skull(p) + 1.4; }, spongy, 1.1);
    stack.add([](Vec3d p) { return cranium(p, 2.0); }, dense, 2);
}

void add_mouth(LayerStack& stack) {
    const auto gap = [](Vec3d p) {
        const double dome = p.z + 34 + 0.012 * (p.x * p.x + 0.5 * (p.y + 8) * (p.y + 8));
        return std::max(0.9 * (std::abs(dome) - 0.7), ellipsoid(p, {0, -8, -36}, {15, 20, 16}));
    };
    stack.add(gap, uniform(kAirHu), 1.2);
    constexpr double kArch[7][2] = {{3, -34},    {8.5, -32.5}, {13, -29.5}, {16.5, -25},
                                    {19, -19.5}, {20.8, -13},  {22, -6}};
    for (const auto& at : kArch) {
        const double x = at[0], y = at[1];
        const auto upper = [=](Vec3d p) {
            return capsule(mirrored_x(p), {x, y, -30}, {x, y, -42}, 1.2, 2.7);
        };
        const auto lower = [=](Vec3d p) {
            return capsule(mirrored_x(p), {0.95 * x, y + 1, -60}, {0.95 * x, y + 1, -48.5}, 1.2,
                           2.5);
        };
        stack.add(upper, [](Vec3d p) { return 1250 + 700 * ramp(36, 40, -p.z); });
        stack.add(lower, [](Vec3d p) { return 1250 + 700 * ramp(54, 50, -p.z); });
    }
}

void add_brain(LayerStack& stack) {
    stack.add([](Vec3d p) { return cranium(p, 0); }, tissue(12, 7), 2);
    const auto brain = [](Vec3d p) {
        // folds: a sheet that winds through space, deep at the brain's surface only
        const Vec3d q =
            (1 / 13.0) * (p + 4.0 * Vec3d{value_noise(p * 0.06, 83), value_noise(p * 0.06, 84),
                                          value_noise(p * 0.06, 85)});
        const double sheet = wave(q.x) * wave(q.y + 0.25) + wave(q.y) * wave(q.z + 0.25) +
                             wave(q.z) * wave(q.x + 0.25);
        const double room = cranium(p, -1.6);
        const double sulcus = (0.8 - 4.2 * std::abs(sheet)) * ramp(-13, -4, room);
        const double gap = 1.0 - std::abs(p.x);
        return std::max({room, 0.45 * sulcus, gap});
    };
    stack.add(
        brain,
        [](Vec3d p) {
            return 36 + 3 * value_noise(p * 0.2, 86) + 6 * value_noise(p * (1 / 1.3), 11);
        },
        2);
    stack.add(
        [](Vec3d p) {
            const Vec3d q = mirrored_x(p);
            return smooth_union(capsule(q, {7, 8, 50}, {10, 45, 56}, 3.4, 4.4),
                                capsule(q, {10, 45, 56}, {16, 60, 46}, 4.4, 4), 3);
        },
        tissue(8, 6));
    // the sella with the gland, its stalk, and the carotid arteries at both sides
    stack.add([](Vec3d p) { return ellipsoid(p, {0, 25, 20.5}, {7.4, 6, 6.2}); }, tissue(62, 8));
    stack.add([](Vec3d p) { return capsule(p, {0, 25, 24}, {0, 23, 34}, 1.2, 1); }, tissue(60, 8));
    const ScalarField carotid = row_of_capsules(smooth_row({{{17, 32, -64}, 2.6},
                                                            {{17, 33, -6}, 2.6},
                                                            {{14.5, 29, 10}, 2.4},
                                                            {{11.5, 20, 17}, 2.3},
                                                            {{11, 19, 25}, 2.2},
                                                            {{14, 26, 30}, 2}},
                                                           5));
    stack.add([=](Vec3d p) { return carotid(mirrored_x(p)); }, tissue(110, 8));
}

void add_eyes(LayerStack& stack) {
    stack.add([](Vec3d p) { return std::max(orbit(p) - 1.1, -30 - p.y); }, tissue(560, 25), 1.2);
    stack.add([](Vec3d p) { return std::max(orbit(p), head(p) + 2); }, tissue(-92, 9), 1.2);
    const Vec3d globe{30, -34, 14};
    const Vec3d apex{18, 3, 13};
    for (const Vec3d& muscle : {Vec3d{10.5, 0, 0}, {-9.5, 0, 0}, {0, 0, 10.5}, {0, 0, -10.5}})
        stack.add(
            [=](Vec3d p) {
                return capsule(mirrored_x(p), globe + muscle + Vec3d{0, 3, 0}, apex, 1.5, 1.1);
            },
            tissue(58, 8));
    stack.add(
        [=](Vec3d p) {
            return capsule(mirrored_x(p), globe + Vec3d{-2, 11, 0}, apex, 1.9, 1.7);
        },
        tissue(38, 8));
    stack.add([=](Vec3d p) { return sphere(mirrored_x(p), globe, 11.4); }, tissue(66, 8));
    stack.add([=](Vec3d p) { return sphere(mirrored_x(p), globe, 10.3); }, tissue(12, 6));
    stack.add(
        [=](Vec3d p) {
            return ellipsoid(mirrored_x(p), globe + Vec3d{0, -7.4, 0}, {4.2, 1.9, 4.2});
        },
        tissue(95, 6));
}

}  // namespace

void add_head(LayerStack& stack) {
    add_skin(stack);
    add_bone(stack);
    add_mouth(stack);
    add_brain(stack);
    add_eyes(stack);
}

}  // namespace pliant::phantom
