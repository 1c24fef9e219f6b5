// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The library's tissues behind the interface of tissue.h.
//
// @code
//   auto tissue = make_springs(scan, {.cell_mm = 8}, arena);
//   auto report = (*tissue)->push(1, {.point_mm = point, .push_mm = {5, 0, 0}});
// @endcode
//
//   "chainmail"  a lattice of limits: pushed at once, relaxed on request (chainmail.h)
//   "springs"    a mass-spring lattice (tissue.h)
//   "body"       tetrahedra, by position-based dynamics (pbd.h)
//   "network"    a mass-spring network with nodes of its own, such as an identified one
//                (network_file.h)
//   "vessel"     a wall around a lumen, moved by the catheter that is driven in it (drivable.h)
//   "rigid"      tissue that no tool can move

#pragma once

#include <pliant/catheter.h>
#include <pliant/chainmail.h>
#include <pliant/mesh.h>
#include <pliant/mesh_tissue.h>
#include <pliant/pbd.h>
#include <pliant/record.h>
#include <pliant/tissue.h>

#include <memory>
#include <span>

#pragma GCC visibility push(default)
namespace pliant {

/// Space of a tool that rests in the tissue of ChainMail after a push.
enum class RestingTool {
    KeepsTissueOut,  ///< held elements don't move, and no other tissue enters the sphere
    HoldsElements,   ///< held elements don't move
};

// The functions keep references: scan and arena must outlive the tissue. They return
// InvalidArgument that names the setting, and LimitExceeded if memory runs out.

Result<std::unique_ptr<Tissue>> make_chainmail(
    const Volume& scan, const ChainMailSettings& settings, const TaskArena& arena,
    RestingTool resting = RestingTool::KeepsTissueOut) noexcept;

/// Copies the elastic tissues of ChainMail's settings: the moduli of labels, and `elastic` as
/// modulus and Poisson's ratio. Values of the user's own are assigned afterwards.
Status take_materials(const ChainMailSettings& materials,
                      SpringDeformationSettings& settings) noexcept;

Result<std::unique_ptr<Tissue>> make_springs(const Volume& scan,
                                             const SpringDeformationSettings& settings,
                                             const TaskArena& arena) noexcept;

/// A body of tetrahedra, in mm, g and s.
struct BodySettings {
    double young_modulus_pa = 15e3;
    double poisson_ratio = 0.45;
    double density_kg_m3 = 1000;
    double damping_per_s = 5;  ///< of velocities
    double fixed_hu = 300;     ///< nodes at a larger value of the scan don't move
    double time_step_s = 1.0 / 60;
    std::int32_t sub_steps = 10;
    double reach_mm = 10;  ///< distance from the body at which the scan rests

    friend bool operator==(const BodySettings&, const BodySettings&) = default;
};
SettingRows<BodySettings> body_rows() noexcept;

/// Makes neo-Hookean tetrahedra in a scan. A tool holds the nodes in its sphere, or, if there are
/// none, the nodes of the tetrahedron around its point. It moves them in strides, with a time step
/// each, and holds nodes that the sphere meets on its way as well. Without a node the tool moves
/// freely. A tool that slides pushes the body's surface out of its sphere instead, until it is
/// released. A push or slide ends before a tetrahedron folds, and a slide before its centre enters
/// the body. force_n() is the force of the last sub-step; for a sphere, of the last step. A cut
/// separates tetrahedra by virtual nodes (cut_mesh.h); cut_links counts the scan's links. reset()
/// keeps cuts.
/// @param mesh  nodes [mm, LPS]
Result<std::unique_ptr<Tissue>> make_body(const Volume& scan, const TetMesh& mesh,
                                          const BodySettings& settings,
                                          const TaskArena& arena) noexcept;
/// Makes the tissue of a body with any constraints, in mm, g and s. Only reach_mm of the settings
/// has an effect.
/// @returns InvalidArgument for a body without volumes or solids, or with volume_recovery, whose
///          state can't be restored. A body with bends can't be cut
Result<std::unique_ptr<Tissue>> make_body(const Volume& scan, PbdBody body,
                                          const BodySettings& settings,
                                          const TaskArena& arena) noexcept;

/// A mass-spring network in a scan.
struct NetworkSettings {
    double time_step_s = 1.0 / 60;  ///< of implicit Euler
    double solve_tolerance = 1e-3;  ///< relative residual of a step's equations
    double reach_mm = 10;           ///< distance from the network at which the scan rests

    friend bool operator==(const NetworkSettings&, const NetworkSettings&) = default;
};
SettingRows<NetworkSettings> network_rows() noexcept;

/// Makes a network's tissue. All nodes move in each step, by implicit Euler, so that slivers don't
/// limit the time step. Tools hold nodes, or slide, as in make_body(); triangles with a fixed node
/// stop a slide. force_n() is the force of links and volumes on the held nodes.
/// @param parts  in mm (LPS), g and s; fixed nodes never move
/// @returns InvalidArgument for a network without cells, or beside the scan
Result<std::unique_ptr<Tissue>> make_network(const Volume& scan, SpringParts parts,
                                             const NetworkSettings& settings,
                                             const TaskArena& arena) noexcept;

/// Makes a vessel, whose wall moves the scan around it. No tool can push it: a catheter is driven.
/// An undo reverts all motion of a group, and stops the hand.
/// @returns errors of CatheterScene::create and CarriedScan::create
Result<std::unique_ptr<Tissue>> make_vessel(const Volume& scan, VesselWall wall,
                                            const CatheterSettings& settings,
                                            const TaskArena& arena) noexcept;

/// Makes a tissue that rejects every push, as bone does.
Result<std::unique_ptr<Tissue>> make_rigid(const Volume& scan, const TaskArena& arena) noexcept;

/// The models above, with the traits that don't depend on settings.
std::span<const TissueTraits> tissue_models() noexcept;

}  // namespace pliant
#pragma GCC visibility pop
