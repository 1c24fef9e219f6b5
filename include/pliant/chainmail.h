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
// A push moves some elements together; all others make the minimal move that satisfies every link
// again. That move is unique, and is computed without an iteration to a tolerance
// (docs/chainmail.md).
//
// Calls that return a Result or Status don't throw. An error, LimitExceeded for lack of memory
// included, leaves displacements, history, settings and a drag unchanged.
//
//   const TaskArena arena;
//   auto tissue = ChainMail::create(volume, {}, arena);
//   auto report = tissue->push({.point_mm = {-13.5, 116, -421}, .push_mm = {6, 0, 0}});

#pragma once

#include <pliant/chainmail_materials.h>
#include <pliant/chainmail_relax.h>
#include <pliant/deformation.h>
#include <pliant/grid.h>
#include <pliant/record.h>
#include <pliant/result.h>
#include <pliant/tasks.h>
#include <pliant/tool.h>
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

/// Algorithms that find the minimal move. All give the same bits.
enum class ChainMailSolver {
    Sweep,       ///< brick-wise sweeps, parallel, vectorised
    Heap,        ///< ordered propagation, one element at a time: the readable reference
    PlainSweep,  ///< the sweep in scalar code
};

struct ChainMailSettings {
    // [material]
    std::string law = "draeger";  ///< "draeger", the only named law; see draeger_law
    double offset = 0.2;          ///< size of the chain regions, fraction of a link, 0 (rigid)…1
    double bone_threshold_hu = 300;  ///< elements with a larger value don't move
    double max_movement_mm = 20;     ///< movement limit of the softest element, 0…500
    LinkLimits limits = LinkLimits::Box;
    double yield = 0;  ///< strain beyond this fraction of the limits remains; 0: none remains
    // [push]
    double scale = 1;  ///< factor of every push
    // [lattice]
    int brick_size = 8;    ///< elements along a brick's edge, 2…32
    bool bounded = false;  ///< the lattice ends at the scan's border; else it continues as air
    std::int64_t max_elements = 150'000'000;  ///< a push that needs more (about 4 GB) is refused
    // [air]
    bool air_enabled = true;         ///< air is a separate material outside of the law
    double air_threshold_hu = -500;  ///< smaller values are air, which a sphere doesn't grab
    double air_compress = 0.98;      ///< fraction of its length that a link can lose, 0…1
    double air_stretch = 50;         ///< fraction that it can gain, 0…500
    double air_shear = 50;           ///< sideways slack as a fraction of its length, 0…500
    // [[label]]
    std::vector<LabelMaterial> label_materials{};
    std::shared_ptr<const Volume> labels{};           ///< on the scan's grid; required by
                                                      ///< label_materials
    std::shared_ptr<const VectorField> directions{};  ///< on the scan's grid; required by
                                                      ///< along_direction
    // [history]
    int history_max_steps = 200;  ///< number of steps that can be undone, 0…100000; 0 disables the
                                  ///< history
    int history_max_mb = 256;     ///< memory for these steps, 10⁶ bytes; the oldest are forgotten
                                  ///< first

    std::size_t history_max_bytes() const { return std::size_t(history_max_mb) * 1'000'000; }

    ChainMailSolver solver = ChainMailSolver::Sweep;
    MaterialLaw custom_law{};  ///< if set, replaces the named law and air
};

/// Rows of all settings that a file can have, except those of [[label]] tables.
SettingRows<ChainMailSettings> chainmail_rows() noexcept;
/// Rows of [material] and [air], which set_materials() can change.
SettingRows<ChainMailSettings> chainmail_material_rows() noexcept;

/// Reads TOML with the tables above, or the key=value lines of Divod's configuration [Draeger2005,
/// 4.6].
/// @param[out] notes  keys of Divod without a meaning here, one line each; may be null
/// @returns Error with file, key, found and expected value
Result<ChainMailSettings> read_chainmail_settings(const std::filesystem::path& path,
                                                  std::vector<std::string>* notes = nullptr);

/// Law of [Draeger2005, 3.5.5 and 3.6.2]. With w = clamp((v + 1000)/4095, 0, 1), all limits are
/// offset·(1 − w²), and the movement limit is (1 − w²)·max_movement_mm.
MaterialLaw draeger_law(const ChainMailSettings& settings);

/// The state of the lattice, checked link by link and cell by cell, independent of the solver.
struct LatticeState : DeformationState {
    /// Largest distance of a link from its limits, or from its excused difference after a change of
    /// materials.
    double max_violation_mm = 0;
    std::int64_t excused_links = 0;  ///< components of links that are outside of their limits
};

class Lattice;
class ObjectSpace;

class ChainMail final : public MovingScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @returns InvalidArgument that names the invalid setting, the law with the voxel value, or
    ///          the field of a volume that check_volume refuses
    static Result<ChainMail> create(const Volume& volume, const ChainMailSettings& settings,
                                    const TaskArena& arena);
    ~ChainMail() override;
    ChainMail(ChainMail&&) noexcept;
    ChainMail& operator=(ChainMail&&) noexcept;

    /// Pushes with a tool. The lattice always stays valid; a Rejected push changes nothing.
    /// @returns InvalidArgument if the point is outside of the scan or the push isn't finite;
    ///          LimitExceeded (nothing changed) if settings.max_elements is too small
    Result<PushReport> push(const Push& push);

    /// Moves the given elements together. @param push_mm  LPS, multiplied by the scale setting
    Result<PushReport> push_elements(std::span<const Vec3i> elements, Vec3d push_mm);

    /// Grabs the elements that a push with this tool would grab (its push_mm is ignored) and
    /// precomputes the elements that can follow. Each step of the drag then costs one pass over
    /// memory.
    /// @param reach_mm  expected length of the drag along each axis, 0…500; multiplied by the scale
    ///                  setting. A longer drag repeats the precomputation on the way.
    /// @returns InvalidArgument that names reach_mm, or an error of push
    Result<GrabReport> grab(const Push& place, double reach_mm);
    /// Grabs the given elements.
    Result<GrabReport> grab_elements(std::span<const Vec3i> elements, double reach_mm);
    /// Moves the grabbed elements to an offset from their positions when grabbed [mm, LPS],
    /// multiplied by the scale setting. The result is that of push_elements with the same elements
    /// and step. The report's step_fraction refers to this step.
    /// @returns InvalidArgument if nothing is grabbed, or the step isn't finite or exceeds 500 mm
    Result<PushReport> drag_to(Vec3d offset_mm);
    /// Ends the drag; all displacements stay. Every other successful change of the tissue, except
    /// relax, also ends it. Can't fail.
    void let_go();
    bool is_grabbing() const;

    /// Returns every element to its rest position and clears all imprints. Can't fail: if memory
    /// for the undo step is lacking, the whole history is forgotten.
    void reset();

    /// Replaces materials, labels, air and limits. No element moves. A link outside of its new
    /// limits may stay so, but not get worse. An element beyond its new movement limit may come
    /// back, but not go farther. An element that is now fixed stays at its current position.
    /// @returns InvalidArgument that names the setting; then nothing has changed
    Status set_materials(const ChainMailSettings& settings);
    FoldCertificate fold_certificate() const;

    /// Cuts the links that cross a surface in the deformed scan.
    /// @returns InvalidArgument for a surface without area; LimitExceeded (nothing changed) if it
    ///          crosses more than settings.max_elements elements
    Result<CutReport> cut(const CutSurface& surface);
    /// Carves the elements that are inside of the tool now. They become void: at their rest
    /// position, without links.
    Result<CarveReport> carve(const CarveTool& tool);

    /// Undoes the last step that changed something, bit for bit. If the steps exceed the settings'
    /// number or memory, the oldest are forgotten, and a report's forgotten_steps is not 0. (−1:
    /// that step alone exceeds the memory, and nothing can be undone.)
    /// @returns NotFound if there is nothing to undo; InvalidArgument inside of a group
    Status undo();
    /// Restores the last undone step. Every new step ends this possibility.
    Status redo();
    int undo_steps() const;
    int redo_steps() const;
    std::size_t history_bytes() const;          ///< memory of all steps
    const std::string& next_undo_name() const;  ///< "push", "cut", …; empty if there is none
    const std::string& next_redo_name() const;
    /// Collects all steps up to the group's end in one step. Inner groups belong to the outer one.
    /// Can't fail: if memory is short the name may be truncated, and the step farthest from the
    /// present may be forgotten.
    void begin_group(const std::string& name);
    /// Ends the group. Can't fail: a step that can't be compressed for lack of memory stays
    /// uncompressed until memory is available.
    /// @returns forgotten steps. @pre a group has begun
    int end_group();

    /// Writes displacements, imprints, cut links, void elements and settings to one file,
    /// atomically.
    /// @returns Unwritable
    Status save_state(const std::filesystem::path& path) const;
    /// Replaces all of these except the solver, and clears the history. References to settings()
    /// and deformation() become invalid. Nothing changes on failure.
    /// @returns NotFound; Unreadable if the file is damaged, cut short, or holds displacements
    ///          outside of their limits; Unsupported if a newer Pliant wrote it; InvalidArgument if
    ///          it belongs to another scan or law
    Status load_state(const std::filesystem::path& path);

    /// Relaxes elastically within a budget of time or sweeps. The lattice is valid after every
    /// move. A drag continues afterwards, and its held elements don't move. The change is a step of
    /// the history, "relax", or part of the drag's step.
    /// @returns InvalidArgument that names the option
    Result<RelaxReport> relax(const RelaxOptions& options);
    /// Current energy E of chainmail_relax.h [mm² · weight]. May throw std::bad_alloc; changes
    /// nothing.
    double elastic_energy_mm2() const;
    /// Imprint of element ijk [mm, LPS]: the rest displacement left by pushes beyond the yield
    /// limit.
    Vec3d imprint_mm(Vec3i ijk) const;
    /// Elements that a push would grab now, for RelaxOptions::held while a tool stays.
    /// @returns InvalidArgument like push
    Result<std::vector<Vec3i>> elements_at(const Push& push) const;

    /// Displacement of element ijk [mm, LPS]. Zero if unmoved. Also defined beyond the scan.
    Vec3d displacement_mm(Vec3i ijk) const;
    /// May throw std::bad_alloc; changes nothing.
    LatticeState state() const;
    /// Hash of all displacements, cut links and void elements, equal for every solver, brick size
    /// and number of threads.
    std::uint64_t hash() const;
    /// Box of all elements away from their rest position, not clipped to the scan.
    Box3i moved_box() const;

    const Volume& volume() const override;
    const TaskArena& arena() const override;
    const Deformation& deformation() const override;
    const ChainMailSettings& settings() const;
    const Lattice& lattice() const;  ///< for tests; opaque to users

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
