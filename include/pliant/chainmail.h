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
// Calls that return a Result or Status throw nothing. An error, lack of memory included
// (LimitExceeded), leaves the tissue as it was: displacements, history, settings and a drag.
//
//   const TaskArena arena;
//   auto tissue = ChainMail::create(volume, {}, arena);
//   auto report = tissue->push({.point_mm = {-13.5, 116, -421}, .push_mm = {6, 0, 0}});

#pragma once

#include <pliant/chainmail_edits.h>
#include <pliant/chainmail_materials.h>
#include <pliant/chainmail_relax.h>
#include <pliant/grid.h>
#include <pliant/record.h>
#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// How the minimal move is found. All give the same bits.
enum class ChainMailSolver {
    Sweep,       ///< brick-wise sweeps, parallel, with the processor's vector instructions
    Heap,        ///< ordered propagation, one element at a time: the readable reference
    PlainSweep,  ///< the sweep in plain loops
};

struct ChainMailSettings {
    // [material]
    std::string law = "draeger";  ///< draeger_law below, the only named one
    double offset = 0.2;          ///< size of the chain regions, fraction of a link, 0 (rigid)…1
    double bone_threshold_hu = 300;  ///< values above it don't move
    double max_movement_mm = 20;     ///< of the softest element, 0…500
    LinkLimits limits = LinkLimits::Box;
    double yield = 0;  ///< strain beyond this fraction of the limits stays; 0: none
    // [push]
    double scale = 1;  ///< every push is multiplied by it
    // [lattice]
    int brick_size = 8;  ///< elements along a brick's edge, 2…32
    bool bounded =
        false;  ///< whether the lattice ends at the scan's border; else it goes on in air
    std::int64_t max_elements = 150'000'000;  ///< a push that needs more (about 4 GB) is refused
    // [air]
    bool air_enabled = true;         ///< air is a material of its own, not one of the law's
    double air_threshold_hu = -500;  ///< values below are air: a sphere doesn't grab them
    double air_compress = 0.98;      ///< of a link, as a fraction of its length, 0…1
    double air_stretch = 50;         ///< likewise, 0…500
    double air_shear = 50;           ///< likewise
    // [[label]]
    std::vector<LabelMaterial> label_materials{};
    std::shared_ptr<const Volume> labels{};           ///< on the scan's grid; needed by the above
    std::shared_ptr<const VectorField> directions{};  ///< likewise, for along_direction
    // [history]
    int history_max_steps = 200;  ///< that can be undone, 0…100000; 0: none, at no cost
    int history_max_mb = 256;     ///< memory for them, 10⁶ bytes; the oldest steps go first

    std::size_t history_max_bytes() const { return std::size_t(history_max_mb) * 1'000'000; }

    ChainMailSolver solver = ChainMailSolver::Sweep;
    MaterialLaw custom_law{};  ///< if set, used instead of the named law and of air
};

/// Rows of all settings that a file can have, but for [[label]] tables.
SettingRows<ChainMailSettings> chainmail_rows() noexcept;

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
    Vec3d point_mm{0, 0, 0};  ///< where the tool touches, LPS
    Vec3d push_mm{0, 0, 0};   ///< how far it goes, LPS
    /// 0: grabs the eight elements of the cell that holds the point. Else all tissue elements in
    /// the sphere; where it is smaller than a voxel along some axis, also the elements of every
    /// cell whose trilinear value is tissue somewhere in it.
    double sphere_radius_mm = 0;
};

enum class PushStatus { Applied, Limited, Rejected };
/// Object and Wall: only in an ObjectSpace (chainmail_objects.h); Fold: of a SpringDeformation.
enum class LimitedBy { None, Bone, Movement, Object, Wall, Fold };

/// As in reports and messages: `applied`, `limited`, `rejected`.
std::string_view name_of(PushStatus status);
/// Likewise: `none`, `bone`, `movement`, `object`, `wall`, `fold`.
std::string_view name_of(LimitedBy limit);

struct PushReport {
    PushStatus status = PushStatus::Rejected;
    LimitedBy limited_by = LimitedBy::None;
    double step_fraction = 0;  ///< of the scaled push that was done, 0…1
    std::int64_t grabbed_elements = 0;
    std::int64_t moved_elements = 0;  ///< whose displacement this push changed
    double solve_ms = 0;
    int forgotten_steps = 0;  ///< oldest steps that this one pushed out of the history; see Undo
    std::string message;      ///< why, where it isn't plainly applied
};

/// What a tool took hold of, and what it can carry along.
struct GrabReport {
    std::int64_t grabbed_elements = 0;  ///< 0: nothing there, and nothing is held
    std::int64_t reach_elements = 0;    ///< that a drag within the reach can move; 0: not computed
    std::int64_t field_bytes = 0;       ///< memory for the fields, beside the bricks of the reach
    double pick_ms = 0;
    std::string message;  ///< why nothing is held
};

/// The state of the lattice, checked link by link and cell by cell, apart from the solver.
struct LatticeState {
    std::int64_t moved_elements = 0;  ///< away from their rest place
    std::int64_t resident_bricks = 0;
    double bytes_per_resident_element = 0;
    double max_movement_mm = 0;  ///< of any element
    /// By how much the worst link is outside of its limits, or of what it was excused for when the
    /// materials changed.
    double max_violation_mm = 0;
    std::int64_t excused_links = 0;  ///< components of links that are outside of their limits
    std::int64_t folded_cells = 0;   ///< whole cells with a corner where space is turned inside out
    std::int64_t cut_links = 0;
    std::int64_t carved_elements = 0;
};

class Lattice;
class ObjectSpace;
struct SlideReport;
struct TissueValues;

class ChainMail {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument that names the setting, the law and the value where it is wrong, or
    ///          the field of a volume that check_volume refuses
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

    /// Takes hold of what a push at this place would move (its push_mm counts for nothing), and
    /// finds out what comes along: after that each step of a drag costs one pass over memory.
    /// @param reach_mm  how far the drag will go along each axis, 0…500; multiplied by the scale
    ///                  setting. Going farther is allowed, and repeats this work on the way.
    /// @returns the errors of push, or InvalidArgument that names reach_mm
    Result<GrabReport> grab(const Push& place, double reach_mm);
    /// The same with elements of one's own choice.
    Result<GrabReport> grab_elements(std::span<const Vec3i> elements, double reach_mm);
    /// Moves what is grabbed to an offset from where it was when it was grabbed [mm, LPS],
    /// multiplied by the scale setting. Changes exactly what push_elements of the same elements by
    /// the same step changes; step_fraction is that of the step.
    /// @returns InvalidArgument if nothing is grabbed, or the step is no number or above 500 mm
    Result<PushReport> drag_to(Vec3d offset_mm);
    /// Ends the drag; everything stays where it is. Whatever else changes the tissue, but relax,
    /// does so too if it succeeds. Can't fail.
    void let_go();
    bool is_grabbing() const;

    /// Puts every element back to its rest place, and takes all imprints away. Can't fail: where
    /// there is no memory for the way back, all steps of the history are forgotten.
    void reset();

    /// Other materials, labels, air or limits from now on. Nothing moves: links that are outside of
    /// the new limits may stay so, but not get worse; elements beyond their new movement limit may
    /// come back, but not go farther; elements that are now fixed stay where they are.
    /// @returns InvalidArgument that names the setting; then nothing has changed
    Status set_materials(const ChainMailSettings& settings);
    FoldCertificate fold_certificate() const;

    /// Cuts the links that cross a surface, wherever the elements are now.
    /// @returns InvalidArgument for a surface of no area; LimitExceeded (nothing changed) where it
    ///          passes through more than settings.max_elements
    Result<CutReport> cut(const CutSurface& surface);
    /// Takes out the elements that are inside of the tool now. They are void from then on: at their
    /// rest place, and linked to nothing.
    Result<CarveReport> carve(const CarveTool& tool);

    /// Undo: takes back the last step that changed something, bit for bit. Steps are forgotten,
    /// the oldest first, where there are more of them, or more bytes, than the settings allow; a
    /// report's forgotten_steps is then not 0. (−1: that step alone is larger than allowed, and
    /// nothing can be undone.)
    /// @returns NotFound where there is nothing to undo; InvalidArgument inside of a group
    Status undo();
    /// Does again what was undone, until something else is done.
    Status redo();
    int undo_steps() const;
    int redo_steps() const;
    std::size_t history_bytes() const;          ///< of all steps
    const std::string& next_undo_name() const;  ///< "push", "cut", …; empty if there is none
    const std::string& next_redo_name() const;
    /// Everything until the group's end is one step. Groups inside of a group belong to it. Can't
    /// fail: where memory is short the name may be cut, and the step that is farthest from the
    /// present be forgotten.
    void begin_group(const std::string& name);
    /// Can't fail: a step that there is no memory to compress is kept as it is until there is.
    /// @returns forgotten steps. @pre a group has begun
    int end_group();

    /// Displacements, imprints, cut links, void elements and settings in one file. It appears as a
    /// whole, or not at all.
    /// @returns Unwritable
    Status save_state(const std::filesystem::path& path) const;
    /// Replaces all of these, but the solver, and the history is empty then. References to
    /// settings() and lattice() end. Where it fails nothing changes.
    /// @returns NotFound; Unreadable where the file is damaged, cut short, or holds displacements
    ///          outside of their limits; Unsupported where a newer Pliant wrote it; InvalidArgument
    ///          where it belongs to another scan or law
    Status load_state(const std::filesystem::path& path);

    /// Elastic return, as far as a budget of time or sweeps goes; valid wherever it stops.
    /// @returns InvalidArgument that names the option
    /// A drag goes on afterwards; the elements that it holds stay where they are. What changed is a
    /// step of the history, "relax", or belongs to the drag's.
    Result<RelaxReport> relax(const RelaxOptions& options);
    /// E of chainmail_relax.h now [mm² · weight]. May throw std::bad_alloc, and changes nothing.
    double elastic_energy_mm2() const;
    /// Where element ijk returns to: the imprint of pushes beyond the yield limit [mm, LPS].
    Vec3d imprint_mm(Vec3i ijk) const;
    /// The elements that a push would take hold of now: to be held while its tool stays.
    /// @returns InvalidArgument as push
    Result<std::vector<Vec3i>> elements_at(const Push& push) const;

    /// Displacement of element ijk [mm, LPS]; zero where nothing moved; also beyond the scan.
    Vec3d displacement_mm(Vec3i ijk) const;
    /// May throw std::bad_alloc, and changes nothing.
    LatticeState state() const;
    /// Of all displacements, cut links and void elements: equal for every solver, brick size and
    /// number of threads.
    std::uint64_t hash() const;
    /// Elements away from their rest place lie in this box (not cut to the scan).
    Box3i moved_box() const;

    const Volume& volume() const;
    const TaskArena& arena() const;
    const ChainMailSettings& settings() const;
    const Lattice& lattice() const;  ///< for the rooms above; opaque to users

  private:
    friend class ObjectSpace;
    friend Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path,
                                            const TissueValues& tissue_values);
    struct Impl;
    explicit ChainMail(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace pliant
#pragma GCC visibility pop
