// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// State of a force-feedback device as JSON.

#include <cmath>
#include <nlohmann/json.hpp>

#include "protocol/haptic_status.h"

namespace pliant::serve {
namespace {

double in_steps(double value, double per_unit) {
    return std::round(value * per_unit) / per_unit;
}

/// Rounds to micrometres or micronewtons: few digits.
nlohmann::json short_vector(Vec3d v, double per_unit) {
    return {in_steps(v.x, per_unit), in_steps(v.y, per_unit), in_steps(v.z, per_unit)};
}

}  // namespace

std::string haptics_text(const HapticStatus& s) {
    nlohmann::json json = {{"t", "haptics"}, {"on", s.on}};
    if (!s.why.empty()) json["why"] = s.why;
    if (s.on && s.holds_catheter) json["holds"] = "catheter";
    if (s.on)
        json.update({{"client", s.client},
                     {"tool", s.tool},
                     {"device", s.device},
                     {"scale", s.scale},
                     {"stopped", s.stopped},
                     {"contact", s.contact},
                     {"lost", s.lost},
                     {"place_mm", short_vector(s.position_mm, 1e3)},
                     {"proxy_mm", short_vector(s.proxy_mm, 1e3)},
                     {"force_n", short_vector(s.force_n, 1e6)},
                     {"largest_n", in_steps(s.largest_n, 1e6)},
                     {"depth_mm", in_steps(s.depth_mm, 1e3)},
                     {"largest_force_n", s.largest_force_n},
                     {"servo",
                      {{"rate_hz", s.servo.rate_hz},
                       {"period_p99_us", s.servo.period_p99_us},
                       {"period_max_us", s.servo.period_max_us},
                       {"misses_per_million", s.servo.misses_per_million},
                       {"compute_p99_us", s.servo.compute_p99_us},
                       {"age_ms", s.servo.age_ms}}},
                     {"note", s.note}});
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace pliant::serve
