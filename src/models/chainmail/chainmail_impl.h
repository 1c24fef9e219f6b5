// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Implementation of ChainMail. Each capability has its own source file, which defines its members
// of ChainMail and of this struct.

#pragma once

#include <pliant/chainmail.h>

#include <optional>
#include <span>
#include <string>
#include <utility>

#include "chainmail/history.h"
#include "field/element_edits.h"
#include "lattice/allowance.h"
#include "lattice/lattice.h"
#include "propagate/drag.h"
#include "propagate/propagation.h"
#include "relax/energy.h"
#include "relax/plastic.h"
#include "relax/relax.h"

namespace pliant {

/// A complete report but for the number of moved elements. Makes all its allocations.
PushReport report_of_step(std::int64_t grabbed, StepLimit limit);
/// Reasons for which a push stopped, or nothing moved; empty if it wasn't limited.
struct Reasons {
    std::string stopped, nothing_moved;
};
/// @param detail  added to both; may be empty
Reasons reasons_of(LimitedBy limit, const ChainMailSettings& settings,
                   const std::string& detail = {});
/// Adds the number of moved elements. Can't fail.
void complete(PushReport& report, std::int64_t moved, Reasons& reasons) noexcept;

/// @returns InvalidArgument that names the setting
Result<MaterialMap> make_materials(const Volume& volume, const ChainMailSettings& settings);

/// An object outside of the lattice that may stop a push before the lattice's own limits do.
class StepGuard {
  public:
    struct Verdict {
        double fraction;
        Vec3<Fixed> done;  ///< of the shift
        LimitedBy limited_by;
    };
    virtual ~StepGuard() = default;
    /// @param bricks    hold the raises of the whole shift
    /// @param so_far    the part that the lattice's own limits allow
    virtual Verdict limit(std::span<const int> bricks, Vec3<Fixed> shift, Verdict so_far) = 0;
};

struct ChainMail::Impl {
    Impl(const Volume& v, const ChainMailSettings& s, MaterialMap materials, const TaskArena& a)
        : volume(v),
          settings(s),
          lattice(v, std::move(materials), s.brick_size, s.bounded),
          yields(any_yields(lattice.materials())),
          arena(a),
          history(lattice, plastic_rest, a, s.history_max_steps, s.history_max_bytes()),
          relaxation(lattice, plastic_rest, a) {}

    Result<PushReport> push(std::span<const Vec3i> elements, Vec3d push_mm);
    /// Whether the loops with vector instructions are used.
    bool uses_vectors() const;
    const SweepKernels& kernels() const;
    class MaterialChange;
    Status set_materials(const ChainMailSettings& changed);
    /// Updates the allowance after displacements were restored: links may be outside of their
    /// limits again. Has no effect if it throws.
    void restore_allowance();
    bool propagate(std::span<const ElementRef> grabbed, Vec3<Fixed> shift);
    /// Elements that a push at this position moves.
    Result<std::vector<Vec3i>> elements_at(const Push& push) const;
    /// Creates bricks for the elements and fills grabbed_elements. @returns false if all are void
    bool take_hold(std::span<const Vec3i> elements);
    Vec3d lattice_mm_from_world(Vec3d push_mm) const;
    /// Most elements that a push may move: as the settings say, and not many more than the scan
    /// has, since rigid tissue without air around it would go on for ever.
    std::int64_t max_elements() const;
    int max_bricks() const;
    Error too_large() const;
    /// @param[out] done  the part of the shift that was done
    Result<PushReport> push_grabbed(std::span<const ElementRef> elements, Vec3<Fixed> shift,
                                    Vec3<Fixed>* done);
    /// Drops the bricks of a push that stayed at rest.
    void drop_unmoved();
    /// Lets links beyond their yield limits flow, after a push or a step of a drag.
    void yield_to_push();
    Result<RelaxReport> relax(const RelaxOptions& given);
    double elastic_energy_mm2();
    Result<FollowReport> follow(const Box3i& elements,
                                const std::function<Vec3d(Vec3d)>& displacement_mm);
    ElementFacts facts() const;
    Result<CutReport> cut(const CutSurface& surface);
    Result<CarveReport> carve(const CarveTool& tool);
    Status undo();
    Status redo();
    void reset();
    Status save_state(const std::filesystem::path& path) const;
    /// @returns the state that replaces this one
    Result<std::unique_ptr<Impl>> load_state(const std::filesystem::path& path) const;

    class Operation;
    class SuspendedDrag;
    /// Outermost operation under way.
    Operation* operation = nullptr;
    /// Clears the marks that an interrupted solve left in lattice and memory.
    void abandon_solve() noexcept;

    const Volume& volume;
    ChainMailSettings settings;
    Lattice lattice;
    Deformation deformation{lattice};
    PlasticRest plastic_rest;
    Allowance allowance;  ///< of links that were outside of their limits when these changed
    bool materials_changed = false;  ///< at any time
    bool yields;                     ///< whether a material yields
    const TaskArena& arena;
    // Memory of a push, reused by the next.
    SweepWork work;
    std::vector<ElementRef> grabbed_elements;

    Result<GrabReport> grab(std::span<const Vec3i> elements, double reach_mm);
    Result<PushReport> drag_to(Vec3d offset_mm);
    Result<PushReport> drag_by(Vec3<Fixed> step, Vec3<Fixed>& done);
    /// Whether the fields of a pick are valid: not with rounded limits, and not while links are
    /// outside of their limits, which then depend on the present state.
    bool can_use_fields() const;
    Status pick();
    void drop_fields() noexcept;
    void let_go() noexcept;

    std::vector<Vec3i> held;           ///< elements of the drag; empty: none
    Vec3<Fixed> drag_offset{0, 0, 0};  ///< offset of the held elements since they were grabbed
    Fixed drag_reach = 0;
    bool has_fields = false;
    /// Steps of the drag since relaxation invalidated the fields; empty if they are valid.
    std::optional<int> steps_without_fields;
    Drag drag;
    History history;
    StepGuard* guard = nullptr;  ///< during a push
    Relaxation relaxation;
    EnergyMemory energy;
};

/// Access to a tissue's elements, for functions of the library beside the class, and for tests.
struct ChainMailInside {
    using Impl = ChainMail::Impl;
    static Impl& of(ChainMail& tissue) { return *tissue.m_impl; }
    static const Impl& of(const ChainMail& tissue) { return *tissue.m_impl; }
};
inline Lattice& lattice_of(ChainMail& tissue) {
    return ChainMailInside::of(tissue).lattice;
}
inline const Lattice& lattice_of(const ChainMail& tissue) {
    return ChainMailInside::of(tissue).lattice;
}

}  // namespace pliant
