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
// (docs/method/chainmail.md).
//
// Calls that return a Result or Status don't throw. An error, LimitExceeded for lack of memory
// included, leaves displacements, history, settings and a drag unchanged.
//
// @code
//   const TaskArena arena;
//   auto tissue = ChainMail::create(volume, {}, arena);
//   auto report = tissue->push({.point_mm = {-13.5, 116, -421}, .push_mm = {6, 0, 0}});
// @endcode

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/deformation.h>
#include <pliant/models/material.h>
#include <pliant/models/relax.h>
#include <pliant/result.h>
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

/// The state of the lattice, checked link by link and cell by cell, independent of the solver.
struct LatticeState : DeformationState {
    /// Largest distance of a link from its limits, or from its excused difference after a change of
    /// materials.
    double max_violation_mm = 0;
    std::int64_t excused_links = 0;  ///< components of links that are outside of their limits
};

/// Result of a motion that follows a field.
struct FollowReport {
    double fraction = 0;             ///< executed part of the field away from bone, 0…1
    std::int64_t held_elements = 0;  ///< elements that bone or the box's end holds back
    std::int64_t moved_elements = 0;
    double solve_ms = 0;
    int forgotten_steps = 0;  ///< oldest steps that were dropped from the history
};

/// Thread safety: concurrent reads.
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

    /// Moves the elements of a box from rest by a field, such as that of breathing or swelling, as
    /// far as the limits allow: by u = min(max(f·T, −D), D) for each component along the lattice's
    /// axes. f is the largest fraction for which f·T is within the tightest limits of the
    /// materials in the box, D the displacement that they allow beside bone and the box's outside,
    /// which don't move. The lattice stays valid, and can be pushed afterwards. Of rounded limits,
    /// the field keeps the box of each link alone.
    /// @param displacement_mm  T at a position at rest [mm, LPS]; called for each element
    /// @returns InvalidArgument if the tissue is not at rest, or cut, carved or bounded, or a
    ///          displacement isn't finite or exceeds 500 mm; LimitExceeded. Then
    ///          nothing has changed
    Result<FollowReport> follow(const Box3i& elements,
                                const std::function<Vec3d(Vec3d point_mm)>& displacement_mm);

    /// Grabs the elements that a push with this tool would grab (its push_mm is ignored) and
    /// precomputes the elements that can follow. Each step of the drag then costs one pass over
    /// memory.
    /// @param reach_mm  expected length of the drag along each axis, 0…500; multiplied by the scale
    ///                  setting. A longer drag repeats the precomputation on the way.
    /// @returns InvalidArgument that names reach_mm, or an error of push
    Result<GrabReport> grab(const Push& at, double reach_mm);
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
    /// Current energy E of relax.h [mm² · weight]. May throw std::bad_alloc; changes
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

  private:
    friend struct ChainMailInside;
    struct Impl;
    explicit ChainMail(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

// Tools that slide along tissue: contact without friction, and an eye that stays out of tissue.
//
//      o →            A push (ChainMail::push) carries the grabbed elements along: a bump that
//     .--.            the tool meets on its slope is pressed into the wall, and the wall follows.
//     |  |            In a slide, the tissue leaves the sphere along the sphere's outward normal.
//  ───'  '─────       So the bump is bent aside, and the tool goes on past it.
//
// The path is cut into steps of at most half a voxel. After each step, the cells whose trilinear
// value is tissue somewhere in the sphere move together by the minimal distance that takes all of
// it out, along the mean direction from the sphere's centre to that tissue. All other elements make
// their minimal move, as after every push. A sphere between voxels, or between thick slices,
// touches the wall like a larger sphere.
//
// A frame of a virtual endoscopy [Draeger2005, 4.4]:
//
// @code
//   const auto slid = slide_sphere(tissue, {eye, wanted_eye() - eye, 2});
//   if (slid) eye = slid->end_mm;                                     // never in tissue
//   for (const Box3i& box : live.update()->boxes) show(live.volume(), box);
// @endcode

/// Leads a sphere from path.point_mm along path.push_mm, times the scale setting. It should start
/// in air: tissue inside of it leaves it in the first step. The slide is one step of the history,
/// "slide". The resampled scan shows no tissue at end_mm, unless ends_in_tissue. A slide that would
/// close the lumen around the eye permanently is undone, and its way_fraction is 0. Inside of a
/// group, or without a history, it isn't undone.
/// @param tissue_values  default: values from settings.air_threshold_hu upwards
/// @returns InvalidArgument if the sphere has no radius, or its path isn't finite, is zero, longer
///          than 500 mm or outside of the scan; LimitExceeded as ChainMail::push. Then nothing has
///          changed
Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path,
                                 const TissueValues& tissue_values);
Result<SlideReport> slide_sphere(ChainMail& tissue, const Push& path);

}  // namespace pliant
#pragma GCC visibility pop
