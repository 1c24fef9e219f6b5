// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Undo and redo as a user of ChainMail sees them.

#include "chainmail/chainmail_impl.h"

namespace pliant {
namespace {

Error open_group() {
    return {ErrorCode::InvalidArgument, "undo: expected no open group, found one; end it first"};
}

}  // namespace

/// The other imprints: those of before while the change is done, those of after while it's undone.
class ChainMail::Impl::ImprintChange final : public Exchange {
  public:
    ImprintChange(Impl& impl, std::vector<PlasticRest::Former> others)
        : m_impl(impl), m_others(std::move(others)) {}
    void exchange() override { m_impl.plastic_rest.exchange(m_impl.lattice, m_others); }
    std::size_t bytes() const override {
        // Either way it may be the fuller one; a step's size is asked for once.
        const auto n = std::size_t(m_impl.lattice.elements_per_brick());
        return sizeof *this + m_others.size() * (sizeof m_others[0] + 3 * n * sizeof(Fixed));
    }

  private:
    Impl& m_impl;
    std::vector<PlasticRest::Former> m_others;
};

int ChainMail::Impl::end_step() {
    // Of the outermost step, and also where it is told from another: exchanges are taken back in
    // turn.
    if (auto changes = plastic_rest.take_changes(); !changes.empty())
        history.add(std::make_unique<ImprintChange>(*this, std::move(changes)));
    return history.end();
}

Status ChainMail::undo() {
    m_impl->let_go();
    if (m_impl->history.is_open()) return open_group();
    if (m_impl->history.undo_steps() == 0)
        return Error{ErrorCode::NotFound, "undo: expected a step to take back, found none"};
    m_impl->history.undo();
    m_impl->restore_allowance();
    return Ok{};
}

Status ChainMail::redo() {
    m_impl->let_go();
    if (m_impl->history.is_open()) return open_group();
    if (m_impl->history.redo_steps() == 0)
        return Error{ErrorCode::NotFound, "redo: expected a step that was undone, found none"};
    m_impl->history.redo();
    m_impl->restore_allowance();
    return Ok{};
}

int ChainMail::undo_steps() const {
    return m_impl->history.undo_steps();
}
int ChainMail::redo_steps() const {
    return m_impl->history.redo_steps();
}
std::size_t ChainMail::history_bytes() const {
    return m_impl->history.bytes();
}
const std::string& ChainMail::next_undo_name() const {
    return m_impl->history.next_undo_name();
}
const std::string& ChainMail::next_redo_name() const {
    return m_impl->history.next_redo_name();
}
void ChainMail::begin_group(const std::string& name) {
    m_impl->begin_step(name);
}
int ChainMail::end_group() {
    return m_impl->end_step();
}

}  // namespace pliant
