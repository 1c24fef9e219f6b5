// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/history.h"

#include <algorithm>
#include <cstring>
#include <tuple>
#include <utility>

namespace pliant {
namespace {

/// Bricks that are packed together: about 100 kB before packing.
constexpr std::size_t kBricksPerPiece = 16;
/// Copies that are kept for the next step's use, 6 MB for bricks of 8³; the rest is given back.
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

}  // namespace

History::History(Lattice& lattice, const TaskArena& arena, int max_steps, std::size_t max_bytes)
    : m_lattice(lattice), m_arena(arena), m_max_steps(max_steps), m_max_bytes(max_bytes) {
    m_lattice.set_observer(nullptr);
}

History::~History() {
    m_lattice.set_observer(nullptr);
}

void History::begin(std::string name) {
    if (m_depth++ > 0 || m_max_steps == 0) return;
    m_open = {};
    m_open.name = std::move(name);
    ++m_step;
    m_lattice.set_observer(this);
}

int History::end() {
    PLIANT_ASSERT(m_depth > 0);
    if (--m_depth > 0 || m_max_steps == 0) return 0;
    m_lattice.set_observer(nullptr);
    m_open.moves = pack_moves();
    m_open.edits = pack_edits();
    forget_saved();
    if (m_open.moves.empty() && m_open.edits.empty() && m_open.exchanges.empty()) return 0;
    return keep(std::exchange(m_open, {}));
}

void History::add(std::unique_ptr<Exchange> exchange) {
    PLIANT_ASSERT(m_depth > 0);
    if (m_max_steps > 0) m_open.exchanges.push_back(std::move(exchange));
}

void History::before_move(Brick& brick) {
    if (brick.saved_for == m_step) return;
    brick.saved_for = m_step;
    const std::lock_guard lock(m_mutex);
    const auto [entry, is_new] = m_saved_moves.try_emplace(brick.coord);
    if (!is_new) return;
    if (brick.u_min == Vec3<Fixed>{0, 0, 0} && brick.u_max == Vec3<Fixed>{0, 0, 0}) return;
    const auto n = std::size_t(m_lattice.elements_per_brick());
    if (m_spare.empty()) {
        entry->second.u = std::make_unique_for_overwrite<Fixed[]>(3 * n);
    } else {
        entry->second.u = std::move(m_spare.back());
        m_spare.pop_back();
    }
    for (std::size_t a = 0; a < 3; ++a)
        std::memcpy(entry->second.u.get() + a * n, brick.u[a], n * sizeof(Fixed));
}

void History::before_edit(Vec3i coord, const BrickEdits* edits) {
    if (m_saved_edits.contains(coord)) return;
    m_saved_edits.emplace(
        coord, edits ? *edits : BrickEdits(std::size_t(m_lattice.elements_per_brick()), 0));
}

void History::forget_saved() {
    for (auto& [coord, saved] : m_saved_moves)
        if (saved.u && m_spare.size() < kMaxSpare) m_spare.push_back(std::move(saved.u));
    m_saved_moves.clear();
    m_saved_edits.clear();
}

void History::pack_piece(std::span<const Vec3i> coords, Piece& piece) const {
    const auto n = std::size_t(m_lattice.elements_per_brick());
    static thread_local std::vector<Fixed> rest;
    static thread_local Bytes raw;
    rest.resize(n, 0);
    raw.clear();
    for (const Vec3i& coord : coords) {
        const Fixed* saved = m_saved_moves.at(coord).u.get();
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

std::vector<History::Piece> History::pack_moves() {
    const std::vector<Vec3i> coords = sorted_coords(m_saved_moves);
    std::vector<Piece> pieces((coords.size() + kBricksPerPiece - 1) / kBricksPerPiece);
    m_arena.for_each(std::int64_t(pieces.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (auto k = std::size_t(begin); k < std::size_t(end); ++k) {
            const std::size_t first = k * kBricksPerPiece;
            const std::size_t count = std::min(kBricksPerPiece, coords.size() - first);
            pack_piece(std::span(coords).subspan(first, count), pieces[k]);
        }
    });
    std::erase_if(pieces, [](const Piece& piece) { return piece.coords.empty(); });
    return pieces;
}

std::vector<History::Piece> History::pack_edits() {
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
    for (const Vec3i& coord : sorted_coords(m_saved_edits)) {
        BrickEdits change = m_saved_edits.at(coord);
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

int History::keep(Step step) {
    step.bytes = sizeof(Step) + step.name.size();
    for (const auto* pieces : {&step.moves, &step.edits})
        for (const Piece& piece : *pieces)
            step.bytes += sizeof(Piece) + piece.packed.size() + piece.coords.size() * sizeof(Vec3i);
    for (const auto& exchange : step.exchanges) step.bytes += exchange->bytes();
    for (const Step& undone : m_redo) m_bytes -= undone.bytes;
    m_redo.clear();
    if (step.bytes > m_max_bytes) {
        clear();
        return -1;
    }
    m_bytes += step.bytes;
    m_undo.push_back(std::move(step));
    int forgotten = 0;
    while (int(m_undo.size()) > m_max_steps || m_bytes > m_max_bytes) {
        m_bytes -= m_undo.front().bytes;
        m_undo.pop_front();
        ++forgotten;
    }
    return forgotten;
}

void History::clear() {
    m_undo.clear();
    m_redo.clear();
    m_bytes = 0;
}

void History::undo() {
    PLIANT_ASSERT(m_depth == 0 && !m_undo.empty());
    m_redo.push_back(std::move(m_undo.back()));
    m_undo.pop_back();
    apply(m_redo.back(), Direction::Back);
}

void History::redo() {
    PLIANT_ASSERT(m_depth == 0 && !m_redo.empty());
    m_undo.push_back(std::move(m_redo.back()));
    m_redo.pop_back();
    apply(m_undo.back(), Direction::Forth);
}

void History::apply(Step& step, Direction direction) {
    m_lattice.tick();
    // Bricks first, one after the other; then their displacements, each piece by itself.
    for (const Piece& piece : step.moves)
        for (const Vec3i& coord : piece.coords) m_lattice.ensure_brick(coord);
    m_arena.for_each(std::int64_t(step.moves.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (auto k = std::size_t(begin); k < std::size_t(end); ++k)
            apply_moves(step.moves[k], direction);
    });
    for (const Piece& piece : step.edits) apply_edits(piece);
    // What was changed last is taken back first.
    if (direction == Direction::Back) std::reverse(step.exchanges.begin(), step.exchanges.end());
    for (const auto& exchange : step.exchanges) exchange->exchange();
    if (direction == Direction::Back) std::reverse(step.exchanges.begin(), step.exchanges.end());
    m_lattice.drop_still_bricks();
}

void History::apply_moves(const Piece& piece, Direction direction) {
    const auto n = std::size_t(m_lattice.elements_per_brick());
    Bytes raw(piece.raw_size);
    std::vector<std::uint32_t> change(3 * n);
    bool whole = unpack(piece.packed, raw);
    std::span<const std::byte> left = raw;
    for (const Vec3i& coord : piece.coords) {
        whole = whole && decode_change(left, m_lattice.brick_size(),
                                       {change.data(), change.data() + n, change.data() + 2 * n});
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

void History::apply_edits(const Piece& piece) {
    const auto n = std::size_t(m_lattice.elements_per_brick());
    Bytes raw(piece.raw_size);
    const bool whole = unpack(piece.packed, raw);
    PLIANT_ASSERT(whole);
    if (!whole) return;
    for (std::size_t k = 0; k < piece.coords.size(); ++k) {
        const BrickEdits* now = m_lattice.edits_of(piece.coords[k]);
        BrickEdits edits = now ? *now : BrickEdits(n, 0);
        for (std::size_t i = 0; i < n; ++i) edits[i] ^= std::uint8_t(raw[k * n + i]);
        m_lattice.set_edits(piece.coords[k], std::move(edits));
    }
}

}  // namespace pliant
