// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Servo, device and tissue in simulated time.

#pragma once

#include <pliant/view/haptics.h>

#include <cstdint>
#include <functional>

namespace pliant {

/// Force between two solutions.
enum class HapticScheme {
    LinearLaw,    ///< the local model
    Hold,         ///< the last force
    Extrapolate,  ///< linear extrapolation of the last two forces [Choi2004, 3.3.1]
};

struct HapticRun {
    HapticSettings settings{};  ///< blend_s and bounded_energy are those of LinearLaw alone
    HapticScheme scheme = HapticScheme::LinearLaw;
    /// Limit of Extrapolate, in update periods. The paper has no limit.
    double extrapolated_updates = 1;
    double rate_hz = 1000;
    int update_periods = 33;  ///< periods between two solutions of the tissue
    int delay_periods = 0;    ///< latency of a solution
};

/// Returns the tissue's model for a tool position in the scene [mm]; the caller fills in the
/// number.
using HapticTissue = std::function<HapticModel(Vec3d tool_mm)>;
/// Called after each period; false ends the run.
using HapticWatch = std::function<bool(const HapticReading& reading, const HapticModel* fresh,
                                       const HapticState& state, const HapticForce& force)>;

/// Runs servo, device and tissue in simulated time, period by period, on this thread.
/// @returns the last state of the servo
HapticState run_haptics(VirtualDevice& device, const HapticRun& run, std::int64_t periods,
                        const HapticTissue& tissue, const HapticWatch& watch = {});

}  // namespace pliant
