// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "haptic_run.h"

#include <cmath>
#include <deque>

namespace pliant {

HapticState run_haptics(VirtualDevice& device, const HapticRun& run, std::int64_t periods,
                        const HapticTissue& tissue, const HapticWatch& watch) {
    struct Due {
        std::int64_t period;
        HapticModel model;
    };
    std::deque<Due> coming;
    HapticState state;
    std::int64_t number = 0;
    const HapticWorkspace& w = run.settings.workspace;
    for (std::int64_t k = 0; k < periods; ++k) {
        const HapticReading reading{std::llround(1e9 * double(k) / run.rate_hz),
                                    device.seen_position_mm(), false};
        if (k % run.update_periods == 0) {
            HapticModel model = tissue(w.origin_mm + w.scale * (w.rotation * reading.position_mm));
            model.number = ++number;
            coming.push_back({k + run.delay_periods, model});
        }
        const bool is_due = !coming.empty() && coming.front().period <= k;
        const HapticModel* fresh = is_due ? &coming.front().model : nullptr;
        const HapticForce force = servo_step(run.settings, fresh, reading, state);
        const bool goes_on = !watch || watch(reading, fresh, state, force);
        if (is_due) coming.pop_front();
        device.advance(force.force_n, 1 / run.rate_hz);
        if (!goes_on) break;
    }
    return state;
}

}  // namespace pliant
