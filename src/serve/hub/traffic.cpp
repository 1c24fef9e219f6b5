// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/traffic.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pliant::serve {
namespace {

using Seconds = std::chrono::duration<double>;

// Bounds of a sample.
constexpr int kEnoughUpdates = 8, kFewUpdates = 3;
constexpr double kLongSample_s = 2;  ///< after which few updates suffice
constexpr int kMixedUpdates = 1;     ///< after a change of the depth

// Bounds of a decision.
constexpr double kMet = 0.9, kNearlyMet = 0.75;  ///< shares of the wanted rate: enough, or once
constexpr double kFree = 0.2;          ///< a line that is blocked less often isn't the limit
constexpr double kSpareBytes = 0.85;   ///< share of the allowed bytes that a higher depth may use
constexpr double kWorth = 0.8;         ///< share of the bytes below which a lower depth is worth it
constexpr double kOtherContact = 1.6;  ///< factor of bytes beyond which all is measured again
constexpr double kReach = 6;           ///< layers by which a tool's own region counts
constexpr int kMaxPause = 256, kFirstHold = 32, kMaxHold = 1024;
constexpr double kFreedLine = 1.3;  ///< factor of the line's rate that ends a pause

}  // namespace

// Measuring.

void Line::sent(std::size_t bytes, bool has_voxels, Clock::time_point now) noexcept {
    m_bytes += bytes;
    if (!has_voxels || m_is_open) return;
    m_is_open = true;
    m_since = now;
}

void Line::ended_update(std::uint32_t step, int depth) noexcept {
    if (m_unseen == kMaxUnseen) forget(1);
    m_sent[m_unseen++] = {step, depth, m_bytes, m_since};
    m_bytes = 0;
    m_is_open = false;
}

void Line::forget(std::size_t oldest) {
    std::copy(m_sent.begin() + std::ptrdiff_t(oldest), m_sent.end(), m_sent.begin());
    m_unseen -= oldest;
}

void Line::seen(std::uint32_t step, Clock::time_point now) {
    std::size_t count = 0, bytes = 0;
    while (count < m_unseen && m_sent[count].step != step) bytes += m_sent[count++].bytes;
    if (count == m_unseen) return;
    const Update last = m_sent[count++];
    bytes += last.bytes;
    forget(count);
    const double busy_s = Seconds(now - std::max(m_seen_at, last.since)).count();
    m_seen_at = now;
    if (last.depth != m_depth) start(last.depth, now);
    if (m_skipped < kMixedUpdates) {
        ++m_skipped;
        return;
    }
    m_updates += int(count);
    m_sum_bytes += double(bytes);
    m_busy_s += busy_s;
}

void Line::due(bool is_free) {
    ++m_due;
    m_blocked += !is_free;
}

void Line::start(int depth, Clock::time_point now) {
    if (depth != m_depth) m_skipped = 0;
    m_depth = depth;
    m_begin = now;
    m_updates = m_due = m_blocked = 0;
    m_sum_bytes = m_busy_s = 0;
}

std::optional<LineSample> Line::take(int depth, Clock::time_point now) {
    if (depth != m_depth) return {};
    const bool is_long = Seconds(now - m_begin).count() > kLongSample_s;
    if (m_updates < (is_long ? kFewUpdates : kEnoughUpdates) || !(m_busy_s > 0)) return {};
    const LineSample sample{.depth = depth,
                            .update_bytes = m_sum_bytes / m_updates,
                            .bytes_per_s = m_sum_bytes / m_busy_s,
                            .blocked = m_due > 0 ? double(m_blocked) / m_due : 0};
    start(depth, now);
    return sample;
}

// Bytes of a depth.

void Traffic::learn(int depth, double bytes) {
    double& known = m_bytes[std::size_t(depth)];
    const double factor = known > 0 ? bytes / known : 1;
    if (factor > kOtherContact || factor < 1 / kOtherContact) m_bytes.fill(0);
    if (known == 0) {
        known = bytes;
        return;
    }
    // The tool has moved on: the shape of the curve stays.
    for (double& other : m_bytes) other *= std::sqrt(factor);
}

double Traffic::bytes_at(int depth) const {
    int below = -1, above = -1;
    for (int d = 0; d <= kNoLimit; ++d) {
        if (m_bytes[std::size_t(d)] == 0) continue;
        if (d <= depth) below = d;
        if (d > depth && above < 0) above = d;
    }
    const auto known = [&](int d) { return m_bytes[std::size_t(d)]; };
    if (below >= 0 && above >= 0)
        return known(below) + (known(above) - known(below)) * (depth - below) / (above - below);
    // A curve that is flat up there may yet be steep further down.
    const int edge = below >= 0 ? below : above;
    return known(edge) * (depth + kReach) / (edge + kReach);
}

int Traffic::deepest_within(double bytes, int most) const {
    for (int depth = most; depth >= kFewestLayers; --depth)
        if (bytes_at(depth) <= bytes) return depth;
    return 0;
}

/// Deepest layers that cost hardly more than any others.
int Traffic::deepest_of_the_smallest(int most) const {
    double least = bytes_at(most);
    for (int depth = kFewestLayers; depth < most; ++depth) least = std::min(least, bytes_at(depth));
    return deepest_within(least / kWorth, most);
}

// Decisions.

void Traffic::take(const LineSample& sample, double wanted_hz) {
    ++m_since_lower;
    m_hold = std::max(0, m_hold - 1);
    learn(sample.depth, sample.update_bytes);
    m_bytes_per_s = sample.bytes_per_s;
    const double allowed = sample.bytes_per_s / wanted_hz;
    const bool is_met = sample.blocked < kFree || kMet * sample.update_bytes <= allowed;
    if (is_met) {
        m_has_failed = false;
        raise(sample, allowed);
    } else if (std::exchange(m_has_failed, true) || kNearlyMet * sample.update_bytes > allowed) {
        m_has_failed = false;
        lower(sample, allowed);
    }
}

void Traffic::lower(const LineSample& sample, double allowed) {
    const auto period = [](const LineSample& s) { return s.update_bytes / s.bytes_per_s; };
    if (m_before && sample.depth < m_before->depth) {
        // Fewer bytes should have made more updates; else the way there and back is the limit.
        const double share = sample.update_bytes / m_before->update_bytes;
        const bool is_useless =
            share < kWorth && period(sample) > 0.5 * (1 + share) * period(*m_before);
        m_useless = is_useless ? m_useless + 1 : 0;
        if (m_useless >= 2) {  // once may be a change of the line
            m_useless = 0;
            m_next_hold = std::clamp(2 * m_next_hold, kFirstHold, kMaxHold);
            m_hold = m_next_hold;
        }
        m_before.reset();
    }
    if (m_hold > 0) {
        m_limit = kNoLimit;
        return;
    }
    const int most = std::max(kMostLayers, sample.depth);
    int depth = deepest_within(allowed, most);
    if (depth == 0) depth = deepest_of_the_smallest(most);
    if (depth >= sample.depth) {  // a lower one would save little
        if (depth > sample.depth) {
            if (m_pause > kFirstPause && m_since_lower < m_pause) return;
            m_has_raised = true;
        }
        m_limit = depth == most ? kNoLimit : depth;
        return;
    }
    // Not far into the unknown.
    if (m_bytes[std::size_t(depth)] == 0) depth = std::max(depth, sample.depth / 2);
    if (std::exchange(m_has_raised, false)) m_pause = std::min(2 * m_pause, kMaxPause);
    m_failed_at = allowed;
    m_since_lower = 0;
    m_before = sample;
    m_limit = depth;
}

void Traffic::raise(const LineSample& sample, double allowed) {
    m_before.reset();
    if (m_limit > sample.depth) return;  // something else limits the depth
    if (allowed > kFreedLine * m_failed_at) m_pause = kFirstPause;
    if (m_since_lower < m_pause && allowed < kFreedLine * m_failed_at) return;
    const int most = std::max(kMostLayers, sample.depth);
    int depth = deepest_within(kSpareBytes * allowed, most);
    if (depth <= sample.depth && sample.blocked < kFree) depth = sample.depth + 1;
    if (depth <= sample.depth) return;
    m_has_raised = true;
    m_limit = depth >= most ? kNoLimit : depth;
}

void Traffic::release() {
    m_limit = kNoLimit;
    m_before.reset();
    m_hold = m_next_hold = 0;
    m_pause = kFirstPause;
    m_has_raised = m_has_failed = false;
    m_failed_at = 0;
}

}  // namespace pliant::serve
