// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Steps: how they begin and end, are set aside, kept and forgotten.

#include "chainmail/history.h"

#include <algorithm>
#include <new>
#include <utility>

namespace pliant {
namespace {

/// Names up to this length are not truncated when memory is short.
constexpr std::size_t kUsualName = 47;

}  // namespace

History::History(Lattice& lattice, PlasticRest& rest, const TaskArena& arena, int max_steps,
                 std::size_t max_bytes)
    : m_lattice(lattice),
      m_rest(rest),
      m_arena(arena),
      m_max_steps(max_steps),
      m_max_bytes(max_bytes) {
    if (keeps_steps()) make_node();
    observe(false);
}

History::~History() {
    observe(false);
}

void History::start_copies() noexcept {
    recycle(m_copies);
    m_copies.step = ++m_last_step;
    observe(true);
}

/// Allocates the next step and its name.
void History::make_node() {
    if (m_node.empty()) m_node.emplace_back();
    m_node.front().name.reserve(kUsualName);
}

void History::begin_in_node() noexcept {
    m_open.splice(m_open.end(), m_node, m_node.begin());
    m_is_given_up = false;
    start_copies();
}

void History::begin(const std::string& name) {
    if (m_depth == 0 && keeps_steps()) {
        // The last step, if it could not be packed at its end.
        if (!has_aside() && !m_undo.empty() && !m_undo.back().is_packed) {
            try {
                pack_copies(m_undo.back());
            } catch (const std::bad_alloc&) {  // the next call tries again
            }
        }
        make_node();
        m_node.front().name = name;
        begin_in_node();
    }
    ++m_depth;
}

void History::begin_anyway(const std::string& name) noexcept {
    try {
        begin(name);
        return;
    } catch (const std::bad_alloc&) {
    }
    if (m_node.empty()) {
        Steps& farthest = m_redo.empty() ? m_undo : m_redo;
        m_bytes -= farthest.front().bytes;
        m_node.splice(m_node.end(), farthest, farthest.begin());
        clear_node();
    }
    std::string& cut = m_node.front().name;
    cut.assign(name, 0, std::min(name.size(), cut.capacity()));
    begin_in_node();
    ++m_depth;
}

int History::end() noexcept {
    PLIANT_ASSERT(m_depth > 0);
    if (--m_depth > 0 || !keeps_steps()) return 0;
    observe(false);
    if (m_is_given_up) {
        retire(m_open);
        clear();
        return -1;
    }
    close(m_open.front(), m_copies);
    return keep(m_open, m_copies);
}

void History::cancel(std::uint64_t made) noexcept {
    PLIANT_ASSERT(m_depth > 0);
    if (--m_depth > 0 || !keeps_steps()) return;
    observe(false);
    put_back(m_copies, made);
    retire(m_open);
}

void History::give_up() noexcept {
    if (m_depth == 0 || !keeps_steps()) return;
    m_is_given_up = true;
    observe(false);
    recycle(m_copies);
    m_spare.clear();
}

void History::make_room_for_exchange() {
    if (!m_open.empty()) m_open.front().exchanges.reserve(m_open.front().exchanges.size() + 1);
}

void History::add(std::unique_ptr<Exchange> exchange) {
    PLIANT_ASSERT(m_depth > 0);
    if (!m_open.empty()) m_open.front().exchanges.push_back(std::move(exchange));
}

void History::open_safeguard() noexcept {
    PLIANT_ASSERT(!m_has_safeguard);
    m_has_safeguard = true;
    m_outer = std::exchange(m_copies, {});
    start_copies();
}

void History::close_safeguard() noexcept {
    PLIANT_ASSERT(m_has_safeguard);
    m_has_safeguard = false;
    Copies inner = std::exchange(m_copies, std::exchange(m_outer, {}));
    const bool goes_on = !m_open.empty() && !m_is_given_up;
    observe(goes_on);
    if (goes_on) {
        // Data without a copy in the step had not changed before. Memory is reserved (before_move).
        while (!inner.moves.empty()) {
            auto node = inner.moves.extract(inner.moves.begin());
            const int index = m_lattice.find_brick(node.key());
            if (index >= 0) m_lattice.brick(index).saved_for = m_copies.step;
            m_copies.moves.insert(std::move(node));
        }
        while (!inner.edits.empty())
            m_copies.edits.insert(inner.edits.extract(inner.edits.begin()));
        while (!inner.imprints.empty())
            m_copies.imprints.insert(inner.imprints.extract(inner.imprints.begin()));
    }
    recycle(inner);
}

void History::cancel_safeguard(std::uint64_t made) noexcept {
    PLIANT_ASSERT(m_has_safeguard);
    m_has_safeguard = false;
    observe(false);
    put_back(m_copies, made);
    m_copies = std::exchange(m_outer, {});
    observe(!m_open.empty() && !m_is_given_up);
}

void History::set_aside() noexcept {
    PLIANT_ASSERT(m_depth > 0 && m_aside.empty());
    if (--m_depth > 0 || !keeps_steps()) return;
    observe(false);
    close(m_open.front(), m_copies);
    m_aside.splice(m_aside.end(), m_open);
    m_aside_copies = std::exchange(m_copies, {});
}

void History::reopen() noexcept {
    if (m_depth++ > 0 || !keeps_steps()) return;
    Step& step = m_aside.front();
    step.moves.clear();
    step.edits.clear();
    m_open.splice(m_open.end(), m_aside);
    m_copies = std::exchange(m_aside_copies, {});
    // Copies of unchanged bricks may have been dropped: they are taken again.
    m_copies.step = ++m_last_step;
    observe(true);
}

int History::settle() noexcept {
    return m_aside.empty() ? 0 : keep(m_aside, m_aside_copies);
}

std::size_t History::bytes_of(const Step& step) const {
    const auto n = std::size_t(m_lattice.elements_per_brick());
    std::size_t bytes = sizeof(Step) + step.name.size();
    for (const auto* pieces : {&step.moves, &step.edits})
        for (const Piece& piece : *pieces)
            bytes += sizeof(Piece) + piece.packed.size() + piece.coords.size() * sizeof(Vec3i);
    for (const auto& exchange : step.exchanges) bytes += exchange->bytes();
    bytes += (step.imprints.size() + step.copies.moves.size()) * (sizeof(Vec3i) + 12 * n);
    return bytes + step.copies.edits.size() * (sizeof(Vec3i) + n);
}

/// @param step  closed, in a list of one; the list is empty then
int History::keep(Steps& step, Copies& copies) noexcept {
    Step& kept = step.front();
    kept.imprints = std::exchange(copies.imprints, {});
    if (!kept.is_packed) std::swap(kept.copies, copies);
    recycle(copies);
    if (!kept.is_any) {
        retire(step);
        return 0;
    }
    kept.bytes = bytes_of(kept);
    for (const Step& undone : m_redo) m_bytes -= undone.bytes;
    retire(m_redo);
    if (kept.bytes > m_max_bytes) {
        retire(step);
        clear();
        return -1;
    }
    m_bytes += kept.bytes;
    m_undo.splice(m_undo.end(), step);
    int forgotten = 0;
    while (int(m_undo.size()) > m_max_steps || m_bytes > m_max_bytes) {
        m_bytes -= m_undo.front().bytes;
        m_undo.pop_front();
        ++forgotten;
    }
    try {
        make_node();  // so that the next step can begin when memory is short
    } catch (const std::bad_alloc&) {
    }
    return forgotten;
}

/// Forgets steps, but keeps the memory of one of them.
void History::retire(Steps& steps) noexcept {
    if (m_node.empty() && !steps.empty()) {
        m_node.splice(m_node.end(), steps, steps.begin());
        clear_node();
    }
    steps.clear();
}

void History::clear_node() noexcept {
    std::string name = std::move(m_node.front().name);  // with its memory
    m_node.front() = {};
    name.clear();
    m_node.front().name = std::move(name);
}

void History::clear() noexcept {
    retire(m_undo);
    retire(m_redo);
    m_bytes = 0;
}

}  // namespace pliant
