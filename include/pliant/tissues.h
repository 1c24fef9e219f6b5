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
//   "elastic"    linear elasticity with large rotations on the scan's voxels
//   "springs"    a mass-spring lattice around a scan's tissue
//   "body"       tetrahedra, by position-based dynamics (pbd.h)
//   "network"    a mass-spring network with nodes of its own, such as an identified one
//                (network_file.h)
//   "vessel"     a wall around a lumen, moved by the catheter that is driven in it (drivable.h)
//   "rigid"      tissue that no tool can move

#pragma once

#include <pliant/chainmail.h>
#include <pliant/core/record.h>
#include <pliant/deformation.h>
#include <pliant/mesh.h>
#include <pliant/models/catheter.h>
#include <pliant/models/elastic_scan.h>
#include <pliant/models/material.h>
#include <pliant/models/mesh_tissue.h>
#include <pliant/models/pbd.h>
#include <pliant/models/scan_tissue.h>
#include <pliant/models/springs.h>
#include <pliant/own_tissue.h>
#include <pliant/resample.h>
#include <pliant/result.h>
#include <pliant/tissue.h>
#include <pliant/tool.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

// A scan deformed by springs: a network of control nodes over a region of the scan [Choi2004,
// 4.2.2] moves by force transmittal, and the voxels are embedded in its cells.
//
// @code
//   auto tissue = make_springs(volume, {.cell_mm = 8}, arena);
//   auto push = (*tissue)->push(1, {.point_mm = point, .push_mm = {5, 0, 0}});  // tool 1 grabs
//   (*tissue)->advance({});                                                     // until at rest
//   Result<Deformed> deformed = deform_volume(**tissue);
// @endcode
//
// A tool holds its nodes until it lets go. Time advances only in steps, so the result depends on
// the calls alone. It is bit-identical for any number of threads.

struct SpringDeformationSettings {
    Box3i region{};                  ///< voxels that may move; empty: the whole scan
    double cell_mm = 8;              ///< edge of a control cell, rounded to whole voxels
    double young_modulus_pa = 15e3;  ///< of tissue; air has 1 % of it
    double poisson_ratio = 0.25;  ///< of tissue; above 1/4 control cells resist changes of volume
    double air_threshold_hu = -500;  ///< smaller values are air
    double fixed_hu = 300;           ///< nodes with a larger mean value around them are fixed
    double fixed_share = 0.05;       ///< cells with a larger share of such voxels have fixed nodes
    std::int32_t depth = 10;         ///< layers of nodes that forces reach around a tool
    /// Time in which free motion decays to 1/e [s].
    double damping_s = 0.005;
    /// Tissues by label: `elastic` and law Immobile have an effect, and bone_threshold_hu as
    /// fixed_hu. Voxels of law Constant aren't fixed by their value.
    std::vector<LabelMaterial> label_materials{};
    std::shared_ptr<const Volume> labels{};  ///< on the scan's grid; required by label_materials

    friend bool operator==(const SpringDeformationSettings&,
                           const SpringDeformationSettings&) = default;
};
/// Rows of these settings, except the region and labels.
SettingRows<SpringDeformationSettings> spring_rows() noexcept;

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

/// Copies the labels of ChainMail's settings and their moduli.
Status take_materials(const ChainMailSettings& materials,
                      SpringDeformationSettings& settings) noexcept;
/// Copies the tissues of labels.
Status take_materials(const ChainMailSettings& materials, ElasticScanSettings& settings) noexcept;

/// Makes springs around a scan. A tool grabs the free nodes of the cell that holds its point, or
/// the free nodes in its sphere, and moves them while time advances; a push stops before a control
/// cell folds. grabbed_elements and moved_elements count nodes. Released tissue returns, and
/// finally has its original positions, bit for bit. A step of advance() is a time step, a sweep()
/// ten. A cut ends links and volumes that it crosses, and tools keep their nodes. force_n() is the
/// force with the other nodes held. take_depth() compares equilibria with the present tools
/// [Choi2004, 3.1.3].
/// @returns LimitExceeded above a million nodes
Result<std::unique_ptr<Tissue>> make_springs(const Volume& scan,
                                             const SpringDeformationSettings& settings,
                                             const TaskArena& arena) noexcept;

/// Makes the elastic scan: equilibrium of the scan's voxels under its tools, in newtons. A tool
/// holds the tissue in its sphere, or the voxels of the cell around its point, and moves them in
/// strides; tissue that the sphere meets on its way is held as well. A sphere that slides pushes
/// tissue to its surface instead. A drag holds the tissue of its beginning, and extrapolates its
/// steps. Where a cell of tissue would fold, the tool slips; if that doesn't suffice, the push ends
/// (LimitedBy::Fold). It ends as well before the sphere enters bone. Cuts and carving soften
/// cells; walls that meet across air touch. Sweeps improve the solution while tools rest, and let
/// released tissue return; settled is equilibrium, or 30 sweeps after the last motion of a tool.
/// force_n() is the force of the present solution. Without moduli, those of suit_elastic() for CT
/// are used.
/// @returns InvalidArgument that names the setting, and for a scan of one slice
Result<std::unique_ptr<Tissue>> make_elastic(const Volume& scan,
                                             const ElasticScanSettings& settings,
                                             const TaskArena& arena) noexcept;

/// Reads the table [elastic] of a settings file (TOML) over the settings that suit a scan's values.
/// The file may have ChainMail's tables as well, whose keys read_chainmail_settings() checks.
/// @returns errors that name the file, the table and the key
Result<ElasticScanSettings> read_elastic_settings(const std::filesystem::path& path,
                                                  const ValueDefaults& values = {}) noexcept;

/// A body of tetrahedra, in mm, g and s.
struct BodySettings {
    double young_modulus_pa = 15e3;
    double poisson_ratio = 0.45;
    double ogden_alpha = 2;  ///< exponent of the stretches [Ogden1972]; 2: neo-Hookean
    double density_kg_m3 = 1000;
    double damping_per_s = 5;  ///< of velocities
    double fixed_hu = 300;     ///< nodes at a larger value of the scan don't move
    double time_step_s = 1.0 / 60;
    std::int32_t sub_steps = 10;
    double reach_mm = 10;  ///< distance from the body at which the scan rests

    friend bool operator==(const BodySettings&, const BodySettings&) = default;
};
SettingRows<BodySettings> body_rows() noexcept;

/// Makes hyperelastic tetrahedra in a scan. A tool holds the nodes in its sphere, or, if there are
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
