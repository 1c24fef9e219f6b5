// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/organs.h>

namespace pliant {
namespace {

using O = OrganSettings;
using C = OrganContents;
using F = OrganFile;

constexpr double kLowestLabel = -2147483648.0, kHighestLabel = 2147483647.0;

constexpr Setting<O> kBodyRows[] = {
    setting<&O::name>(
        {.name = "name", .text = "in messages and reports; empty: that of its label"}),
    setting<&O::mesh>(
        {.name = "mesh", .text = "file of tetrahedra, or of a closed surface, which is filled"}),
    setting<&O::labels>({.name = "labels",
                         .range = {kLowestLabel, kHighestLabel},
                         .text = "of the label volume: the voxels that it carries, and its mesh "
                                 "if there is no file"}),
    setting<&O::law>({.name = "law",
                      .choices = "solid|distances|springs|ogden",
                      .text = "neo-Hookean tetrahedra, edges and volumes, a mass-spring network (a "
                              "single body), or tetrahedra of Ogden's law"}),
    setting<&O::young_modulus_pa>(
        {.name = "young_modulus_pa", .unit = "Pa", .range = {1, 1e9}, .text = "Young's modulus"}),
    setting<&O::poisson_ratio>({.name = "poisson_ratio",
                                .range = {0, 0.5},
                                .above_low = true,
                                .below_high = true,
                                .text = "Poisson's ratio"}),
    setting<&O::ogden_alpha>({.name = "ogden_alpha",
                              .range = {-40, 40},
                              .text = "exponent of the stretches in Ogden's law, −40 to −1 "
                                      "(stiffer in compression) or 2 to 40"}),
    setting<&O::density_kg_m3>(
        {.name = "density_kg_m3", .unit = "kg/m³", .range = {1, 1e5}, .text = "density"}),
    setting<&O::held_back>({.name = "held_back",
                            .range = {0, 1},
                            .text = "share of its depth, from the back, that doesn't move"}),
    setting<&O::held_mm>({.name = "held_mm",
                          .unit = "mm, LPS",
                          .text = "opposite corners of boxes whose nodes don't move, in pairs"}),
};
constexpr auto kBody = in_table("body", kBodyRows);

constexpr Setting<C> kContentsRows[] = {
    setting<&C::surface>({.name = "surface", .text = "file of a closed surface"}),
    setting<&C::value_hu>({.name = "value_hu",
                           .unit = "HU",
                           .range = {-1000, 3000},
                           .text = "its value in the scan"}),
};
constexpr auto kContents = in_table("contents", kContentsRows);

constexpr Setting<F> kOrgansRows[] = {
    setting<&F::scan>(
        {.name = "scan", .text = "file of the scan that they lie in; without it one is made"}),
    setting<&F::label_volume>({.name = "label_volume", .text = "file of its labels"}),
    setting<&F::label_names>(
        {.name = "label_names",
         .text = "file of their names (JSON, .ctbl, .csv, ITK-SNAP's); empty: the label volume's "
                 "own, or one beside it"}),
    setting<&F::units>(
        {.name = "units", .choices = "mm|cm|m", .text = "unit of lengths in the meshes' files"}),
    setting<&F::tetrahedra>({.name = "tetrahedra",
                             .range = {100, 2'000'000},
                             .text = "approximate number in each mesh that is made"}),
    setting<&F::smoothing_voxels>({.name = "smoothing_voxels",
                                   .unit = "voxels",
                                   .range = {0, 20},
                                   .text = "standard deviation of the smoothing of labels"}),
    setting<&F::surroundings>(
        {.name = "surroundings", .text = "a body of the scan's other tissue, without air"}),
    setting<&F::surroundings_mm>({.name = "surroundings_mm",
                                  .unit = "mm",
                                  .range = {1, 500},
                                  .text = "thickness of that around the organs"}),
    setting<&F::surroundings_pa>({.name = "surroundings_pa",
                                  .unit = "Pa",
                                  .range = {1, 1e9},
                                  .text = "its Young's modulus"}),
    setting<&F::fixed_hu>({.name = "fixed_hu",
                           .unit = "HU",
                           .range = {-32768, 65504},
                           .text = "nodes at a larger value of the scan don't move"}),
    setting<&F::fixed_near_mm>({.name = "fixed_near_mm",
                                .unit = "mm",
                                .range = {0, 100},
                                .text = "nor do those within this distance of one"}),
    setting<&F::friction>({.name = "friction",
                           .range = {0, 10},
                           .text = "Coulomb's coefficient, of tools and between organs"}),
    setting<&F::damping_per_s>({.name = "damping_per_s",
                                .unit = "1/s",
                                .range = {0, 1e4},
                                .text = "damping of velocities"}),
    setting<&F::time_step_s>({.name = "time_step_s",
                              .unit = "s",
                              .range = {1e-5, 0.1},
                              .text = "simulated time of a step"}),
    setting<&F::sub_steps>(
        {.name = "sub_steps", .range = {1, 1000}, .text = "sub-steps of a time step, at least"}),
    setting<&F::reach_mm>({.name = "reach_mm",
                           .unit = "mm",
                           .range = {0, 1000},
                           .above_low = true,
                           .text = "distance from the bodies at which the scan rests"}),
};
constexpr auto kFile = in_table("organs", kOrgansRows);

}  // namespace

SettingRows<OrganSettings> organ_rows() noexcept {
    return kBody;
}
SettingRows<OrganContents> organ_contents_rows() noexcept {
    return kContents;
}
SettingRows<OrganFile> organ_file_rows() noexcept {
    return kFile;
}

}  // namespace pliant
