// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The public interface of undo and redo.

#include "base/errors.h"
#include "chainmail/chainmail_impl.h"
#include "chainmail/operation.h"

namespace pliant {
namespace {

Error open_group() {
    return {ErrorCode::InvalidArgument, "undo: expected no open group, found one; end it first"};
}

}  // namespace

Status ChainMail::Impl::undo() {
    SuspendedDrag suspended(*this);
    if (history.is_open()) return open_group();
    if (!history.has_aside() && history.undo_steps() == 0) {
        Error none{ErrorCode::NotFound, "undo: expected a step to take back, found none"};
        suspended.end();
        return none;
    }
    history.undo([&] { restore_allowance(); });
    suspended.end();
    return Ok{};
}

Status ChainMail::Impl::redo() {
    SuspendedDrag suspended(*this);
    if (history.is_open()) return open_group();
    if (history.has_aside() || history.redo_steps() == 0) {
        Error none{ErrorCode::NotFound, "redo: expected a step that was undone, found none"};
        suspended.end();
        return none;
    }
    history.redo([&] { restore_allowance(); });
    suspended.end();
    return Ok{};
}

Status ChainMail::undo() {
    return attempt([&] { return m_impl->undo(); });
}
Status ChainMail::redo() {
    return attempt([&] { return m_impl->redo(); });
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
    m_impl->history.begin_anyway(name);
}
int ChainMail::end_group() {
    return m_impl->history.end();
}

}  // namespace pliant
