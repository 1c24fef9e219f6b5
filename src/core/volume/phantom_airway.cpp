// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A chest with a windpipe for flights. The tree's surfaces consist of tubes (phantom_tubes.h). The
// wall is at least 1.6 mm thick, so that the iso surface at −500 HU is the lumen's even in front of
// lung. Cartilage is below the usual bone threshold, so rings can be pushed.

#include "volume/phantom_bodies.h"
#include "volume/phantom_noise.h"
#include "volume/phantom_tubes.h"

#include <memory>

namespace pliant::phantom {
namespace {

Tube bronchus(std::vector<TubePoint> row, Vec3d back, double wall_mm) {
    Tube tube;
    tube.points = smooth_row(row, 8);
    tube.back = normalized(back);
    tube.wall_mm = wall_mm;
    tube.ring_mm = 3.6;
    tube.ring_depth_mm = 0.09 * row.front().radius_mm;
    tube.flatness = 0.12;
    return tube;
}

std::vector<Tube> airway_tubes() {
    const Vec3d back{0, 1, 0};
    std::vector<Tube> tubes;
    Tube trachea = bronchus(
        {{{0.5, -6, 76}, 7.9}, {{0.8, -4.5, 45}, 7.8}, {{0.3, -2.7, 22}, 7.8}, {{0, -1, 6}, 7.7}},
        back, 2.1);
    trachea.ring_mm = 4.7;
    trachea.ring_depth_mm = 0.75;
    trachea.flatness = 0.24;
    tubes.push_back(trachea);
    // right: main, intermediate, lower lobe
    tubes.push_back(bronchus({{{-0.5, -1, 8}, 6.6},
                              {{-9, 0, -8}, 6.4},
                              {{-14.5, 1, -18}, 6.0},
                              {{-18, 2.5, -29}, 5.2},
                              {{-22, 7, -41}, 4.3},
                              {{-25, 11, -52}, 3.4}},
                             back, 1.9));
    tubes.push_back(bronchus({{{-12, 0.5, -13}, 4.6}, {{-21, 0, -11}, 4.2}, {{-29, -1.5, -7}, 3.5}},
                             {0.3, 0.6, -0.7}, 1.7));
    tubes.push_back(
        bronchus({{{-28, -1.4, -7.5}, 2.9}, {{-33, -2, 3}, 2.6}, {{-34, -3, 16}, 2.0}}, back, 1.6));
    tubes.push_back(bronchus(
        {{{-28, -1.4, -7.5}, 2.8}, {{-34, -10, -4}, 2.4}, {{-37, -20, -3}, 1.9}}, {0, 0, -1}, 1.6));
    tubes.push_back(bronchus({{{-28, -1.4, -7.5}, 2.8}, {{-35, 5, -2}, 2.4}, {{-38, 14, 2}, 1.9}},
                             {0, 0, -1}, 1.6));
    tubes.push_back(bronchus(
        {{{-17, 2, -26}, 3.8}, {{-23, -7, -35}, 3.3}, {{-29, -17, -40}, 2.6}, {{-34, -25, -43}, 2}},
        {-0.3, 0.5, 0.8}, 1.6));
    tubes.push_back(bronchus({{{-19, 4, -32}, 3.4}, {{-22, 14, -34}, 2.7}, {{-25, 22, -32}, 2}},
                             {0, 0, 1}, 1.6));
    tubes.push_back(bronchus({{{-24, 9, -47}, 2.8}, {{-32, 6, -52}, 2.3}, {{-39, 3, -54}, 1.8}},
                             {0, 1, 0}, 1.6));
    // left: main, lower lobe
    tubes.push_back(bronchus({{{0.5, -1, 8}, 6.0},
                              {{11, 0.5, -7}, 5.7},
                              {{21, 3.5, -16}, 5.2},
                              {{28, 7, -25}, 4.6},
                              {{32, 11, -38}, 3.9},
                              {{35, 14, -50}, 3.0}},
                             back, 1.9));
    tubes.push_back(bronchus({{{23, 4, -18}, 4.2}, {{33, 0.5, -18}, 3.9}, {{39, -6, -15}, 3.2}},
                             {0.2, 0.7, -0.6}, 1.7));
    tubes.push_back(
        bronchus({{{38, -5, -15.5}, 2.8}, {{40, -7, -4}, 2.5}, {{39, -6, 10}, 1.9}}, back, 1.6));
    tubes.push_back(bronchus({{{38, -5, -15.5}, 2.8}, {{41, -14, -22}, 2.4}, {{41, -23, -28}, 1.9}},
                             {0, 0.6, 0.7}, 1.6));
    tubes.push_back(bronchus({{{29, 8.5, -28}, 3.1}, {{31, 17, -30}, 2.5}, {{33, 24, -28}, 1.9}},
                             {0, 0, 1}, 1.6));
    tubes.push_back(
        bronchus({{{33, 12, -43}, 2.8}, {{39, 6, -48}, 2.3}, {{42, 0, -52}, 1.8}}, back, 1.6));
    return tubes;
}

/// Horseshoes in the wall.
double cartilage(const TubePosition& position) {
    const double shell = std::abs(position.smooth_mm - 1.05) - 0.5;
    return std::max({shell, 0.6 * (0.05 - position.ring), 2 * (position.back - 0.45)});
}

/// Landmark at the intersection of a ray and the wall, slightly inside the tissue.
PhantomLandmark landmark(const std::string& name, const ScalarField& lumen_inside, Vec3d eye,
                         Vec3d towards, Vec3d push) {
    constexpr double kInside_mm = 0.6;
    const Vec3d look = normalized(towards - eye);
    const Vec3d wall = walk_to_surface(lumen_inside, eye, look, 80);
    return {name, wall + kInside_mm * look, push, eye, look};
}

void add_landmarks(Model& model, const ScalarField& outside_lumen) {
    const Vec3d above{0.3, -2.2, 22};
    const Vec3d tip = walk_to_surface(outside_lumen, {-0.2, -1, 3}, {0, 0, -1}, 30);
    model.landmarks.push_back(landmark("carina", outside_lumen, above, tip, {6, 0, 0}));
    model.landmarks.push_back(
        landmark("wall", outside_lumen, {0.3, -1.8, 38}, {-8, -5, 16}, {-6, 0, 0}));
    model.landmarks.push_back(
        landmark("membrane", outside_lumen, {0.3, -5, 38}, {0, 4, 16}, {0, 5, 0}));
    model.landmarks.push_back(
        landmark("left_main", outside_lumen, {4, -0.7, 2}, {22, 1, -20}, {3, -3, -3}));
    model.landmarks.push_back(
        landmark("right_upper", outside_lumen, {-6.5, -0.4, -2}, {-16.5, 1, -17}, {4, 0, -4}));
}

}  // namespace

Model make_airway_model() {
    Model model;
    model.extent_mm = {128, 128, 128};
    const auto tree = std::make_shared<const TubeTree>(airway_tubes(), 2.2);
    add_chest(model.stack, [tree](Vec3d p) { return tree->outer(p); });
    model.stack.add([tree](Vec3d p) { return tree->outer(p); }, tissue(40, 9), 1.2);
    model.stack.add([tree](Vec3d p) { return cartilage(tree->find(p)); }, tissue(165, 12, 45, 2),
                    1.4);
    const ScalarField lumen = [tree](Vec3d p) {
        return tree->lumen(p) + 0.12 * value_noise(p * 0.45, 22);
    };
    model.stack.add(lumen, uniform(kAirHu), 1.45);
    add_landmarks(model, [lumen](Vec3d p) { return -lumen(p); });
    return model;
}

}  // namespace pliant::phantom
