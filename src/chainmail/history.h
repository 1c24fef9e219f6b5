// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Undo and redo of every change of a lattice, and rollback of a change that failed.
//
//   begin(name) → the lattice tells of each brick before it changes → end(), or cancel()
//
// While a step is open, a brick that is about to move is copied once: 12 bytes an element, and
// nothing at all for bricks that were at rest. When the step ends, the copies are compared with
// what the bricks have become, and the differences are kept, made small (history_codec.h). A
// difference leads back and forth, so a step is kept once for undo and redo. A step that changed
// nothing is no step.
//
// Whoever writes displacements calls Lattice::before_move first, at the latest when it is the only
// thread that writes the brick; edits and imprints tell by themselves.
//
// Ending a step never fails: where there is no memory for the differences, the copies themselves
// are kept until there is. Cancelling one doesn't fail either, for the copies have all that it
// needs. Part of a step can be cancelled by itself if a *safeguard* was opened before it:
//
//     begin ── changes ── open_safeguard ── changes ── close_safeguard ── … ── end
//              copies of the step           copies of   added to the step's, where
//                                           its own     these have none
//
// A safeguard also works where no steps are kept.

#pragma once

#include <pliant/tasks.h>

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "chainmail/history_codec.h"
#include "chainmail/lattice.h"
#include "chainmail/plastic.h"

namespace pliant {

/// Something beside the lattice and its imprints that a step changed (settings, materials):
/// exchanged with the values it replaced on undo, and again on redo.
class Exchange {
  public:
    virtual ~Exchange() = default;
    /// Allocates the memory of exchange. Only this may fail, and then changes nothing.
    virtual void prepare() {}
    /// May be repeated to take it back.
    virtual void exchange() noexcept = 0;
    /// Frees the memory of prepare.
    virtual void finish() noexcept {}
    virtual std::size_t bytes() const = 0;
};

class History final : public LatticeObserver {
  public:
    /// @param max_steps  0: keeps nothing, and costs nothing
    /// @param max_bytes  of all that is kept; the oldest steps go first
    History(Lattice& lattice, PlasticRest& rest, const TaskArena& arena, int max_steps,
            std::size_t max_bytes);
    ~History() override;
    History(const History&) = delete;
    History& operator=(const History&) = delete;

    /// Steps that begin inside of another belong to it. Where it throws none has begun.
    void begin(const std::string& name);
    /// The same without failing: where memory is short, the name is cut to what fits, and the step
    /// that is farthest from the present is forgotten for this one.
    void begin_anyway(const std::string& name) noexcept;
    /// @returns how many of the oldest steps were forgotten for this one; −1: this one itself is
    ///          larger than the bound, so that nothing can be undone
    int end() noexcept;
    /// Reverts every change since the outermost step began, and ends it; inside of another it
    /// just ends. @param made  Lattice::made_count then
    void cancel(std::uint64_t made) noexcept;
    /// Changes of the open step can't be undone any more, and those before it can't be
    /// reached: end() forgets all steps. Frees memory.
    void give_up() noexcept;

    bool is_open() const { return m_depth > 0; }
    int depth() const { return m_depth; }
    bool keeps_steps() const { return m_max_steps > 0; }
    /// Belongs to the open step; has been done already. Can't fail after make_room_for_exchange.
    void add(std::unique_ptr<Exchange> exchange);
    void make_room_for_exchange();

    /// From here on changes can be cancelled by themselves.
    void open_safeguard() noexcept;
    bool has_safeguard() const { return m_has_safeguard; }
    void close_safeguard() noexcept;
    /// Reverts every change since the safeguard was opened, and closes it.
    /// @param made  Lattice::made_count then
    void cancel_safeguard(std::uint64_t made) noexcept;

    /// Ends the innermost step on approval: it is open again after reopen(), and ends for good with
    /// settle(), after a following step has succeeded. Other steps may begin meanwhile.
    void set_aside() noexcept;
    void reopen() noexcept;
    /// @returns as end
    int settle() noexcept;

    /// Where they throw nothing has changed. A step that is set aside is the first to be undone,
    /// and settled then. @param then  called when all is in place; if it throws, all is put back
    /// @pre !is_open(), and there is a step
    void undo(const std::function<void()>& then = {});
    /// @pre likewise, and no step is set aside
    void redo(const std::function<void()>& then = {});
    void clear() noexcept;

    int undo_steps() const { return int(m_undo.size()); }
    int redo_steps() const { return int(m_redo.size()); }
    /// Whether a step is set aside that changed something.
    bool has_aside() const { return !m_aside.empty() && m_aside.front().is_any; }
    std::size_t bytes() const { return m_bytes; }
    const std::string& next_undo_name() const {
        return m_undo.empty() ? m_none : m_undo.back().name;
    }
    const std::string& next_redo_name() const {
        return m_redo.empty() ? m_none : m_redo.back().name;
    }

    void before_move(Brick& brick) override;
    void reserve_move(Brick& brick) override;
    void before_edit(Vec3i coord, const BrickEdits* edits) override;
    void before_imprint(Vec3i coord, const PlasticBrick* imprint) override;
    std::uint64_t step() const override { return m_copies.step; }

  private:
    /// The change of a few bricks, packed together.
    struct Piece {
        std::vector<Vec3i> coords;
        std::size_t raw_size = 0;
        Bytes packed;
    };
    struct Saved {
        std::unique_ptr<Fixed[]> u;  ///< three components; null: at rest
        bool is_copied = true;       ///< false: memory only, of a brick that has not changed
    };
    using CoordMoves = std::unordered_map<Vec3i, Saved, CoordHash>;
    /// What changed since some time, as it was then.
    struct Copies {
        std::uint64_t step = 0;  ///< a number of their own, from 1 on
        CoordMoves moves;
        EditMap edits;
        ImprintMap imprints;
    };
    struct Step {
        std::string name;
        std::vector<Piece> moves, edits;
        ImprintMap imprints;  ///< those of before while the step is done, else those of after
        std::vector<std::unique_ptr<Exchange>> exchanges;
        bool is_any = false;     ///< anything changed
        bool is_packed = false;  ///< else moves and edits are in the copies
        Copies copies;           ///< of moves and edits before the step, where they are not packed
        std::size_t bytes = 0;
    };
    /// In lists, so that a step changes hands without an allocation.
    using Steps = std::list<Step>;
    enum class Direction { Back, Forth };
    class Applier;

    Saved& reserve(const Brick& brick);
    void make_node();
    void clear_node() noexcept;
    void begin_in_node() noexcept;
    void start_copies() noexcept;
    std::vector<Piece> pack_moves(const CoordMoves& moves) const;
    std::vector<Piece> pack_edits(const EditMap& edits) const;
    void pack_piece(const CoordMoves& moves, std::span<const Vec3i> coords, Piece& piece) const;
    void close(Step& step, Copies& copies) const noexcept;
    void drop_unchanged(Copies& copies) const noexcept;
    bool is_unchanged(Vec3i coord, const Saved& saved) const;
    void pack_copies(Step& step);
    std::size_t bytes_of(const Step& step) const;
    int keep(Steps& step, Copies& copies) noexcept;
    void put_back(Copies& copies, std::uint64_t made) noexcept;
    void recycle(Copies& copies) noexcept;
    void retire(Steps& steps) noexcept;
    void observe(bool observes) { m_lattice.set_observer(observes ? this : nullptr); }

    Lattice& m_lattice;
    PlasticRest& m_rest;
    const TaskArena& m_arena;
    int m_max_steps;
    std::size_t m_max_bytes;
    Steps m_undo, m_redo;     ///< the next one last
    std::size_t m_bytes = 0;  ///< of both
    std::string m_none;

    int m_depth = 0;
    bool m_is_given_up = false;
    bool m_has_safeguard = false;
    std::uint64_t m_last_step = 0;  ///< number of the last copies
    Steps m_open;                   ///< one while a step is open
    Steps m_node;                   ///< one for the next step, if there is memory for it
    Copies m_copies;                ///< of the open safeguard, else of the open step
    Copies m_outer;                 ///< of the open step, while there is a safeguard
    Steps m_aside;                  ///< one while a step is set aside
    Copies m_aside_copies;
    std::mutex m_mutex;  ///< of the copies: bricks move on many threads
    std::vector<std::unique_ptr<Fixed[]>> m_spare;
};

}  // namespace pliant
