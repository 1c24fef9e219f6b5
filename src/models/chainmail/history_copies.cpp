// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Copies of bricks before they change: taking, packing and restoring them.

#include <algorithm>
#include <cstring>
#include <new>
#include <tuple>
#include <utility>

#include "chainmail/history.h"

namespace pliant {
namespace {

/// Bricks that are packed together: about 100 kB before packing.
constexpr std::size_t kBricksPerPiece = 16;
/// Number of copies kept for reuse by the next step, 6 MB for bricks of 8³; the rest is freed.
constexpr std::size_t kMaxSpare = 1024;

template <class Map>
std::vector<Vec3i> sorted_coords(const Map& map) {
    std::vector<Vec3i> coords;
    coords.reserve(map.size());
    for (const auto& entry : map) coords.push_back(entry.first);
    std::sort(coords.begin(), coords.end(),
              [](Vec3i p, Vec3i q) { return std::tie(p.z, p.y, p.x) < std::tie(q.z, q.y, q.x); });
    return coords;
}

/// Reserves room for a safeguard's entries in the copies of the step, which receive them at its
/// close.
template <class Map>
void make_room(Map& outer, const Map& inner) {
    const std::size_t count = outer.size() + inner.size() + 1;
    if (double(count) > double(outer.bucket_count()) * double(outer.max_load_factor()))
        outer.reserve(2 * count);
}

}  // namespace

/// Entry of a brick in the copies, created if needed. All memory is allocated before the entry is
/// created. @pre m_mutex is locked
History::Saved& History::reserve(const Brick& brick) {
    if (const auto found = m_copies.moves.find(brick.coord); found != m_copies.moves.end())
        return found->second;
    if (m_has_safeguard && keeps_steps()) make_room(m_outer.moves, m_copies.moves);
    Saved saved;
    if (!is_at_rest(brick)) {
        saved.is_copied = false;
        if (m_spare.empty()) {
            const auto n = std::size_t(m_lattice.elements_per_brick());
            saved.u = std::make_unique_for_overwrite<Fixed[]>(3 * n);
        } else {
            saved.u = std::move(m_spare.back());
            m_spare.pop_back();
        }
    }
    return m_copies.moves.emplace(brick.coord, std::move(saved)).first->second;
}

void History::reserve_move(Brick& brick) {
    if (brick.saved_for == m_copies.step) return;
    const std::lock_guard lock(m_mutex);
    if (reserve(brick).is_copied) brick.saved_for = m_copies.step;
}

void History::before_move(Brick& brick) {
    if (brick.saved_for == m_copies.step) return;
    Saved* saved = nullptr;
    {
        const std::lock_guard lock(m_mutex);
        saved = &reserve(brick);  // its address stays valid while others are added
    }
    if (!saved->is_copied) {
        // A brick that was reserved by a failed operation may be at rest now.
        if (is_at_rest(brick)) saved->u.reset();
        const auto n = std::size_t(m_lattice.elements_per_brick());
        for (std::size_t a = 0; a < 3 && saved->u; ++a)
            std::memcpy(saved->u.get() + a * n, brick.u[a], n * sizeof(Fixed));
        saved->is_copied = true;
    }
    brick.saved_for = m_copies.step;
}

void History::before_edit(Vec3i coord, const BrickEdits* edits) {
    if (m_copies.edits.contains(coord)) return;
    if (m_has_safeguard && keeps_steps()) make_room(m_outer.edits, m_copies.edits);
    m_copies.edits.emplace(coord, edits ? *edits : BrickEdits{});
}

void History::before_imprint(Vec3i coord, const PlasticBrick* imprint) {
    if (m_copies.imprints.contains(coord)) return;
    if (m_has_safeguard && keeps_steps()) make_room(m_outer.imprints, m_copies.imprints);
    m_copies.imprints.emplace(coord, imprint ? *imprint : PlasticBrick{});
}

void History::recycle(Copies& copies) noexcept {
    try {
        for (auto& [coord, saved] : copies.moves)
            if (saved.u && keeps_steps() && m_spare.size() < kMaxSpare)
                m_spare.push_back(std::move(saved.u));
    } catch (const std::bad_alloc&) {  // they are freed then
    }
    copies.moves.clear();
    copies.edits.clear();
    copies.imprints.clear();
}

bool History::is_unchanged(Vec3i coord, const Saved& saved) const {
    if (!saved.is_copied) return true;
    const int index = m_lattice.find_brick(coord);
    if (index < 0) return !saved.u;
    const Brick& brick = m_lattice.brick(index);
    if (brick.is_unplaced) return !saved.u;
    const auto n = std::size_t(m_lattice.elements_per_brick());
    for (std::size_t a = 0; a < 3; ++a) {
        const Fixed* now = brick.u[a];
        const bool same = saved.u ? std::equal(now, now + n, saved.u.get() + a * n)
                                  : std::all_of(now, now + n, [](Fixed u) { return u == 0; });
        if (!same) return false;
    }
    return true;
}

void History::drop_unchanged(Copies& copies) const noexcept {
    std::erase_if(copies.moves,
                  [&](const auto& entry) { return is_unchanged(entry.first, entry.second); });
    std::erase_if(copies.edits, [&](const auto& entry) {
        const BrickEdits* now = m_lattice.edits_of(entry.first);
        return now ? *now == entry.second : entry.second.empty();
    });
}

/// Packs changed bricks into the step. If memory is short they stay in the copies.
void History::close(Step& step, Copies& copies) const noexcept {
    std::erase_if(copies.imprints, [&](const auto& entry) {
        const PlasticBrick* now = m_rest.find(entry.first);
        return now ? now->imprint == entry.second.imprint : entry.second.imprint[0].empty();
    });
    try {
        step.moves = pack_moves(copies.moves);
        step.edits = pack_edits(copies.edits);
        step.is_packed = true;
        step.is_any = !step.moves.empty() || !step.edits.empty();
    } catch (const std::bad_alloc&) {
        step.moves.clear();
        step.edits.clear();
        step.is_packed = false;
        drop_unchanged(copies);
        step.is_any = !copies.moves.empty() || !copies.edits.empty();
    }
    step.is_any |= !copies.imprints.empty() || !step.exchanges.empty();
}

/// Packs a step that was kept as copies. @pre the lattice is as it was at the step's end
void History::pack_copies(Step& step) {
    std::vector<Piece> moves = pack_moves(step.copies.moves);
    step.edits = pack_edits(step.copies.edits);
    step.moves = std::move(moves);
    step.is_packed = true;
    recycle(step.copies);
    m_bytes -= std::exchange(step.bytes, bytes_of(step));
    m_bytes += step.bytes;
}

void History::put_back(Copies& copies, std::uint64_t made) noexcept {
    bool any = false;
    const auto write = [&](int index, const Fixed* u) {
        const auto n = std::size_t(m_lattice.elements_per_brick());
        if (!std::exchange(any, true)) m_lattice.tick();
        Brick& brick = m_lattice.brick(index);
        for (std::size_t a = 0; a < 3; ++a)
            if (u)
                std::copy_n(u + a * n, n, brick.u[a]);
            else
                std::fill_n(brick.u[a], n, 0);
        brick.is_unplaced = false;
        brick.changed_at = m_lattice.clock();
        m_lattice.update_bounds(index);
    };
    std::erase_if(copies.moves,
                  [&](const auto& entry) { return is_unchanged(entry.first, entry.second); });
    for (const auto& [coord, saved] : copies.moves)
        if (!saved.u) write(m_lattice.find_brick(coord), nullptr);
    // Frees memory for the bricks that are created again below.
    m_lattice.drop_made_since(made);
    for (const auto& [coord, saved] : copies.moves)
        if (saved.u) write(m_lattice.ensure_brick(coord), saved.u.get());
    m_rest.restore(m_lattice, copies.imprints);
    m_lattice.restore_edits(copies.edits);
    recycle(copies);
}

void History::pack_piece(const CoordMoves& moves, std::span<const Vec3i> coords,
                         Piece& piece) const {
    const auto n = std::size_t(m_lattice.elements_per_brick());
    static thread_local std::vector<Fixed> rest;
    static thread_local Bytes raw;
    rest.resize(n, 0);
    raw.clear();
    for (const Vec3i& coord : coords) {
        const Saved& copy = moves.at(coord);
        if (!copy.is_copied) continue;
        const Fixed* saved = copy.u.get();
        const int index = m_lattice.find_brick(coord);
        if (!saved && index < 0) continue;
        Components before, after;
        for (std::size_t a = 0; a < 3; ++a) {
            before[a] = saved ? saved + a * n : rest.data();
            after[a] = index < 0 ? rest.data() : m_lattice.brick(index).u[a];
        }
        if (encode_change(before, after, m_lattice.brick_size(), raw))
            piece.coords.push_back(coord);
    }
    piece.coords.shrink_to_fit();
    piece.raw_size = raw.size();
    if (!raw.empty()) piece.packed = pack(raw);
}

std::vector<History::Piece> History::pack_moves(const CoordMoves& moves) const {
    const std::vector<Vec3i> coords = sorted_coords(moves);
    std::vector<Piece> pieces((coords.size() + kBricksPerPiece - 1) / kBricksPerPiece);
    m_arena.for_each(std::int64_t(pieces.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (auto k = std::size_t(begin); k < std::size_t(end); ++k) {
            const std::size_t first = k * kBricksPerPiece;
            const std::size_t count = std::min(kBricksPerPiece, coords.size() - first);
            pack_piece(moves, std::span(coords).subspan(first, count), pieces[k]);
        }
    });
    std::erase_if(pieces, [](const Piece& piece) { return piece.coords.empty(); });
    return pieces;
}

std::vector<History::Piece> History::pack_edits(const EditMap& edits) const {
    std::vector<Piece> pieces;
    std::vector<std::byte> raw;
    Piece piece;
    const auto finish = [&] {
        if (piece.coords.empty()) return;
        piece.raw_size = raw.size();
        piece.packed = pack(raw);
        pieces.push_back(std::exchange(piece, {}));
        raw.clear();
    };
    for (const Vec3i& coord : sorted_coords(edits)) {
        BrickEdits change = edits.at(coord);
        change.resize(std::size_t(m_lattice.elements_per_brick()), 0);
        if (const BrickEdits* now = m_lattice.edits_of(coord))
            for (std::size_t n = 0; n < change.size(); ++n) change[n] ^= (*now)[n];
        if (std::all_of(change.begin(), change.end(), [](auto flags) { return flags == 0; }))
            continue;
        piece.coords.push_back(coord);
        for (const std::uint8_t flags : change) raw.push_back(std::byte(flags));
        if (piece.coords.size() == kBricksPerPiece) finish();
    }
    finish();
    return pieces;
}

}  // namespace pliant
