// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Force feedback as clients ask for it and are told of it (docs/protocol.md, "Force feedback").

#pragma once

#include <pliant/vec.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pliant::serve {

enum class HapticWish { Start, Stop, Go, End };

/// What a client asks for. All but the first is of Start.
struct HapticsMessage {
    HapticWish wish = HapticWish::End;
    std::string device{};  ///< a name of the server's list
    /// Where the middle of the device's workspace is, and what its −z axis and y axis are there.
    Vec3d position_mm{0, 0, 0}, look{0, 1, 0}, up{0, 0, 1};
    double scale = 1;
    double radius_mm = 1.5;  ///< of the tool
};

/// Where a device is whose place the client says [mm, in the device's frame].
struct HapticPoseMessage {
    Vec3d position_mm{0, 0, 0};
    double roll_deg = 0;  ///< about its z axis, as often round as it was turned
};

/// Of the servo, over the last seconds.
struct HapticStatistics {
    double rate_hz = 0;
    double period_p99_us = 0, period_max_us = 0;
    double misses_per_million = 0;  ///< periods above 1.5 ms
    double compute_p99_us = 0;
    double age_ms = 0;  ///< of the model, at most

    friend bool operator==(const HapticStatistics&, const HapticStatistics&) = default;
};

struct HapticState {
    bool on = false;
    std::string why{};         ///< where it isn't any more
    std::uint32_t client = 0;  ///< who began it
    std::uint32_t tool = 0;    ///< the number of its tool, as in frames of tools
    std::string device{};
    double scale = 1;
    bool stopped = false;
    bool contact = false;
    bool lost = false;        ///< the device can't be read
    Vec3d place_mm{0, 0, 0};  ///< of the tool
    Vec3d proxy_mm{0, 0, 0};  ///< on the free side of the wall
    Vec3d force_n{0, 0, 0};   ///< on the tool
    double largest_n = 0;     ///< since the last state
    double depth_mm = 0;      ///< beyond the wall; with a catheter, ahead of its base
    bool holds_catheter = false;
    double largest_force_n = 0;  ///< that the device can show
    HapticStatistics servo{};
    std::string note{};  ///< what would make it better

    friend bool operator==(const HapticState&, const HapticState&) = default;
};

std::string haptics_text(const HapticState& state);

}  // namespace pliant::serve
