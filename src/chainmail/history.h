// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Undo and redo of whatever changes a lattice.
//
//   begin(name) → the lattice tells of each brick before it changes → end()
//
// While a step is open, a brick that is about to move is copied once: 12 bytes an element, and
// nothing at all for bricks that were at rest. When the step ends, the copies are compared with
// what the bricks have become, and the differences are kept, made small (history_codec.h). A
// difference leads back and forth, so a step is kept once for undo and redo. A step that changed
// nothing is no step.
//
// Whoever writes displacements calls Lattice::before_move first, at the latest when it is the only
// thread that writes the brick; set_edits does the like for itself.

#pragma once

#include <pliant/tasks.h>

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "chainmail/history_codec.h"
#include "chainmail/lattice.h"

namespace pliant {

/// Something beside displacements and edits that a step changed (settings, materials): exchanged
/// with what it replaced on undo, and again on redo.
class Exchange {
  public:
    virtual ~Exchange() = default;
    virtual void exchange() = 0;
    virtual std::size_t bytes() const = 0;
};

class History final : public LatticeObserver {
  public:
    /// @param max_steps  0: keeps nothing, and costs nothing
    /// @param max_bytes  of all that is kept; the oldest steps go first
    History(Lattice& lattice, const TaskArena& arena, int max_steps, std::size_t max_bytes);
    ~History() override;
    History(const History&) = delete;
    History& operator=(const History&) = delete;

    /// Steps that begin inside of another belong to it.
    void begin(std::string name);
    /// @returns how many of the oldest steps were forgotten for this one; −1: this one itself is
    ///          larger than the bound, so that nothing can be undone
    int end();
    bool is_open() const { return m_depth > 0; }
    /// Belongs to the open step; has been done already.
    void add(std::unique_ptr<Exchange> exchange);

    /// @pre !is_open(), and there is a step
    void undo();
    void redo();
    void clear();

    int undo_steps() const { return int(m_undo.size()); }
    int redo_steps() const { return int(m_redo.size()); }
    std::size_t bytes() const { return m_bytes; }
    const std::string& next_undo_name() const {
        return m_undo.empty() ? m_none : m_undo.back().name;
    }
    const std::string& next_redo_name() const {
        return m_redo.empty() ? m_none : m_redo.back().name;
    }

    void before_move(Brick& brick) override;
    void before_edit(Vec3i coord, const BrickEdits* edits) override;

  private:
    /// The change of a few bricks, packed together.
    struct Piece {
        std::vector<Vec3i> coords;
        std::size_t raw_size = 0;
        Bytes packed;
    };
    struct Step {
        std::string name;
        std::vector<Piece> moves, edits;
        std::vector<std::unique_ptr<Exchange>> exchanges;
        std::size_t bytes = 0;
    };
    struct Saved {
        std::unique_ptr<Fixed[]> u;  ///< three components; null: at rest
    };
    using CoordMoves = std::unordered_map<Vec3i, Saved, CoordHash>;
    using CoordEdits = std::unordered_map<Vec3i, BrickEdits, CoordHash>;

    std::vector<Piece> pack_moves();
    std::vector<Piece> pack_edits();
    void pack_piece(std::span<const Vec3i> coords, Piece& piece) const;
    int keep(Step step);
    void forget_saved();
    enum class Direction { Back, Forth };
    void apply(Step& step, Direction direction);
    void apply_moves(const Piece& piece, Direction direction);
    void apply_edits(const Piece& piece);

    Lattice& m_lattice;
    const TaskArena& m_arena;
    int m_max_steps;
    std::size_t m_max_bytes;
    std::deque<Step> m_undo, m_redo;  ///< the next one last
    std::size_t m_bytes = 0;          ///< of both
    std::string m_none;

    int m_depth = 0;
    std::uint64_t m_step = 0;  ///< number of the open step, from 1 on
    Step m_open;
    std::mutex m_mutex;  ///< of what is saved: bricks move on many threads
    CoordMoves m_saved_moves;
    CoordEdits m_saved_edits;
    std::vector<std::unique_ptr<Fixed[]>> m_spare;
};

}  // namespace pliant
