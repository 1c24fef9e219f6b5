// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/sweep_pace.h"

#include <algorithm>
#include <cmath>

#include "protocol/limits.h"

namespace pliant::serve {

SweepPace::Sweeps SweepPace::relax(Scene& scene, Recorder& recorder, Clock::time_point now,
                                   const std::stop_token& command) {
    const double each_ms = scene.sweep_time_ms();
    const double passed_ms = m_was_moving ? ms_between(m_relaxed_at, now) : each_ms;
    m_owed_ms = std::min(m_owed_ms + passed_ms, std::max(each_ms, kMaxOwedMs));
    m_relaxed_at = now;
    const Clock::time_point begin = each_ms > 0 ? Clock::now() : now;
    const std::chrono::milliseconds longest = each_ms > 0 ? kMotionTime : kRelaxTime;
    Sweeps sweeps;
    SessionSweeps& made = sweeps.made[0];
    while (scene.wants_sweep() && recorder.has_room() &&
           (made.count == 0 || Clock::now() - begin < longest)) {
        if (m_owed_ms < each_ms) break;
        m_owed_ms -= each_ms;
        SweepLimit limit;
        if (each_ms == 0) limit.max_ms = double(kRelaxTime.count());
        if (!sweep(scene, limit, made, sweeps.solve_ms) || made.parts) break;
    }
    // A sweep that takes long goes on until a command waits.
    if (made.parts && !command.stop_requested())
        sweep(scene, {.max_ms = double(kSweepTime.count()), .stop = command}, sweeps.made[1],
              sweeps.solve_ms);
    sweeps.ends_window = measure(scene, sweeps, each_ms, passed_ms);
    return sweeps;
}

/// Makes a sweep, or a part of one. @returns whether there was memory
bool SweepPace::sweep(Scene& scene, const SweepLimit& limit, SessionSweeps& made,
                      double& solve_ms) {
    const Result<Sweep> swept = scene.sweep(limit);
    if (!swept.ok()) return false;
    made.parts = swept->parts;
    if (!made.parts) ++made.count;
    solve_ms += swept->ms;
    return true;
}

/// Measures the rate of node updates. @returns whether half a second of motion is over
bool SweepPace::measure(const Scene& scene, const Sweeps& sweeps, double each_ms,
                        double passed_ms) {
    constexpr double kWindowMs = 500;
    if (m_was_moving) {
        m_window_ms += passed_ms;
        m_window_sweep_ms += sweeps.made[0].count * each_ms;
        m_window_solve_ms += sweeps.solve_ms;
    }
    m_was_moving = each_ms > 0 && scene.wants_sweep();
    if (!m_was_moving) m_owed_ms = 0;
    if (m_window_ms < kWindowMs && m_was_moving) return false;
    const bool is_long = m_window_ms > kWindowMs / 5;  // short motions are not representative
    if (is_long) {
        m_pace = m_window_sweep_ms / m_window_ms;
        m_load = m_window_solve_ms / m_window_sweep_ms;
        m_update_hz = std::round(scene.tissue().traits().update_hz * m_pace);
    }
    m_window_ms = m_window_sweep_ms = m_window_solve_ms = 0;
    return is_long;
}

std::optional<int> SweepPace::allowed_depth(const Scene& scene, std::list<Client>& clients,
                                            Clock::time_point now) {
    const TissueChoice& choice = scene.choice();
    const int depth = choice.springs.depth;
    m_line_mb_s = 0;
    if (!choice.depth_by_time) {
        for (Client& client : clients) {
            (void)client.line.take(depth, now);
            client.traffic.release();
        }
        return {};
    }
    if (m_pace <= 0) return {};
    return std::min(depth_for_time(depth, m_pace, m_load), depth_for_lines(clients, depth, now));
}

/// Depth that the lines to all clients take.
int SweepPace::depth_for_lines(std::list<Client>& clients, int depth, Clock::time_point now) {
    int layers = Traffic::kNoLimit;
    if (m_network_hz == 0) return layers;
    for (Client& client : clients) {
        if (!client.connection) continue;
        if (const auto sample = client.line.take(depth, now))
            client.traffic.take(*sample, m_network_hz);
        const int limit = std::max(client.traffic.limit(), kFewestLayers);
        if (limit >= layers) continue;
        layers = limit;
        // Two digits: a new value is sent to all clients.
        const double mb_s = client.traffic.bytes_per_s() / 1e6;
        const double digit = std::pow(10, std::floor(std::log10(mb_s)) - 1);
        m_line_mb_s = std::round(mb_s / digit) * digit;
    }
    return std::max(layers, std::min(depth, kFewestLayers));
}

void SweepPace::describe(SharedState& state) const {
    state.pace = m_pace;
    state.update_hz = m_update_hz;
    state.line_mb_s = m_line_mb_s;
}

}  // namespace pliant::serve
