// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/settings.h"

#include <charconv>
#include <cmath>

#include "chainmail/fixed_point.h"

namespace pliant {
namespace {

std::string text_of(double number) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, number).ptr;
    return std::string(buffer, end);
}

Error out_of_range(const std::string& key, double found, const std::string& expected) {
    return {ErrorCode::InvalidArgument,
            key + ": expected " + expected + ", found " + text_of(found)};
}

}  // namespace

Status check_settings(const ChainMailSettings& s) {
    if (s.law != "draeger")
        return Error{ErrorCode::InvalidArgument,
                     "[material] law: expected \"draeger\", found \"" + s.law + "\""};
    if (!(s.offset > 0 && s.offset < 1))
        return out_of_range("[material] offset", s.offset, "a fraction between 0 and 1, exclusive");
    if (!std::isfinite(s.bone_threshold_hu))
        return out_of_range("[material] bone_threshold_hu", s.bone_threshold_hu, "a number");
    if (!(s.max_movement_mm >= 0 && s.max_movement_mm <= kMaxMovementMm))
        return out_of_range("[material] max_movement_mm", s.max_movement_mm, "0 to 500 mm");
    if (!(s.yield >= 0 && s.yield <= 1))
        return out_of_range("[material] yield", s.yield, "0 to 1");
    if (!(s.scale > 0 && s.scale <= 1000))
        return out_of_range("[push] scale", s.scale, "a factor above 0, up to 1000");
    if (s.brick_size < 2 || s.brick_size > 32)
        return out_of_range("[lattice] brick_size", s.brick_size, "2 to 32");
    if (s.max_elements < 1)
        return out_of_range("[lattice] max_elements", double(s.max_elements), "1 or more");
    if (s.air_enabled)
        return Error{ErrorCode::InvalidArgument,
                     "[air] enabled: expected false, air as a material of its own is not there "
                     "in this version"};
    if (!std::isfinite(s.air_threshold_hu))
        return out_of_range("[air] threshold_hu", s.air_threshold_hu, "a number");
    return Ok{};
}

}  // namespace pliant
