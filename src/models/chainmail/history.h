// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Undo and redo of every change of a lattice, and rollback of a failed change.
//
//   begin(name) → the lattice tells of each brick before it changes → end(), or cancel()
//
// While a step is open, a brick is copied once before it moves: 12 bytes per element, and nothing
// for bricks at rest. When the step ends, the copies are compared with the present bricks, and the
// differences are stored, compressed (history_codec.h). A difference leads back and forth, so a
// step is stored once for undo and redo. A step without changes is dropped.
//
// Code that writes displacements calls Lattice::before_move first, at the latest when it is the
// only thread that writes the brick; edits and imprints notify by themselves.
//
// Ending a step never fails: without memory for the differences, the copies themselves are kept
// until there is memory. Cancelling a step doesn't fail either, since the copies have all of its
// data. A part of a step can be cancelled alone if a *safeguard* was opened before it:
//
//     begin ── changes ── open_safeguard ── changes ── close_safeguard ── … ── end
//              copies of the step           own copies   added to the step's for bricks
//                                                        without a copy there
//
// A safeguard also works where no steps are kept.

#pragma once

#include <pliant/core/tasks.h>

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "chainmail/history_codec.h"
#include "lattice/lattice.h"
#include "relax/plastic.h"

namespace pliant {

/// A change outside of the lattice and its imprints (settings, materials): exchanged with the
/// replaced values on undo, and again on redo.
class Exchange {
  public:
    virtual ~Exchange() = default;
    /// Allocates the memory of exchange. Only this may fail; it has no effect then.
    virtual void prepare() {}
    /// A second call reverts it.
    virtual void exchange() noexcept = 0;
    /// Frees the memory of prepare.
    virtual void finish() noexcept {}
    virtual std::size_t bytes() const = 0;
};

class History final : public LatticeObserver {
  public:
    /// @param max_steps  0: keeps nothing, at no cost
    /// @param max_bytes  of all steps together; the oldest are forgotten first
    History(Lattice& lattice, PlasticRest& rest, const TaskArena& arena, int max_steps,
            std::size_t max_bytes);
    ~History() override;
    History(const History&) = delete;
    History& operator=(const History&) = delete;

    /// Begins a step; steps inside of another one belong to it. Has no effect if it throws.
    void begin(const std::string& name);
    /// Begins a step without failing: if memory is short, the name is truncated, and the step
    /// farthest from the present is forgotten for this one.
    void begin_anyway(const std::string& name) noexcept;
    /// @returns the number of the oldest steps that were forgotten for this one; −1 if this one
    ///          itself is larger than the bound, so that nothing can be undone
    int end() noexcept;
    /// Reverts every change since the outermost step began, and ends it; an inner step is only
    /// ended.
    /// @param made  Lattice::made_count at the beginning
    void cancel(std::uint64_t made) noexcept;
    /// Gives up undo of the open step, and of all before it: end() forgets all steps. Frees memory.
    void give_up() noexcept;

    bool is_open() const { return m_depth > 0; }
    int depth() const { return m_depth; }
    bool keeps_steps() const { return m_max_steps > 0; }
    /// Adds a finished exchange to the open step. Can't fail after make_room_for_exchange.
    void add(std::unique_ptr<Exchange> exchange);
    void make_room_for_exchange();

    /// Starts a part of the step that can be cancelled alone.
    void open_safeguard() noexcept;
    void close_safeguard() noexcept;
    /// Reverts every change since the safeguard was opened, and closes it.
    /// @param made  Lattice::made_count at the opening
    void cancel_safeguard(std::uint64_t made) noexcept;

    /// Ends the innermost step provisionally: reopen() opens it again, and settle() ends it for
    /// good, after a following step has succeeded. Other steps may begin meanwhile.
    void set_aside() noexcept;
    void reopen() noexcept;
    /// @returns like end
    int settle() noexcept;

    /// Undoes a step. Has no effect if it throws. A step that is set aside is undone first, and
    /// settled then. @param then  called when all changes are made; if it throws, all are reverted
    /// @pre !is_open(), and there is a step
    void undo(const std::function<void()>& then = {});
    /// Redoes a step, likewise. @pre also: no step is set aside
    void redo(const std::function<void()>& then = {});
    void clear() noexcept;

    int undo_steps() const { return int(m_undo.size()); }
    int redo_steps() const { return int(m_redo.size()); }
    /// Whether a step with changes is set aside.
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
        bool is_copied = true;       ///< false: reserved memory of a brick that has not changed
    };
    using CoordMoves = std::unordered_map<Vec3i, Saved, CoordHash>;
    /// Former state of all data that changed since a certain time.
    struct Copies {
        std::uint64_t step = 0;  ///< their own number, from 1 on
        CoordMoves moves;
        EditMap edits;
        ImprintMap imprints;
    };
    struct Step {
        std::string name;
        std::vector<Piece> moves, edits;
        ImprintMap imprints;  ///< former ones while the step is done, new ones while it is undone
        std::vector<std::unique_ptr<Exchange>> exchanges;
        bool is_any = false;     ///< whether anything changed
        bool is_packed = false;  ///< else moves and edits are in the copies
        Copies copies;           ///< former moves and edits, if they are not packed
        std::size_t bytes = 0;
    };
    /// Lists, so that a step changes owner without an allocation.
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
    Steps m_undo, m_redo;     ///< the next step is last
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
    std::mutex m_mutex;  ///< guards the copies: bricks move on many threads
    std::vector<std::unique_ptr<Fixed[]>> m_spare;
};

}  // namespace pliant
