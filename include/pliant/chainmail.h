// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail, solved exactly: push the voxels of a scan.
//
// Every voxel is an element, linked to its six neighbours. Element i sits at X_i at rest and at
// X_i + u_i now; for component a of u and a link from i to its neighbour j along axis b, of rest
// length h_b,
//
//   b = a (stretch):  −h_b·compress ≤ u_a(j) − u_a(i) ≤ h_b·stretch
//   b ≠ a (shear):    |u_a(j) − u_a(i)| ≤ h_b·shear
//
// A push moves some elements together; all others make the least move that satisfies every link
// again. That move is unique, and found without any iteration to a tolerance (docs/chainmail.md).
//
//   const TaskArena arena;
//   auto tissue = ChainMail::create(volume, {}, arena);
//   auto report = tissue->push({.point_mm = {-13.5, 116, -421}, .push_mm = {6, 0, 0}});

#pragma once

#include <pliant/chainmail_relax.h>
#include <pliant/grid.h>
#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// What one element allows to the links around it. A link takes the mean of its two ends.
struct ElementLimits {
    Vec3d compress{0, 0, 0};     ///< of a link along i, j, k, as a fraction of its length, ≥ 0
    Vec3d stretch{0, 0, 0};      ///< likewise
    Vec3d shear{0, 0, 0};        ///< likewise
    double max_movement_mm = 0;  ///< largest distance from the rest place (Euclidean)
    bool fixed = false;          ///< bone: never moves
    /// Strain beyond this fraction of the link's limits stays as an imprint, 0…1; 0: none stays.
    double yield = 0;
};

/// Limits by voxel value [HU, rounded to a whole number].
using MaterialLaw = std::function<ElementLimits(int value_hu)>;

/// How the minimal move is found. Both give the same bits.
enum class ChainMailSolver {
    Sweep,  ///< brick-wise sweeps, parallel
    Heap,   ///< ordered propagation, one element at a time: the readable reference
};

struct ChainMailSettings {
    // [material]
    std::string law = "draeger";     ///< draeger_law below, the only named one
    double offset = 0.2;             ///< size of the chain regions, fraction of a link, 0…1
    double bone_threshold_hu = 300;  ///< values above it don't move
    double max_movement_mm = 20;     ///< of the softest element, 0…500
    double yield = 0;                ///< strain beyond this fraction of the limits stays; 0: none
    // [push]
    double scale = 1;  ///< every push is multiplied by it
    // [lattice]
    int brick_size = 8;  ///< elements along a brick's edge, 2…32
    bool bounded =
        false;  ///< whether the lattice ends at the scan's border; else it goes on in air
    std::int64_t max_elements = 150'000'000;  ///< a push that needs more (about 4 GB) is refused
    // [air]
    bool air_enabled = false;        ///< must be false: air as a material of its own doesn't exist
    double air_threshold_hu = -500;  ///< values below are air: a sphere doesn't grab them

    ChainMailSolver solver = ChainMailSolver::Sweep;
    MaterialLaw custom_law;  ///< if set, used instead of the named law
};

/// Reads TOML with the tables above, or the key=value lines of Divod's configuration [Draeger2005,
/// 4.6].
/// @param[out] notes  keys of Divod that have no meaning here, one line each; may be null
/// @returns Error that names file, key, what was found and what was expected
Result<ChainMailSettings> read_chainmail_settings(const std::filesystem::path& path,
                                                  std::vector<std::string>* notes = nullptr);

/// The law of [Draeger2005, 3.5.5 and 3.6.2]: with w = clamp((v + 1000)/4095, 0, 1), all limits are
/// offset·(1 − w²), and the movement limit is (1 − w²)·max_movement_mm.
MaterialLaw draeger_law(const ChainMailSettings& settings);

struct Push {
    Vec3d point_mm{0, 0, 0};      ///< where the tool touches, LPS
    Vec3d push_mm{0, 0, 0};       ///< how far it goes, LPS
    double sphere_radius_mm = 0;  ///< 0: grabs the eight elements of the cell that holds the point
};

enum class PushStatus { Applied, Limited, Rejected };
enum class LimitedBy { None, Bone, Movement };

struct PushReport {
    PushStatus status = PushStatus::Rejected;
    LimitedBy limited_by = LimitedBy::None;
    double step_fraction = 0;  ///< of the scaled push that was done, 0…1
    std::int64_t grabbed_elements = 0;
    std::int64_t moved_elements = 0;  ///< whose displacement this push changed
    double solve_ms = 0;
    std::string message;  ///< why, where it isn't plainly applied
};

/// The state of the lattice, checked link by link and cell by cell, apart from the solver.
struct LatticeState {
    std::int64_t moved_elements = 0;  ///< away from their rest place
    std::int64_t resident_bricks = 0;
    double bytes_per_resident_element = 0;
    double max_movement_mm = 0;     ///< of any element
    double max_violation_mm = 0;    ///< by how much the worst link is outside of its limits
    std::int64_t folded_cells = 0;  ///< cells with a corner where space is turned inside out
};

class Lattice;

class ChainMail {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument that names the setting
    static Result<ChainMail> create(const Volume& volume, const ChainMailSettings& settings,
                                    const TaskArena& arena);
    ~ChainMail();
    ChainMail(ChainMail&&) noexcept;
    ChainMail& operator=(ChainMail&&) noexcept;

    /// Pushes with a tool. Whatever happens, the lattice stays valid; a Rejected push changes
    /// nothing.
    /// @returns InvalidArgument for a point outside of the scan or a push that is no number;
    ///          LimitExceeded (nothing changed) where settings.max_elements is too small
    Result<PushReport> push(const Push& push);

    /// Moves the given elements together. @param push_mm  LPS, multiplied by the scale setting
    Result<PushReport> push_elements(std::span<const Vec3i> elements, Vec3d push_mm);

    /// Elastic return, as far as a budget of time or sweeps goes; valid wherever it stops.
    /// @returns InvalidArgument that names the option
    Result<RelaxReport> relax(const RelaxOptions& options);
    /// E of chainmail_relax.h now [mm² · weight].
    double elastic_energy_mm2() const;
    /// Where element ijk returns to: the imprint of pushes beyond the yield limit [mm, LPS].
    Vec3d imprint_mm(Vec3i ijk) const;
    /// The elements that a push would take hold of now: to be held while its tool stays.
    /// @returns InvalidArgument as push
    Result<std::vector<Vec3i>> elements_at(const Push& push) const;

    /// Displacement of element ijk [mm, LPS]; zero where nothing moved; also beyond the scan.
    Vec3d displacement_mm(Vec3i ijk) const;
    LatticeState state() const;
    /// Of all displacements: equal for every solver, brick size and number of threads.
    std::uint64_t hash() const;
    /// Elements away from their rest place lie in this box (not cut to the scan).
    Box3i moved_box() const;

    const Volume& volume() const;
    const TaskArena& arena() const;
    const ChainMailSettings& settings() const;
    const Lattice& lattice() const;  ///< for the rooms above; opaque to users

  private:
    struct Impl;
    explicit ChainMail(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
