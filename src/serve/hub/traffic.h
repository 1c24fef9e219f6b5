// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The depth of forces that the time at hand and a client's line allow [Choi2004, 5].
//
//   voxels of an update ──► Line: bytes, time until seen ──► Traffic: bytes of a depth ──► limit
//
// Fewer layers make smaller updates, but not by the cube of the depth: a tool that holds a region
// changes it at any depth, and a lattice ends. So the bytes of each depth are measured while it is
// used, and a limit is set only where these measurements promise the wanted rate, or much less to
// send. Depths that were not used yet are extrapolated, and corrected after the next half second.

#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "protocol/limits.h"

namespace pliant::serve {

inline constexpr int kFewestLayers = 1, kMostLayers = 20;

/// Depth for the next half second. The nodes within a depth grow with its cube, so a motion that
/// falls behind loses layers by the cube root of its pace; one that has time to spare gains one at
/// a time, and only if that leaves some.
/// @param pace  simulated over real time, at most about 1
/// @param load  computing time over simulated time
inline int depth_for_time(int depth, double pace, double load) {
    constexpr double kSlow = 0.95, kSpare = 0.7;
    if (pace < kSlow) {
        const int lower = int(std::floor(depth * std::cbrt(std::max(0.0, pace))));
        return std::max(std::min(lower, depth - 1), std::min(depth, kFewestLayers));
    }
    const double next = load * std::pow((depth + 1.0) / std::max(1, depth), 3);
    return next < kSpare && depth < kMostLayers ? depth + 1 : depth;
}

/// Mean of a few updates of the voxels at one depth of forces.
struct LineSample {
    int depth = 0;
    double update_bytes = 0;  ///< of an update, with everything else that was sent meanwhile
    /// Bytes per second while the line was busy; a lower bound if it was often idle, because the
    /// way to the client and back is included.
    double bytes_per_s = 0;
    /// Share of the server's steps in which voxels were due, but the line was not free.
    double blocked = 0;
};

/// Measures the line to a client by its acknowledgements: they also see the buffers between.
class Line {
  public:
    using Clock = std::chrono::steady_clock;

    /// A batch is passed to the network. @param has_voxels  of an update
    void sent(std::size_t bytes, bool has_voxels, Clock::time_point now) noexcept;
    /// Marks the last batch of an update. @param depth  of forces, in this step
    void ended_update(std::uint32_t step, int depth) noexcept;
    void seen(std::uint32_t step, Clock::time_point now);
    /// Voxels are due in this step of the server. @param is_free  they can be sent
    void due(bool is_free);
    /// @returns the mean since the last sample; empty while there are too few updates
    std::optional<LineSample> take(int depth, Clock::time_point now);

  private:
    struct Update {
        std::uint32_t step = 0;
        int depth = 0;
        std::size_t bytes = 0;
        Clock::time_point since{};
    };
    void start(int depth, Clock::time_point now);
    void forget(std::size_t oldest);

    std::size_t m_bytes = 0;                      ///< since the end of the last update
    bool m_is_open = false;                       ///< an update has begun
    Clock::time_point m_since{};                  ///< its begin
    static constexpr std::size_t kMaxUnseen = 4;  ///< more than a client may have
    std::array<Update, kMaxUnseen> m_sent{};      ///< not seen yet, oldest first
    std::size_t m_unseen = 0;
    Clock::time_point m_seen_at{};
    // The present sample.
    int m_depth = -1;
    int m_skipped = 0;  ///< updates that may hold voxels of the depth before
    Clock::time_point m_begin{};
    int m_updates = 0, m_due = 0, m_blocked = 0;
    double m_sum_bytes = 0, m_busy_s = 0;
};

/// Decides on the depth for one client. Depends on the samples alone.
class Traffic {
  public:
    static constexpr int kNoLimit = kMaxDepthLayers;
    static constexpr int kFirstPause = 4;  ///< samples

    /// Takes the sample of half a second or more. @param wanted_hz  updates per second
    void take(const LineSample& sample, double wanted_hz);
    /// Largest depth for this client.
    int limit() const { return m_limit; }
    double bytes_per_s() const { return m_bytes_per_s; }
    /// The depth isn't automatic: there is no limit. Measured bytes are kept.
    void release();

    /// Expected bytes of an update: measured, interpolated or extrapolated. @pre there was a sample
    double bytes_at(int depth) const;

  private:
    void learn(int depth, double bytes);
    int deepest_within(double bytes, int most) const;
    int deepest_of_the_smallest(int most) const;
    void lower(const LineSample& sample, double allowed);
    void raise(const LineSample& sample, double allowed);

    std::array<double, kMaxDepthLayers + 1> m_bytes{};  ///< by depth; 0: not measured
    int m_limit = kNoLimit;
    double m_bytes_per_s = 0;
    // Hysteresis, in samples.
    int m_since_lower = 0;
    bool m_has_failed = false;  ///< the last sample nearly had the wanted rate
    bool m_has_raised = false;  ///< since the depth was last lowered
    int m_pause = kFirstPause;  ///< from a lower depth to a higher one
    double m_failed_at = 0;     ///< bytes that an update might have when a higher depth failed
    std::optional<LineSample> m_before;  ///< at the depth before it was lowered
    int m_useless = 0;                   ///< lower depths in a row that made no more updates
    int m_hold = 0, m_next_hold = 0;     ///< the depth isn't lowered: bytes are not the limit
};

}  // namespace pliant::serve
