// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/operation.h"

#include <algorithm>
#include <utility>

namespace pliant {

ChainMail::Impl::SuspendedDrag::SuspendedDrag(Impl& impl) noexcept
    : m_impl(impl), m_offset(impl.drag_offset), m_reach(impl.drag_reach) {
    if (impl.held.empty()) return;
    impl.drop_fields();
    impl.steps_without_fields.reset();
    m_held.swap(impl.held);
    impl.history.set_aside();
}

ChainMail::Impl::SuspendedDrag::~SuspendedDrag() {
    if (m_is_over) return;
    m_impl.drop_fields();
    m_impl.steps_without_fields.reset();
    m_impl.held.swap(m_held);  // a drag that could not begin is thereby ended
    m_impl.drag_offset = m_offset;
    m_impl.drag_reach = m_reach;
    if (m_impl.held.empty()) return;
    m_impl.steps_without_fields = 0;
    m_impl.history.reopen();
}

void ChainMail::Impl::SuspendedDrag::end() noexcept {
    m_is_over = true;
    m_impl.history.settle();
}

ChainMail::Impl::Operation::Operation(Impl& impl, Kind kind)
    : m_impl(impl), m_made(impl.lattice.made_count()) {
    if (impl.operation) {
        m_is_part = true;
        return;
    }
    if (kind.ends_drag) m_drag.emplace(impl);
    if (kind.step) {
        impl.history.begin(kind.step);
        m_is_step = true;
        m_owns_copies = impl.history.keeps_steps() && impl.history.depth() == 1;
    }
    impl.operation = this;
    if (kind.has_copies) keep_copies();
}

void ChainMail::Impl::Operation::keep_copies() noexcept {
    if (m_is_part || m_owns_copies || m_has_safeguard) return;
    m_impl.history.open_safeguard();
    m_has_safeguard = true;
}

ChainMail::Impl::Operation::~Operation() {
    roll_back();
}

void ChainMail::Impl::Operation::roll_back() noexcept {
    if (m_is_part || m_is_over) return;
    m_is_over = true;
    m_impl.operation = nullptr;
    m_impl.abandon_solve();
    if (m_impl.has_fields) {  // they may belong to a later position
        m_impl.drop_fields();
        m_impl.steps_without_fields = 0;
    }
    if (m_has_safeguard) m_impl.history.cancel_safeguard(m_made);
    if (m_is_step) m_impl.history.cancel(m_made);
    m_impl.lattice.drop_made_since(m_made);
    m_drag.reset();
}

void ChainMail::Impl::Operation::close_safeguard() noexcept {
    m_is_over = true;
    m_impl.operation = nullptr;
    if (m_has_safeguard) m_impl.history.close_safeguard();
}

int ChainMail::Impl::Operation::commit() noexcept {
    if (m_is_part) return 0;
    close_safeguard();
    if (m_drag) m_drag->end();
    return m_is_step ? m_impl.history.end() : 0;
}

void ChainMail::Impl::Operation::commit_open() noexcept {
    if (m_is_part) return;
    close_safeguard();
    if (m_drag) m_drag->end();
}

void ChainMail::Impl::abandon_solve() noexcept {
    lattice.for_each_brick([](Brick& brick) { brick.reached = {}; });
    std::fill(work.nodes.begin(), work.nodes.end(), SweepWork::Node{});
}

}  // namespace pliant
