// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Organs: one or several bodies of tetrahedra that tools push, grab and slide on, and that slide on
// each other. They lie in a scan that they carry along, or in a scan generated from them.
//
// @code
//   auto file = read_organ_file("liver.toml");          // or organ_file_of_mesh("liver.stl")
//   auto made = make_organs(*file, arena);              // meshes, and the scan
//   auto tissue = make_tissue(*made, made->scan, arena);
//   auto report = (*tissue)->push(1, {.point_mm = point, .push_mm = {5, 0, 0}});
// @endcode
//
// docs/howto/organs.md has the scene files.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/mesh.h>
#include <pliant/result.h>
#include <pliant/scan_files.h>
#include <pliant/tissues.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Constraints of a body's tetrahedra.
enum class BodyLaw {
    Solid,      ///< stable neo-Hookean [Smith2018, Macklin2021]
    Distances,  ///< edges and volumes, compliances from the moduli [Mueller2007, VesselPbd2016]
    Springs,    ///< a mass-spring network with volume energy (make_network); of a single body
    Ogden,      ///< one term, stiffer in compression for a negative exponent [Ogden1972]
};

struct OrganSettings {
    std::string name{};         ///< empty: that of its label in the label volume
    std::string mesh{};         ///< file of tetrahedra, or of a closed surface, which is filled
    std::vector<int> labels{};  ///< of the label volume: the body's voxels; its mesh if there is
                                ///< no file
    BodyLaw law = BodyLaw::Solid;
    double young_modulus_pa = 15e3;
    double poisson_ratio = 0.45;
    double ogden_alpha = -18;  ///< exponent of BodyLaw::Ogden; the default is that of brain cortex
    double density_kg_m3 = 1000;
    double held_back = 0;          ///< fraction of its depth, from the back, that doesn't move
    std::vector<Vec3d> held_mm{};  ///< opposite corners of boxes whose nodes don't move, in pairs

    friend bool operator==(const OrganSettings&, const OrganSettings&) = default;
};
/// Rows of a [[body]] table.
SettingRows<OrganSettings> organ_rows() noexcept;

/// Structure inside the organs of a generated scan, such as a vessel. It moves with them.
struct OrganContents {
    std::string surface{};  ///< file of a closed surface
    double value_hu = 150;

    friend bool operator==(const OrganContents&, const OrganContents&) = default;
};
/// Rows of a [[contents]] table.
SettingRows<OrganContents> organ_contents_rows() noexcept;

/// Scene file of organs, with the settings of all bodies.
struct OrganFile {
    std::string file{};     ///< path of this file
    std::string scan{};     ///< empty: a scan is generated
    ReadOptions reading{};  ///< of the scan
    std::string label_volume{};
    /// Table of the labels' names; empty: the label volume's own table, or one beside it.
    std::string label_names{};
    std::string units = "mm";          ///< of the meshes' files: "mm", "cm" or "m"
    std::int64_t tetrahedra = 20'000;  ///< number in all generated meshes together
    double smoothing_voxels = 0.8;     ///< standard deviation of the labels' smoothing
    /// Makes one more body: the tissue around the organs, without air.
    bool surroundings = false;
    double surroundings_mm = 20;   ///< thickness of the surroundings
    double surroundings_pa = 5e3;  ///< Young's modulus of the surroundings
    double fixed_hu = 300;         ///< nodes at a larger value of the scan don't move
    double fixed_near_mm = 0;      ///< nor do nodes within this distance of such a voxel
    double friction = 0;           ///< Coulomb friction coefficient, of tools and organs
    double damping_per_s = 20;     ///< of velocities
    double time_step_s = 1.0 / 60;
    std::int32_t sub_steps = 10;
    double reach_mm = 10;  ///< distance from the bodies at which the scan rests
    std::vector<OrganSettings> bodies{};
    std::vector<OrganContents> contents{};
};
/// Rows of the [organs] table.
SettingRows<OrganFile> organ_file_rows() noexcept;

/// Whether a file is a mesh, by its extension; .vtk also by its content, since scans have it too.
bool is_mesh_file(const std::filesystem::path& file);
/// Checks that a file may be a mesh or a scan, by its name, or by the content of a DICOM file.
/// @returns NotFound, or Unsupported with the endings of meshes
Status check_mesh_or_scan(const std::filesystem::path& file);
/// Whether a TOML file is a scene of organs: it has a [[body]].
bool is_organ_file(const std::filesystem::path& file);
/// Reads a scene file. Its relative paths refer to its folder.
/// @returns an error of one line, with the file and the key
Result<OrganFile> read_organ_file(const std::string& file) noexcept;
/// Scene of one mesh that lies on its back: the hindmost twentieth of its depth is held.
OrganFile organ_file_of_mesh(const std::string& file);
/// Scene of a scan's labelled organs with their surroundings.
/// make_organs names the bodies after their labels.
/// @param labels  empty: each label with a volume of 1 ml or more that isn't air or bone
/// @param label_names, reading  members of OrganFile
Result<OrganFile> organ_file_of_labels(const std::string& scan, const std::string& label_volume,
                                       const std::vector<int>& labels,
                                       const std::string& label_names = {},
                                       const ReadOptions& reading = {}) noexcept;

struct Organ {
    std::string name{};
    TetMesh mesh{};  ///< at rest [mm, LPS]
    OrganSettings settings{};
};
struct MadeOrgans {
    OrganFile file{};
    Volume scan{};
    ReadNotes notes{};                       ///< of its reading
    std::shared_ptr<const Volume> labels{};  ///< null: organs carry the voxels in their meshes
    std::vector<Organ> organs{};             ///< the surroundings, if any, are last
    std::uint64_t hash = 0;                  ///< of meshes and settings
};
/// Reads or makes the meshes, and the scan.
/// @returns an error of one line, with the faulty file or label
Result<MadeOrgans> make_organs(const OrganFile& file, const TaskArena& arena) noexcept;
/// Makes the tissue. Its nodes are the nodes of all organs, in the organs' order. Scan and arena
/// must outlive it.
/// @param scan  made.scan, or a copy at another address
Result<std::unique_ptr<MeshTissue>> make_tissue(const MadeOrgans& made, const Volume& scan,
                                                const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
