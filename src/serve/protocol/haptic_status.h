// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Requests and states of force feedback (docs/developers/protocol.md, "Force feedback").

#pragma once

#include <pliant/core/vec.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pliant::serve {

enum class HapticWish { Start, Stop, Go, End };

/// A client's request. All fields but the first belong to Start.
struct HapticsMessage {
    HapticWish wish = HapticWish::End;
    std::string device{};  ///< a name of the server's list
    /// Centre of the device's workspace, and directions of its −z and y axes, in the scene.
    Vec3d position_mm{0, 0, 0}, look{0, 1, 0}, up{0, 0, 1};
    double scale = 1;
    double radius_mm = 1.5;  ///< radius of the tool
};

/// Pose of a device that the client positions [mm, in the device's frame].
struct HapticPoseMessage {
    Vec3d position_mm{0, 0, 0};
    double roll_deg = 0;  ///< about its z axis, accumulated over full turns
};

/// Timing of the servo over the last seconds.
struct HapticStatistics {
    double rate_hz = 0;
    double period_p99_us = 0, period_max_us = 0;
    double misses_per_million = 0;  ///< periods above 1.5 ms
    double compute_p99_us = 0;
    double age_ms = 0;  ///< largest age of the model

    friend bool operator==(const HapticStatistics&, const HapticStatistics&) = default;
};

struct HapticStatus {
    bool on = false;
    std::string why{};         ///< reason why it ended
    std::uint32_t client = 0;  ///< owner of the session
    std::uint32_t tool = 0;    ///< number of the tool in tool frames
    std::string device{};
    double scale = 1;
    bool stopped = false;
    bool contact = false;
    bool lost = false;           ///< the device can't be read
    Vec3d position_mm{0, 0, 0};  ///< of the tool
    Vec3d proxy_mm{0, 0, 0};     ///< on the free side of the wall
    Vec3d force_n{0, 0, 0};      ///< on the tool
    double largest_n = 0;        ///< largest force since the last state
    double depth_mm = 0;         ///< depth beyond the wall; catheter: distance ahead of its base
    bool holds_catheter = false;
    double largest_force_n = 0;  ///< limit of the device
    HapticStatistics servo{};
    std::string note{};  ///< hint for the user

    friend bool operator==(const HapticStatus&, const HapticStatus&) = default;
};

std::string haptics_text(const HapticStatus& state);

}  // namespace pliant::serve
