// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tissues for force feedback, below a surface at z = 0.

#pragma once

#include <pliant/models/catheter.h>
#include <pliant/view/haptics.h>

#include <memory>
#include <string>

#include "haptic_run.h"
#include "value_of.h"

namespace pliant::results {

inline constexpr double kDevice_n_m = 1000;  ///< the Phantom Desktop's largest stiffness

/// Rigid wall: K alone.
HapticModel wall(double stiffness_n_m);
/// Model of a simulation that provides forces only.
HapticModel force_of_wall(double stiffness_n_m, Vec3d tool_mm);
/// F = 80 d + 30'000 d² [N, m].
HapticTissue hardening();

/// Air over tissue of 40 HU over bone from a depth on.
std::shared_ptr<const Volume> layers(double bone_depth_mm);
/// The wall of a scan with ChainMail's model; the tool's radius is above the surface.
HapticTissue chainmail(std::shared_ptr<const Volume> volume, const TaskArena& arena);
/// Model of a tool that pushes the nodes which it holds beyond a surface, in the scene's units (mm,
/// g, s). It assumes that the other nodes follow to their equilibrium.
/// @param last  estimate for the same contact, or null. Near an instability ReactionLaw::Relaxed is
///              too stiff; the last solution's force corrects that
/// @returns an error of SpringTissue::reaction
Result<HapticModel> model_of_springs(SpringTissue& tissue, std::span<const std::int32_t> held,
                                     Vec3d surface_mm, Vec3d normal, Vec3d position_mm,
                                     LearntStiffness* last = nullptr);
/// A lattice of 6 × 6 × 6 nodes, four of them pressed, at its equilibrium.
HapticTissue springs();
/// Force of the same lattice at its equilibrium [N].
double static_force_of_springs_n(double depth_mm);
/// A stiff wire in a soft bend of few elements, in steps of 4 ms.
CatheterScene wire_in_bend();
/// The wire in the hand: down is forward.
HapticTissue vessel(const TaskArena& arena);
/// A neo-Hookean block of 4 × 4 × 4 cells, in time steps of 33 ms.
HapticTissue pbd(const TaskArena& arena);

}  // namespace pliant::results
