// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/recorder.h"

#include <algorithm>
#include <cstdio>
#include <type_traits>
#include <utility>

#include "session/checkpoint.h"
#include "session/guarded.h"

namespace pliant::serve {

void Recorder::keep_checkpoints(double seconds, int so_far) {
    m_checkpoint_ms = 1000 * seconds;
    m_checkpoints = so_far;
}

bool Recorder::has_room() noexcept {
    constexpr std::size_t kRoom = 16;  // more than the records between two calls
    if (!m_log) return true;
    if (m_log->is_full()) return false;
    if (m_waiting.capacity() - m_waiting.size() >= kRoom) return true;
    return guarded("owner", [&] { m_waiting.reserve(2 * m_waiting.size() + kRoom); });
}

void Recorder::note(SessionRecord record) noexcept {
    static_assert(std::is_nothrow_move_constructible_v<SessionRecord>);
    if (!m_log) return;
    // The time that has passed, for a replay in the page.
    if (m_noted_at == Clock::time_point{}) m_noted_at = m_now;
    const auto passed = std::chrono::duration_cast<std::chrono::milliseconds>(m_now - m_noted_at);
    if (passed >= kSessionTick) {
        m_waiting.push_back(SessionWait{int(std::min<std::int64_t>(passed.count(), kMaxWait_ms))});
        m_noted_at += passed;
    }
    m_waiting.push_back(std::move(record));
}

/// Turns the waiting records into lines of the log.
void Recorder::encode() {
    for (; !m_waiting.empty(); m_waiting.erase(m_waiting.begin())) m_log->add(m_waiting.front());
}

void Recorder::write() {
    constexpr auto kPause = std::chrono::seconds(1);
    if (!m_log) return;
    guarded("owner", [&] { encode(); });
    const bool is_due = m_now - m_written_at >= kPause;
    if (!m_is_recorded && !is_due) return;
    Status s = m_log->flush();
    if (s.ok() && is_due) s = m_log->check_path();
    if (is_due) m_written_at = m_now;
    if (s.ok() == m_is_recorded) return;
    m_is_recorded = s.ok();
    if (s.ok())
        std::fprintf(stderr, "pliant: %s: the session is recorded again\n", m_log->path().c_str());
    else
        std::fprintf(stderr, "pliant: %s; the session is not recorded meanwhile\n",
                     s.error().message.c_str());
}

Result<SessionPart> Recorder::part() {
    if (!m_log)
        return Error{ErrorCode::Unwritable,
                     "session.pls: expected a session that is recorded, found none"};
    encode();
    return m_log->part();
}

void Recorder::count_work(double solve_ms, bool has_worked) {
    m_unsaved_ms += solve_ms;
    m_is_unsaved = m_is_unsaved || has_worked;
}

void Recorder::forget_work() {
    m_unsaved_ms = 0;
    m_is_unsaved = false;
}

bool Recorder::wants_checkpoint() const {
    return has_file() && m_is_recorded && m_is_unsaved && m_unsaved_ms >= m_checkpoint_ms;
}

void Recorder::save_checkpoint(Scene& scene) {
    forget_work();
    Status saved = Ok{};
    auto point = serve::save_checkpoint(scene, m_log->path(), m_checkpoints + 1, saved);
    if (!point.ok()) {
        scene.interrupt(0);
        return note(SessionBreak{});
    }
    ++m_checkpoints;
    note(std::move(*point));
    if (!saved.ok())
        std::fprintf(stderr, "pliant: %s; the session goes on without this checkpoint\n",
                     saved.error().message.c_str());
}

}  // namespace pliant::serve
