// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A stretched right knee: femur, tibia, fibula and patella with their cortical shells, cartilage
// and menisci between them, tendons, muscles and vessels behind, in fat and skin. Bones exceed the
// usual bone threshold of 300 HU and don't move, and the tissue around them is soft: the case that
// [Choi2004, 4.2.2] deforms by a control lattice.

#include "volume/layer_stack.h"
#include "volume/phantom_noise.h"

namespace pliant::phantom {
namespace {

double leg(Vec3d p) {
    const double shaft = capsule(p, {0, 6, 150}, {0, 8, -150}, 78, 58);
    return smooth_union(shaft, ellipsoid(p, {0, -2, 4}, {58, 60, 50}), 20);
}

double femur(Vec3d p) {
    const double shaft = capsule(p, {0, 2, 130}, {0, 2, 30}, 13, 18);
    const double condyles = ellipsoid(mirrored_x(p), {22, 6, 14}, {19, 28, 20});
    const double whole = smooth_union(shaft, condyles, 16);
    return cut(whole, capsule(p, {0, 40, 2}, {0, 10, -8}, 8, 7));  // the notch between the condyles
}

double tibia(Vec3d p) {
    const double head = smooth_intersection(ellipsoid(p, {0, 5, -26}, {41, 27, 24}), p.z + 11, 4);
    return smooth_union(head, capsule(p, {0, 2, -36}, {2, 4, -130}, 21, 14), 14);
}

double fibula(Vec3d p) {
    return smooth_union(sphere(p, {-33, 20, -28}, 9),
                        capsule(p, {-33, 20, -30}, {-30, 16, -130}, 6, 6), 8);
}

double patella(Vec3d p) {
    return ellipsoid(p, {0, -39, 16}, {21, 9, 22});
}

/// Spongy bone in a dense shell.
void add_bone(LayerStack& stack, const ScalarField& shape, double shell_mm) {
    stack.add(shape, tissue(1150, 30, 60, 4));
    stack.add([=](Vec3d p) { return shape(p) + shell_mm; }, tissue(430, 25, 50, 2));
}

void add_soft_parts(LayerStack& stack) {
    stack.add(leg, tissue(25, 8));
    stack.add([](Vec3d p) { return leg(p) + 1.8; }, tissue(-100, 9, 7, 5));
    const auto muscle = [&stack](Vec3d a, Vec3d b, double ra, double rb) {
        stack.add(
            [=](Vec3d p) {
                const double folds = 0.5 * value_noise({p.x * 0.25, p.y * 0.25, p.z * 0.05}, 71);
                return 0.85 * (capsule(p, a, b, ra, rb) + folds);
            },
            tissue(58, 9, 6, 2.5));
    };
    for (const double side : {-1.0, 1.0}) {
        muscle({side * 30, -18, 130}, {side * 26, -22, 44}, 27, 10);  // of the thigh, in front
        muscle({side * 24, 38, 130}, {side * 30, 40, 20}, 21, 8);     // and behind
        muscle({side * 21, 40, 26}, {side * 20, 34, -130}, 8, 21);    // of the calf
    }
    muscle({-24, -6, -44}, {-26, -10, -130}, 7, 14);
    const ScalarField artery = [](Vec3d p) {
        return capsule(p, {4, 40, 130}, {2, 36, -130}, 3.4, 3);
    };
    stack.add([=](Vec3d p) { return artery(p) - 1; }, tissue(60, 9));
    stack.add(artery, tissue(45, 9));
    const auto tendon = [&stack](Vec3d a, Vec3d b, double ra, double rb) {
        stack.add([=](Vec3d p) { return capsule(p, a, b, ra, rb); }, tissue(105, 9));
    };
    tendon({0, -40, 34}, {0, -34, 120}, 7, 10);
    tendon({0, -42, 0}, {0, -30, -46}, 6, 7);
    tendon({45, 4, 26}, {42, 4, -40}, 4, 4);
    tendon({-45, 4, 26}, {-36, 16, -28}, 4, 4);
}

}  // namespace

Model make_knee_model() {
    Model model;
    model.extent_mm = {160, 160, 200};
    LayerStack& stack = model.stack;
    add_soft_parts(stack);
    // Cartilage between adjacent bones, and the menisci.
    stack.add([](Vec3d p) { return smooth_intersection(femur(p) - 2.4, p.z - 22, 3); },
              tissue(115, 9));
    stack.add([](Vec3d p) { return smooth_intersection(tibia(p) - 2.2, -p.z - 17, 3); },
              tissue(115, 9));
    stack.add([](Vec3d p) { return torus(mirrored_x(p), {21, 5, -8}, 15, 3.6); }, tissue(85, 9));
    stack.add([](Vec3d p) { return patella(p) - 2; }, tissue(115, 9));
    add_bone(stack, femur, 2.6);
    add_bone(stack, tibia, 2.6);
    add_bone(stack, fibula, 1.8);
    add_bone(stack, patella, 2);

    // Pushes from outside; views from the front.
    const auto skin = [](Vec3d from, Vec3d towards) {
        return walk_to_surface(leg, from, normalized(towards), 120);
    };
    const auto add_landmark = [&](const char* name, Vec3d from, Vec3d push) {
        const Vec3d way = normalized(push);
        const Vec3d position = skin(from, way) + 3.0 * way;
        model.landmarks.push_back({name, position, push, position - 40.0 * way, way});
    };
    add_landmark("fat_pad", {14, -120, -22}, {0, 9, 0});
    add_landmark("thigh", {-30, -130, 70}, {0, 12, 0});
    add_landmark("calf", {0, 130, -60}, {0, -12, 0});
    return model;
}

}  // namespace pliant::phantom
