// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A forking carotid artery with contrast agent and a stenosis: circular soft plaque and a calcified
// plaque on one side, in fat and muscle. The contrast is 250 HU, less than in practice, because
// values above the usual bone threshold of 300 HU would be immobile; only the calcified plaque and
// the spine are. The lumen's surface is at 160 HU, with falling values.

#include "volume/layer_stack.h"
#include "volume/phantom_noise.h"
#include "volume/phantom_tubes.h"

#include <memory>

namespace pliant::phantom {
namespace {

std::vector<Tube> artery_tubes() {
    Tube trunk;
    trunk.points = smooth_row({{{-9, 7, -60}, 3.8},
                               {{-6, 3, -36}, 3.8},
                               {{2, -4, -18}, 3.9},
                               {{6, -6, -7}, 3.3},
                               {{6.8, -5, 0}, 1.7},
                               {{6, -2.5, 6}, 1.5},
                               {{4, 0, 13}, 2.9},
                               {{0, 4, 24}, 3.2},
                               {{-3, 8, 42}, 3.1},
                               {{-2, 9, 60}, 3.1}},
                              16);
    trunk.wall_mm = 1.1;
    Tube branch;
    branch.points = smooth_row({{{3, -5, -17}, 2.4},
                                {{12, -11, -4}, 2.5},
                                {{19, -11, 14}, 2.2},
                                {{21, -7, 34}, 2},
                                {{19, -4, 60}, 1.9}},
                               16);
    branch.wall_mm = 0.9;
    return {trunk, branch};
}

double neck(Vec3d p) {
    return 0.9 * (std::sqrt(p.x * p.x * 0.6 + (p.y - 30) * (p.y - 30)) - 60);
}

void add_surroundings(LayerStack& stack) {
    stack.add(neck, tissue(25, 8));
    stack.add([](Vec3d p) { return neck(p) + 1.6; }, tissue(-100, 9, 7, 5));
    const auto muscle = [&stack](Vec3d a, Vec3d b, double ra, double rb) {
        stack.add(
            [=](Vec3d p) {
                const double folds = 0.5 * value_noise({p.x * 0.3, p.y * 0.3, p.z * 0.08}, 61);
                return 0.85 * (capsule(p, a, b, ra, rb) + folds);
            },
            tissue(56, 9, 6, 2.5));
    };
    muscle({33, -8, -70}, {35, 2, 70}, 8, 9);
    muscle({-22, -18, -70}, {-18, -19, 70}, 4, 4.5);
    muscle({2, -19, -70}, {-2, -19, 70}, 3.5, 3.5);
    muscle({24, 22, -70}, {27, 26, 70}, 10, 10);
    muscle({-24, 25, -70}, {-22, 26, 70}, 10, 9);
    muscle({3, 24, -70}, {2, 25, 70}, 7, 7);
    // the windpipe beside it
    const auto windpipe = [](Vec3d p) { return stadium(p.x + 27, p.y + 1, 1.5, 7.5); };
    stack.add([=](Vec3d p) { return windpipe(p) - 3.4; }, tissue(62, 9));
    stack.add([=](Vec3d p) { return windpipe(p) - 2; }, tissue(140, 9, 20, 3));
    stack.add([=](Vec3d p) { return windpipe(p) - 0.9; }, tissue(40, 9));
    stack.add(windpipe, uniform(kAirHu));
    const auto spine = [](Vec3d p) {
        const double z = p.z - 20 * std::floor(p.z / 20 + 0.5);
        const double column = ellipsoid({p.x, p.y, 0}, {2, 42, 0}, {15, 10, 15});
        return smooth_intersection(column + 1.2 * bump(z, 5), std::abs(z) - 8.2, 2);
    };
    stack.add(
        [](Vec3d p) {
            return ellipsoid({p.x, p.y, 0}, {2, 42, 0}, {15, 10, 15});
        },
        tissue(85, 8));
    stack.add(spine, tissue(650, 20, 50, 3), 1.2);
    stack.add([=](Vec3d p) { return spine(p) + 1.3; }, tissue(220, 20, 70, 1.6), 1.2);
    const ScalarField vein = row_of_capsules(smooth_row(
        {{{8, 8, -70}, 5.6}, {{17, 6, -20}, 6.2}, {{17, 8, 20}, 5.4}, {{12, 12, 70}, 4.8}}, 5));
    stack.add([=](Vec3d p) { return vein(p) - 0.6; }, tissue(60, 9));
    stack.add(vein, tissue(120, 9));
}

}  // namespace

Model make_vessel_model() {
    Model model;
    model.extent_mm = {80, 80, 80};
    const auto tree = std::make_shared<const TubeTree>(artery_tubes(), 1.6);
    const ScalarField lumen = [tree](Vec3d p) { return tree->lumen(p); };
    const Vec3d narrow{6.5, -4, 3};
    const auto plaque = [=](Vec3d p) { return ellipsoid(p, narrow, {5, 5, 10}); };
    const auto calcified = [](Vec3d p) {
        return 0.8 * (ellipsoid(p, {10.5, -4.2, 2.5}, {1.2, 2.3, 4}) + 0.3 * value_noise(p, 62));
    };
    LayerStack& stack = model.stack;
    add_surroundings(stack);
    stack.add([=](Vec3d p) { return smooth_union(tree->outer(p), plaque(p) - 1, 2); },
              tissue(70, 9), 1.2);
    stack.add([=](Vec3d p) { return 0.8 * (plaque(p) + 0.5 * value_noise(p * 0.7, 63)); },
              tissue(42, 9, 8, 1.5), 1.2);
    stack.add(calcified, tissue(720, 30), 1.2);
    stack.add(lumen, tissue(250, 8), 1.2);

    const Vec3d eye{-0.5, -1.5, -23};
    const auto look_at = [&](Vec3d from, Vec3d target) { return normalized(target - from); };
    const auto wall = [&](Vec3d from, Vec3d towards) {
        const Vec3d u = normalized(towards);
        return walk_to_surface([&](Vec3d p) { return -lumen(p); }, from, u, 20) + 0.5 * u;
    };
    const Vec3d shoulder = wall({6.2, -6, -5.5}, {-1, 0.6, 0.2});
    const Vec3d side = wall({-2.4, 0, -26.5}, {-0.8, -0.5, -0.9});
    const Vec3d near{4.4, -5.2, -11};
    model.landmarks = {{"stenosis", shoulder, {-2.5, 1.5, 0.5}, near, look_at(near, shoulder)},
                       {"wall", side, {-3, -1.5, 0}, eye, look_at(eye, side)},
                       {"plaque", {10.5, -4.2, 2.5}, {2, 0, 0}, near, look_at(near, {7, -4.5, 0})}};
    model.key_values = {{"iso_hu", "160"}, {"polarity", "falling"}};
    return model;
}

}  // namespace pliant::phantom
