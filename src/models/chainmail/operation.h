// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One operation on a ChainMail, all or nothing. It lasts from constructor to commit. A destructor
// without a previous commit reverts all changes; neither can fail.
//
//     Operation operation(*this, {.step = "push", .ends_drag = true});   may throw, changes nothing
//     … solve, allocate all memory …                                     may throw or return
//     … write …                                                          can't fail, or is copied
//     report.forgotten_steps = operation.commit();                       can't fail
//
// Operations that write only when nothing can fail any more need no copies for a rollback. The
// others set `has_copies`: bricks are copied before they change, as the history does anyway.
//
// Operations inside of another one (the pushes of a slide) are parts of it.

#pragma once

#include <vector>

#include "chainmail/chainmail_impl.h"

namespace pliant {

/// Suspends a drag that ends if the operation succeeds. Its fields are lost in both cases: steps
/// after a failure compute new ones.
class ChainMail::Impl::SuspendedDrag {
  public:
    explicit SuspendedDrag(Impl& impl) noexcept;
    /// Resumes the drag, unless it was ended.
    ~SuspendedDrag();
    SuspendedDrag(const SuspendedDrag&) = delete;
    SuspendedDrag& operator=(const SuspendedDrag&) = delete;
    void end() noexcept;

  private:
    Impl& m_impl;
    std::vector<Vec3i> m_held;
    Vec3<Fixed> m_offset;
    Fixed m_reach;
    bool m_is_over = false;
};

class ChainMail::Impl::Operation {
  public:
    struct Kind {
        const char* step = nullptr;  ///< its name in the history; null: part of the drag's step
        bool ends_drag = false;
        bool has_copies = false;
    };
    Operation(Impl& impl, Kind kind);
    ~Operation();
    Operation(const Operation&) = delete;
    Operation& operator=(const Operation&) = delete;

    /// Copies bricks before they change from now on, unless that is done already.
    void keep_copies() noexcept;
    /// @returns like History::end
    int commit() noexcept;
    /// Commits, but keeps the history's step open.
    void commit_open() noexcept;
    /// Reverts all changes now.
    void roll_back() noexcept;

  private:
    void close_safeguard() noexcept;

    Impl& m_impl;
    std::uint64_t m_made;  ///< Lattice::made_count at the beginning
    std::optional<SuspendedDrag> m_drag;
    bool m_is_part = false, m_is_step = false;
    bool m_owns_copies = false;  ///< the step's copies hold changes of this operation only
    bool m_has_safeguard = false, m_is_over = false;
};

}  // namespace pliant
