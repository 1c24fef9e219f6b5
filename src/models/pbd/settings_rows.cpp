// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The tables of settings of bodies, rods and boxes. Units are any consistent set.

#include <pliant/pbd.h>

namespace pliant {
namespace {

using B = PbdSettings;
using R = RodSettings;
using X = PbdBoxSettings;

constexpr Setting<B> kBody[] = {
    setting<&B::time_step>(
        {.name = "time_step", .low = 0, .above_low = true, .text = "duration of a step"}),
    setting<&B::sub_steps>({.name = "sub_steps", .low = 1, .text = "sub-steps of a step"}),
    setting<&B::iterations>(
        {.name = "iterations", .low = 1, .text = "visits of each constraint in a sub-step"}),
    setting<&B::gravity>({.name = "gravity", .text = "acceleration of all particles"}),
    setting<&B::damping>({.name = "damping",
                          .low = 0,
                          .text = "of velocities [1/time]; at most one over the sub-step"}),
    setting<&B::method>({.name = "method",
                         .choices = "compliance|stiffness",
                         .text = "XPBD with compliance, or PBD with stiffness"}),
    setting<&B::precision>(
        {.name = "precision", .choices = "float|double", .text = "of the arithmetic"}),
    setting<&B::vectors>(
        {.name = "vectors", .text = "vector instructions; the scalar code gives the same bits"}),
    setting<&B::domain_particles>(
        {.name = "domain_particles", .low = 1, .text = "particles per domain"}),
    setting<&B::alternates>({.name = "alternates",
                             .text = "every second iteration visits the constraints in the "
                                     "opposite order"}),
    setting<&B::volume_recovery>({.name = "volume_recovery",
                                  .low = 0,
                                  .text =
                                      "rate [1/time] at which hard volumes recover under a lasting "
                                      "load; at most the damping"}),
    setting<&B::repacks>(
        {.name = "repacks", .text = "repacks the free constraints if many particles are held"}),
};

constexpr Setting<R> kRod[] = {
    setting<&R::segments>({.name = "segments", .low = 1, .high = 1e6, .text = "rigid segments"}),
    setting<&R::length>(
        {.name = "length", .low = 0, .above_low = true, .text = "of the whole rod"}),
    setting<&R::mass>({.name = "mass", .low = 0, .above_low = true, .text = "of the whole rod"}),
    setting<&R::bend_stiffness>(
        {.name = "bend_stiffness", .low = 0, .above_low = true, .text = "EI"}),
    setting<&R::twist_stiffness>(
        {.name = "twist_stiffness", .low = 0, .above_low = true, .text = "GJ"}),
    setting<&R::stretch_stiffness>(
        {.name = "stretch_stiffness", .low = 0, .above_low = true, .text = "EA"}),
    setting<&R::shear_stiffness>(
        {.name = "shear_stiffness", .low = 0, .above_low = true, .text = "GA"}),
    setting<&R::tip_segments>(
        {.name = "tip_segments", .low = 0, .high = 1e6, .text = "segments that steering bends"}),
    setting<&R::base>({.name = "base", .text = "position of its first end"}),
    setting<&R::time_step>(
        {.name = "time_step", .low = 0, .above_low = true, .text = "duration of a step"}),
    setting<&R::sub_steps>({.name = "sub_steps", .low = 1, .text = "sub-steps of a step"}),
    setting<&R::iterations>(
        {.name = "iterations", .low = 1, .text = "Newton iterations in a sub-step"}),
    setting<&R::gravity>({.name = "gravity", .text = "acceleration of all segments"}),
    setting<&R::damping>({.name = "damping",
                          .low = 0,
                          .text = "of velocities [1/time]; at most one over the sub-step"}),
};

constexpr Setting<X> kBoxes[] = {
    setting<&X::side>({.name = "side", .low = 0, .above_low = true, .text = "edge of a box"}),
    setting<&X::span>(
        {.name = "span", .text = "margin of a box on each side; negative: a third of its edge"}),
    setting<&X::index>({.name = "index",
                        .choices = "linear|hash",
                        .text = "number of a box: unique, or the paper's hash"}),
    setting<&X::blend_steps>(
        {.name = "blend_steps", .low = 1, .text = "steps from held to movable"}),
    setting<&X::settled>({.name = "settled",
                          .low = 0,
                          .text = "a box rests if all its particles are within this distance of "
                                  "their rest positions"}),
};

}  // namespace

SettingRows<PbdSettings> pbd_rows() noexcept {
    return kBody;
}
SettingRows<RodSettings> rod_rows() noexcept {
    return kRod;
}
SettingRows<PbdBoxSettings> pbd_box_rows() noexcept {
    return kBoxes;
}

}  // namespace pliant
