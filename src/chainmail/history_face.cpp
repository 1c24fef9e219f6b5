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
