// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/tissues.h>

namespace pliant {
namespace {

using S = SpringDeformationSettings;

constexpr Setting<S> kRows[] = {
    setting<&S::cell_mm>({.name = "cell_mm",
                          .unit = "mm",
                          .range = {0, 1000},
                          .above_low = true,
                          .text = "edge of a control cell, rounded to whole voxels"}),
    setting<&S::young_modulus_pa>({.name = "young_modulus_pa",
                                   .unit = "Pa",
                                   .range = {1, 1e9},
                                   .text = "Young's modulus of tissue; air has a hundredth of it"}),
    setting<&S::poisson_ratio>({.name = "poisson_ratio",
                                .range = {0.25, 0.499},
                                .text = "Poisson's ratio of tissue; air has 0.25, that of links"}),
    setting<&S::air_threshold_hu>(
        {.name = "air_threshold_hu", .unit = "HU", .text = "smaller values are air"}),
    setting<&S::fixed_hu>({.name = "fixed_hu",
                           .unit = "HU",
                           .text = "nodes with a larger mean value around them don't move"}),
    setting<&S::fixed_share>({.name = "fixed_share",
                              .range = {0, 1},
                              .text = "nor do those of cells with a larger share of such voxels"}),
    setting<&S::depth>({.name = "depth",
                        .unit = "layers",
                        .range = {0, 1e6},
                        .text = "layers of nodes that forces reach beyond a tool"}),
    setting<&S::damping_s>({.name = "damping_s",
                            .unit = "s",
                            .range = {1e-4, 1e4},
                            .text = "time in which free motion dies away to 1/e"}),
};

}  // namespace

SettingRows<SpringDeformationSettings> spring_rows() noexcept {
    return kRows;
}

}  // namespace pliant
