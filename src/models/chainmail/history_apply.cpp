// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Undo and redo of a step: all memory is allocated first, so that it is done as a whole or not at
// all.

#include <algorithm>
#include <functional>
#include <iterator>
#include <new>
#include <utility>

#include "chainmail/history.h"

namespace pliant {

/// One step, applied backwards or forwards. Only the constructor may fail.
class History::Applier {
  public:
    Applier(History& history, Step& step)
        : m_history(history), m_lattice(history.m_lattice), m_step(step) {
        const std::uint64_t made = m_lattice.made_count();
        try {
            make_buffers();
            for (const Piece& piece : step.moves)
                for (const Vec3i& coord : piece.coords) m_lattice.ensure_brick(coord);
            for (const Piece& piece : step.edits) read_edits(piece);
            for (const auto& exchange : step.exchanges) exchange->prepare();
            m_history.m_rest.prepare(m_lattice, step.imprints);
            m_lattice.prepare_edits(m_edits);
        } catch (...) {
            finish();
            m_lattice.drop_made_since(made);
            throw;
        }
    }

    /// A second call in the other direction reverts it.
    void apply(Direction direction) noexcept {
        m_lattice.tick();
        const auto apply_some = [&](std::int64_t begin, std::int64_t end) {
            Buffer* buffer = take_buffer();
            for (auto k = std::size_t(begin); k < std::size_t(end); ++k)
                apply_moves(m_step.moves[k], direction, *buffer);
            give_back(buffer);
        };
        m_history.m_arena.for_each(std::int64_t(m_step.moves.size()), 1, std::ref(apply_some));
        m_lattice.exchange_edits(m_edits);
        m_history.m_rest.exchange(m_lattice, m_step.imprints);
        // The last change is reverted first.
        auto& exchanges = m_step.exchanges;
        if (direction == Direction::Back) std::reverse(exchanges.begin(), exchanges.end());
        for (const auto& exchange : exchanges) exchange->exchange();
        if (direction == Direction::Back) std::reverse(exchanges.begin(), exchanges.end());
    }

    void finish() noexcept {
        m_lattice.finish_edits(m_edits);
        m_history.m_rest.finish(m_step.imprints);
        for (const auto& exchange : m_step.exchanges) exchange->finish();
    }

  private:
    /// Memory for unpacking a piece, one per thread.
    struct Buffer {
        Bytes raw;
        std::vector<std::uint32_t> change;
    };

    void make_buffers() {
        std::size_t largest = 0;
        for (const Piece& piece : m_step.moves) largest = std::max(largest, piece.raw_size);
        const std::size_t threads = std::size_t(m_history.m_arena.thread_count());
        m_buffers.resize(std::min(threads, m_step.moves.size()));
        m_free.reserve(m_buffers.size());
        for (Buffer& buffer : m_buffers) {
            buffer.raw.resize(largest);
            buffer.change.resize(3 * std::size_t(m_lattice.elements_per_brick()));
            m_free.push_back(&buffer);
        }
    }
    Buffer* take_buffer() {
        const std::lock_guard lock(m_mutex);
        Buffer* taken = m_free.back();
        m_free.pop_back();
        return taken;
    }
    void give_back(Buffer* buffer) {
        const std::lock_guard lock(m_mutex);
        m_free.push_back(buffer);
    }

    void apply_moves(const Piece& piece, Direction direction, Buffer& buffer) const noexcept {
        const auto n = std::size_t(m_lattice.elements_per_brick());
        const std::span<std::byte> raw = std::span(buffer.raw).first(piece.raw_size);
        std::uint32_t* change = buffer.change.data();
        bool whole = unpack(piece.packed, raw);
        std::span<const std::byte> left = raw;
        for (const Vec3i& coord : piece.coords) {
            whole = whole && decode_change(left, m_lattice.brick_size(),
                                           {change, change + n, change + 2 * n});
            PLIANT_ASSERT(whole);
            if (!whole) return;
            const int index = m_lattice.find_brick(coord);
            Brick& brick = m_lattice.brick(index);
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t i = 0; i < n; ++i) {
                    const std::uint32_t step = change[a * n + i];
                    brick.u[a][i] = Fixed(std::uint32_t(brick.u[a][i]) +
                                          (direction == Direction::Forth ? step : 0u - step));
                }
            brick.changed_at = m_lattice.clock();
            m_lattice.update_bounds(index);
        }
    }

    /// Reads the resulting edits.
    void read_edits(const Piece& piece) {
        const auto n = std::size_t(m_lattice.elements_per_brick());
        Bytes raw(piece.raw_size);
        const bool whole = unpack(piece.packed, raw);
        PLIANT_ASSERT(whole);
        if (!whole) return;
        for (std::size_t k = 0; k < piece.coords.size(); ++k) {
            const BrickEdits* now = m_lattice.edits_of(piece.coords[k]);
            BrickEdits edits = now ? *now : BrickEdits(n, 0);
            for (std::size_t i = 0; i < n; ++i) edits[i] ^= std::uint8_t(raw[k * n + i]);
            m_edits[piece.coords[k]] = std::move(edits);
        }
    }

    History& m_history;
    Lattice& m_lattice;
    Step& m_step;
    std::vector<Buffer> m_buffers;
    std::vector<Buffer*> m_free;
    std::mutex m_mutex;
    EditMap m_edits;
};

void History::undo(const std::function<void()>& then) {
    PLIANT_ASSERT(m_depth == 0 && (has_aside() || !m_undo.empty()));
    const bool aside = has_aside();
    Step& step = aside ? m_aside.front() : m_undo.back();
    if (!step.is_packed && aside) {
        close(step, m_aside_copies);
        if (!step.is_packed) throw std::bad_alloc();
    } else if (!step.is_packed) {
        pack_copies(step);
    }
    if (aside) std::swap(step.imprints, m_aside_copies.imprints);
    try {
        Applier applier(*this, step);
        applier.apply(Direction::Back);
        try {
            if (then) then();
        } catch (...) {
            applier.apply(Direction::Forth);
            applier.finish();
            m_lattice.drop_still_bricks();
            throw;
        }
        applier.finish();
    } catch (...) {
        if (aside) std::swap(step.imprints, m_aside_copies.imprints);
        throw;
    }
    m_lattice.drop_still_bricks();
    if (aside) {
        std::swap(step.imprints, m_aside_copies.imprints);
        settle();
    }
    if (m_undo.empty()) return;  // the step set aside was larger than the bound
    m_redo.splice(m_redo.end(), m_undo, std::prev(m_undo.end()));
}

void History::redo(const std::function<void()>& then) {
    PLIANT_ASSERT(m_depth == 0 && !has_aside() && !m_redo.empty());
    Applier applier(*this, m_redo.back());
    applier.apply(Direction::Forth);
    try {
        if (then) then();
    } catch (...) {
        applier.apply(Direction::Back);
        applier.finish();
        m_lattice.drop_still_bricks();
        throw;
    }
    applier.finish();
    m_lattice.drop_still_bricks();
    m_undo.splice(m_undo.end(), m_redo, std::prev(m_redo.end()));
}

}  // namespace pliant
