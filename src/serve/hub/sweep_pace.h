// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Owns the pace of a tissue that moves by itself: the sweeps of each step, their measured rate, and
// the depth of forces that the time and the clients' lines allow.
//
// A model with simulated time runs in real time, if it can. It gets the time for that before
// commands and pictures: fewer pictures are better than tissue in slow motion. A model without time
// uses the time left by the commands: a sweep that takes long goes on in later steps, so that
// commands and pictures wait for a part of it only.

#pragma once

#include <array>
#include <list>
#include <optional>
#include <stop_token>

#include "hub/client.h"
#include "hub/recorder.h"
#include "session/scene.h"

namespace pliant::serve {

class SweepPace {
  public:
    struct Sweeps {
        /// Calls of Scene::sweep() in their order: whole sweeps and a part, then the rest of it.
        std::array<SessionSweeps, 2> made;
        double solve_ms = 0;
        bool ends_window = false;  ///< half a second of motion is over: see allowed_depth()
    };

    /// Sets the rate of updates that an automatic depth leaves to each client; 0: the lines have no
    /// effect.
    void want_updates(int hz) { m_network_hz = hz; }
    /// Makes the sweeps of a step, as long as they can be recorded. @param now  begin of the step
    /// @param command  stopped when a command waits: a long sweep is then left unfinished
    Sweeps relax(Scene& scene, Recorder& recorder, Clock::time_point now,
                 const std::stop_token& command);
    /// Depth of forces by the last half second of motion: the smaller one of those that the time
    /// and the slowest line allow. Empty if the clients haven't asked for an automatic depth.
    std::optional<int> allowed_depth(const Scene& scene, std::list<Client>& clients,
                                     Clock::time_point now);
    void describe(SharedState& state) const;
    /// Another scene begins: nothing is measured yet.
    void forget() { m_pace = m_update_hz = m_line_mb_s = 0; }

  private:
    static bool sweep(Scene& scene, const SweepLimit& limit, SessionSweeps& made, double& solve_ms);
    bool measure(const Scene& scene, const Sweeps& sweeps, double each_ms, double passed_ms);
    int depth_for_lines(std::list<Client>& clients, int depth, Clock::time_point now);

    int m_network_hz = 25;
    bool m_was_moving = false;  ///< a model with simulated time was in motion
    double m_owed_ms = 0;       ///< lag of the model's time
    Clock::time_point m_relaxed_at{};
    double m_window_ms = 0;        ///< time of this half second of motion
    double m_window_sweep_ms = 0;  ///< its simulated time
    double m_window_solve_ms = 0;  ///< its computing time
    double m_load = 0;             ///< computing time over simulated time, of the last one; 0: none
    double m_pace = 0, m_update_hz = 0, m_line_mb_s = 0;  ///< see SharedState
};

}  // namespace pliant::serve
