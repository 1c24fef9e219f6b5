// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Owns the recording of a session: the records of all changes of the scene, in order, and the
// checkpoints of its state.
//
//   has_room() ──► change of the scene ──► note() ──► once per step: write() ──► the session's file
//
// The memory for records is reserved before a change, so that a change is never made and not
// recorded. Records become text in write(), which may fail and is repeated.

#pragma once

#include <memory>
#include <vector>

#include "hub/client.h"
#include "session/scene.h"
#include "session/session_log.h"

namespace pliant::serve {

class Recorder {
  public:
    /// @param log  null: nothing is recorded
    explicit Recorder(std::unique_ptr<SessionLog> log) : m_log(std::move(log)) {}
    /// Enables checkpoints. @param seconds  of work between two  @param so_far  in the session
    void keep_checkpoints(double seconds, int so_far);

    /// Whether the session has a file of its own, which outlives the program.
    bool has_file() const { return m_log && !m_log->is_nameless(); }
    /// Whether the session's file has all records.
    bool is_recorded() const { return m_log && m_is_recorded; }
    /// Whether the disk is full, and so are the records that wait for it.
    bool is_full() const { return m_log && m_log->is_full(); }
    /// Reserves memory for the records of a change.
    /// @returns false if the change can't be recorded, and so may not be made
    bool has_room() noexcept;

    void start_step(Clock::time_point now) { m_now = now; }
    /// Adds a record. @pre has_room() before the change
    void note(SessionRecord record) noexcept;
    /// Writes the session. On failure its records stay in memory, and the write is repeated each
    /// second.
    void write();
    /// Records of the current scene so far.
    Result<SessionPart> part();

    /// Counts the work of a step for the next checkpoint.
    void count_work(double solve_ms, bool has_worked);
    /// Forgets that work, because another scene begins.
    void forget_work();
    bool wants_checkpoint() const;
    /// Saves the state of a scene, which is at rest afterwards.
    void save_checkpoint(Scene& scene);

  private:
    void encode();

    std::unique_ptr<SessionLog> m_log;
    std::vector<SessionRecord> m_waiting;  ///< not encoded yet
    bool m_is_recorded = true;             ///< whether the last write succeeded
    Clock::time_point m_now{};             ///< begin of the step
    Clock::time_point m_written_at{};      ///< time of the last write
    Clock::time_point m_noted_at{};        ///< time of the last SessionWait
    double m_checkpoint_ms = 0;            ///< work between two checkpoints
    double m_unsaved_ms = 0;               ///< work since the last checkpoint
    bool m_is_unsaved = false;             ///< whether there was work
    int m_checkpoints = 0;                 ///< number in the session
};

}  // namespace pliant::serve
