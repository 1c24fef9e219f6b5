// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The tables of settings of bodies and boxes. Units are any consistent set.

#include <pliant/models/pbd.h>

namespace pliant {
namespace {

using B = PbdSettings;
using X = PbdBoxSettings;

constexpr Setting<B> kBody[] = {
    setting<&B::time_step>({.name = "time_step",
                            .range = {.low = 0},
                            .above_low = true,
                            .text = "duration of a step"}),
    setting<&B::sub_steps>(
        {.name = "sub_steps", .range = {.low = 1}, .text = "sub-steps of a step"}),
    setting<&B::iterations>({.name = "iterations",
                             .range = {.low = 1},
                             .text = "visits of each constraint in a sub-step"}),
    setting<&B::gravity>({.name = "gravity", .text = "acceleration of all particles"}),
    setting<&B::damping>({.name = "damping",
                          .range = {.low = 0},
                          .text = "of velocities [1/time]; at most one over the sub-step"}),
    setting<&B::method>({.name = "method",
                         .choices = "compliance|stiffness",
                         .text = "XPBD with compliance, or PBD with stiffness"}),
    setting<&B::precision>(
        {.name = "precision", .choices = "float|double", .text = "of the arithmetic"}),
    setting<&B::vectors>(
        {.name = "vectors", .text = "vector instructions; the scalar code gives the same bits"}),
    setting<&B::domain_particles>(
        {.name = "domain_particles", .range = {.low = 1}, .text = "particles per domain"}),
    setting<&B::alternates>({.name = "alternates",
                             .text = "every second iteration visits the constraints in the "
                                     "opposite order"}),
    setting<&B::volume_recovery>({.name = "volume_recovery",
                                  .range = {.low = 0},
                                  .text =
                                      "rate [1/time] at which hard volumes recover under a lasting "
                                      "load; at most the damping"}),
    setting<&B::repacks>(
        {.name = "repacks", .text = "repacks the free constraints if many particles are held"}),
};

constexpr Setting<X> kBoxes[] = {
    setting<&X::side>(
        {.name = "side", .range = {.low = 0}, .above_low = true, .text = "edge of a box"}),
    setting<&X::span>(
        {.name = "span", .text = "margin of a box on each side; negative: a third of its edge"}),
    setting<&X::blend_steps>(
        {.name = "blend_steps", .range = {.low = 1}, .text = "steps from held to movable"}),
    setting<&X::settled>({.name = "settled",
                          .range = {.low = 0},
                          .text = "a box rests if all its particles are within this distance of "
                                  "their rest positions"}),
};

}  // namespace

SettingRows<PbdSettings> pbd_rows() noexcept {
    return kBody;
}
SettingRows<PbdBoxSettings> pbd_box_rows() noexcept {
    return kBoxes;
}

}  // namespace pliant
