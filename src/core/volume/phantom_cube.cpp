// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The homogeneous test set of [Draeger2005]: a cube of the value 2000 on the thesis's scale of
// 0…4095, which is 1000 HU, in air. That exceeds the usual bone threshold, which must be raised for
// pushes, as in the thesis.

#include "volume/layer_stack.h"
#include "volume/phantom_noise.h"

namespace pliant::phantom {

Model make_cube_model() {
    Model model;
    model.extent_mm = {100, 100, 100};
    model.stack.footprint_voxels = 1;
    constexpr double kHalf_mm = 30;
    model.stack.add(
        [](Vec3d p) {
            return box(p, {0, 0, 0}, {kHalf_mm, kHalf_mm, kHalf_mm});
        },
        uniform(1000));
    model.landmarks = {
        {"face", {0, -kHalf_mm + 0.5, 0}, {0, 6, 0}, {0, -46, 12}, normalized({0, 16, -12})},
        {"edge",
         {0, -kHalf_mm + 0.5, kHalf_mm - 1},
         {0, 6, 0},
         {0, -46, 42},
         normalized({0, 16, -12})},
        {"slanted", {10, -kHalf_mm + 0.5, 0}, {3, 5, 0}, {10, -46, 12}, normalized({0, 16, -12})}};
    model.key_values = {{"bone_threshold_hu", "1600"}};
    return model;
}

// The inhomogeneous test set of [Draeger2005]: a cuboid in air. Its upper half is soft (1000 on the
// thesis's scale of 0…4095, 0 HU); its lower half stiffens downwards (2000 to 2500, 1000…1500 HU).
// The lower half exceeds the usual bone threshold, which must be raised for pushes.

Model make_layers_model() {
    Model model;
    model.extent_mm = {100, 100, 100};
    model.stack.footprint_voxels = 1;
    constexpr Vec3d kHalf_mm{35, 25, 30};
    // The halves fill all space and air is added last, so that edges don't mix in other layers.
    model.stack.add([](Vec3d) { return -1e3; },
                    [=](Vec3d p) { return 1000 + 500 * clamp01(-p.z / kHalf_mm.z); });
    model.stack.add([](Vec3d p) { return -p.z; }, uniform(0));
    model.stack.add([=](Vec3d p) { return -box(p, {0, 0, 0}, kHalf_mm); }, uniform(kAirHu));
    const double face = -kHalf_mm.y + 0.5;
    const Vec3d look = normalized({0, 18, -10});
    model.landmarks = {{"border", {0, face, 0}, {0, 6, 0}, {0, -42, 10}, look},
                       {"soft", {0, face, 15}, {0, 6, 0}, {0, -42, 25}, look},
                       {"stiff", {0, face, -15}, {0, 6, 0}, {0, -42, -5}, look}};
    model.key_values = {{"bone_threshold_hu", "1600"}};
    return model;
}

}  // namespace pliant::phantom
