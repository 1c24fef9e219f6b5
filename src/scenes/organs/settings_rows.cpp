// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/organs.h>

namespace pliant {
namespace {

using O = OrganSettings;
using C = OrganContents;
using F = OrganFile;

constexpr double kLowestLabel = -2147483648.0, kHighestLabel = 2147483647.0;

constexpr Setting<O> kBody[] = {
    setting<&O::name>({.table = "body",
                       .name = "name",
                       .text = "in messages and reports; empty: that of its label"}),
    setting<&O::mesh>({.table = "body",
                       .name = "mesh",
                       .text = "file of tetrahedra, or of a closed surface, which is filled"}),
    setting<&O::labels>({.table = "body",
                         .name = "labels",
                         .low = kLowestLabel,
                         .high = kHighestLabel,
                         .text = "of the label volume: the voxels that it carries, and its mesh "
                                 "if there is no file"}),
    setting<&O::law>({.table = "body",
                      .name = "law",
                      .choices = "solid|distances|springs",
                      .text = "neo-Hookean tetrahedra, edges and volumes, or a mass-spring "
                              "network (a single body)"}),
    setting<&O::young_modulus_pa>({.table = "body",
                                   .name = "young_modulus_pa",
                                   .unit = "Pa",
                                   .low = 1,
                                   .high = 1e9,
                                   .text = "Young's modulus"}),
    setting<&O::poisson_ratio>({.table = "body",
                                .name = "poisson_ratio",
                                .low = 0,
                                .high = 0.5,
                                .above_low = true,
                                .below_high = true,
                                .text = "Poisson's ratio"}),
    setting<&O::density_kg_m3>({.table = "body",
                                .name = "density_kg_m3",
                                .unit = "kg/m³",
                                .low = 1,
                                .high = 1e5,
                                .text = "density"}),
    setting<&O::held_back>({.table = "body",
                            .name = "held_back",
                            .low = 0,
                            .high = 1,
                            .text = "share of its depth, from the back, that doesn't move"}),
    setting<&O::held_mm>({.table = "body",
                          .name = "held_mm",
                          .unit = "mm, LPS",
                          .text = "opposite corners of boxes whose nodes don't move, in pairs"}),
};

constexpr Setting<C> kContents[] = {
    setting<&C::surface>(
        {.table = "contents", .name = "surface", .text = "file of a closed surface"}),
    setting<&C::value_hu>({.table = "contents",
                           .name = "value_hu",
                           .unit = "HU",
                           .low = -1000,
                           .high = 3000,
                           .text = "its value in the scan"}),
};

constexpr Setting<F> kFile[] = {
    setting<&F::scan>({.table = "organs",
                       .name = "scan",
                       .text = "file of the scan that they lie in; without it one is made"}),
    setting<&F::label_volume>(
        {.table = "organs", .name = "label_volume", .text = "file of its labels"}),
    setting<&F::label_names>(
        {.table = "organs",
         .name = "label_names",
         .text = "file of their names (JSON, .ctbl, .csv, ITK-SNAP's); empty: the label volume's "
                 "own, or one beside it"}),
    setting<&F::tetrahedra>({.table = "organs",
                             .name = "tetrahedra",
                             .low = 100,
                             .high = 2'000'000,
                             .text = "approximate number in each mesh that is made"}),
    setting<&F::smoothing_voxels>({.table = "organs",
                                   .name = "smoothing_voxels",
                                   .unit = "voxels",
                                   .low = 0,
                                   .high = 20,
                                   .text = "standard deviation of the smoothing of labels"}),
    setting<&F::surroundings>({.table = "organs",
                               .name = "surroundings",
                               .text = "a body of the scan's other tissue, without air"}),
    setting<&F::surroundings_mm>({.table = "organs",
                                  .name = "surroundings_mm",
                                  .unit = "mm",
                                  .low = 1,
                                  .high = 500,
                                  .text = "thickness of that around the organs"}),
    setting<&F::surroundings_pa>({.table = "organs",
                                  .name = "surroundings_pa",
                                  .unit = "Pa",
                                  .low = 1,
                                  .high = 1e9,
                                  .text = "its Young's modulus"}),
    setting<&F::fixed_hu>({.table = "organs",
                           .name = "fixed_hu",
                           .unit = "HU",
                           .low = -32768,
                           .high = 65504,
                           .text = "nodes at a larger value of the scan don't move"}),
    setting<&F::fixed_near_mm>({.table = "organs",
                                .name = "fixed_near_mm",
                                .unit = "mm",
                                .low = 0,
                                .high = 100,
                                .text = "nor do those within this distance of one"}),
    setting<&F::friction>({.table = "organs",
                           .name = "friction",
                           .low = 0,
                           .high = 10,
                           .text = "Coulomb's coefficient, of tools and between organs"}),
    setting<&F::damping_per_s>({.table = "organs",
                                .name = "damping_per_s",
                                .unit = "1/s",
                                .low = 0,
                                .high = 1e4,
                                .text = "damping of velocities"}),
    setting<&F::time_step_s>({.table = "organs",
                              .name = "time_step_s",
                              .unit = "s",
                              .low = 1e-5,
                              .high = 0.1,
                              .text = "simulated time of a step"}),
    setting<&F::sub_steps>({.table = "organs",
                            .name = "sub_steps",
                            .low = 1,
                            .high = 1000,
                            .text = "sub-steps of a time step"}),
    setting<&F::reach_mm>({.table = "organs",
                           .name = "reach_mm",
                           .unit = "mm",
                           .low = 0,
                           .high = 1000,
                           .above_low = true,
                           .text = "distance from the bodies at which the scan rests"}),
};

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
