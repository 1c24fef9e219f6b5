// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "haptic_run.h"

#include <algorithm>
#include <cmath>
#include <deque>

namespace pliant {
namespace {

/// The forces of the last two solutions, as models with a force that is the same everywhere.
class LastForces {
  public:
    void add(Vec3d force_n, std::int64_t time_ns) {
        m_update_ns = m_time_ns < 0 ? 0 : time_ns - m_time_ns;
        m_time_ns = time_ns;
        m_earlier_n = m_force_n;
        m_force_n = force_n;
    }
    bool empty() const { return m_time_ns < 0; }
    HapticModel model_at(const HapticRun& run, std::int64_t time_ns) {
        HapticModel model;
        model.number = ++m_number;
        model.force_n = m_force_n;
        if (run.scheme == HapticScheme::Extrapolate && m_update_ns > 0) {
            const double updates = std::min(double(time_ns - m_time_ns) / double(m_update_ns),
                                            run.extrapolated_updates);
            model.force_n = m_force_n + updates * (m_force_n - m_earlier_n);
        }
        model.held = model.force_n != Vec3d{0, 0, 0};
        return model;
    }

  private:
    Vec3d m_force_n{0, 0, 0}, m_earlier_n{0, 0, 0};
    std::int64_t m_time_ns = -1, m_update_ns = 0, m_number = 0;
};

}  // namespace

HapticState run_haptics(VirtualDevice& device, const HapticRun& run, std::int64_t periods,
                        const HapticTissue& tissue, const HapticWatch& watch) {
    struct Due {
        std::int64_t period;
        HapticModel model;
    };
    std::deque<Due> coming;
    LastForces forces;
    HapticSettings settings = run.settings;
    const bool has_law = run.scheme == HapticScheme::LinearLaw;
    if (!has_law) {
        settings.blend_s = 0;
        settings.bounded_energy = false;
    }
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
        HapticModel made;
        if (fresh) forces.add(fresh->force_n, reading.time_ns);
        if (!has_law) made = forces.model_at(run, reading.time_ns);
        const HapticModel* given = has_law ? fresh : forces.empty() ? nullptr : &made;
        const HapticForce force = servo_step(settings, given, reading, state);
        const bool goes_on = !watch || watch(reading, fresh, state, force);
        if (is_due) coming.pop_front();
        device.advance(force.force_n, 1 / run.rate_hz);
        if (!goes_on) break;
    }
    return state;
}

}  // namespace pliant
