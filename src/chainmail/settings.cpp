// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "chainmail/settings.h"

#include <charconv>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "chainmail/fixed_point.h"
#include "volume/text.h"

namespace pliant {
namespace {

Error out_of_range(const std::string& key, double found, const std::string& expected) {
    return {ErrorCode::InvalidArgument,
            key + ": expected " + expected + ", found " + text_of(found)};
}

Status check_air(const ChainMailSettings& s) {
    if (!std::isfinite(s.air_threshold_hu))
        return out_of_range("[air] threshold_hu", s.air_threshold_hu, "a number");
    if (!(s.air_compress >= 0 && s.air_compress <= 1))
        return out_of_range("[air] compress", s.air_compress, "a fraction 0 to 1");
    if (!(s.air_stretch >= 0 && s.air_stretch <= 500))
        return out_of_range("[air] stretch", s.air_stretch, "a fraction 0 to 500");
    if (!(s.air_shear >= 0 && s.air_shear <= 500))
        return out_of_range("[air] shear", s.air_shear, "a fraction 0 to 500");
    // The lattice goes on beyond the scan as air. Where that gives way by almost nothing, any push
    // reaches as far as there is memory.
    constexpr double kLeast = 0.01;
    if (s.air_enabled && !s.bounded)
        for (const auto& [key, found] : {std::pair("[air] compress", s.air_compress),
                                         {"[air] stretch", s.air_stretch},
                                         {"[air] shear", s.air_shear}})
            if (found < kLeast)
                return out_of_range(key, found, "0.01 or more, or [lattice] bounded = true");
    return Ok{};
}

Status check_vector(const std::string& key, Vec3d found, int max) {
    for (int b = 0; b < 3; ++b)
        if (!(found[b] >= 0 && found[b] <= max))
            return out_of_range(key, found[b], "numbers 0 to " + std::to_string(max));
    return Ok{};
}

Status check_label_material(const LabelMaterial& m, const std::string& table) {
    if (m.values.empty())
        return Error{ErrorCode::InvalidArgument,
                     table + " values: expected one label or more, found none"};
    for (const int value : m.values)
        if (value < -32768 || value > 65535)
            return out_of_range(table + " values", value, "labels -32768 to 65535");
    if (m.offset && !(*m.offset >= 0 && *m.offset <= 1))
        return out_of_range(table + " offset", *m.offset, "a fraction 0 to 1");
    if (m.bone_threshold_hu && !std::isfinite(*m.bone_threshold_hu))
        return out_of_range(table + " bone_threshold_hu", *m.bone_threshold_hu, "a number");
    if (m.max_movement_mm && !(*m.max_movement_mm >= 0 && *m.max_movement_mm <= kMaxMovementMm))
        return out_of_range(table + " max_movement_mm", *m.max_movement_mm, "0 to 500 mm");
    if (m.yield && !(*m.yield >= 0 && *m.yield <= 1))
        return out_of_range(table + " yield", *m.yield, "0 to 1");
    for (const auto& [key, numbers, max] : {std::tuple{"factor", m.factor, 100},
                                            {"compress", m.compress, 1},
                                            {"stretch", m.stretch, 100},
                                            {"shear", m.shear, 100}})
        if (const Status s = check_vector(table + " " + key, numbers, max); !s.ok()) return s;
    return Ok{};
}

Status check_label_materials(const ChainMailSettings& s) {
    std::set<int> taken;
    for (std::size_t n = 0; n < s.label_materials.size(); ++n) {
        const std::string table = "[[label]] " + std::to_string(n + 1);
        const LabelMaterial& material = s.label_materials[n];
        if (const Status status = check_label_material(material, table); !status.ok())
            return status;
        for (const int value : material.values)
            if (!taken.insert(value).second)
                return out_of_range(table + " values", value, "each label once");
    }
    return Ok{};
}

}  // namespace

Status check_settings(const ChainMailSettings& s) {
    if (s.law != "draeger")
        return Error{ErrorCode::InvalidArgument,
                     "[material] law: expected \"draeger\", found \"" + shown(s.law) + "\""};
    if (!(s.offset >= 0 && s.offset <= 1))
        return out_of_range("[material] offset", s.offset, "a fraction 0 to 1");
    if (!std::isfinite(s.bone_threshold_hu))
        return out_of_range("[material] bone_threshold_hu", s.bone_threshold_hu, "a number");
    if (!(s.max_movement_mm >= 0 && s.max_movement_mm <= kMaxMovementMm))
        return out_of_range("[material] max_movement_mm", s.max_movement_mm, "0 to 500 mm");
    if (!(s.yield >= 0 && s.yield <= 1)) return out_of_range("[material] yield", s.yield, "0 to 1");
    if (!(s.scale > 0 && s.scale <= 1000))
        return out_of_range("[push] scale", s.scale, "a factor above 0, up to 1000");
    if (s.brick_size < 2 || s.brick_size > 32)
        return out_of_range("[lattice] brick_size", s.brick_size, "2 to 32");
    if (s.max_elements < 1)
        return out_of_range("[lattice] max_elements", double(s.max_elements), "1 or more");
    if (s.history_max_steps < 0 || s.history_max_steps > 100'000)
        return out_of_range("[history] max_steps", s.history_max_steps, "0 to 100000");
    if (s.history_max_mb < 0 || s.history_max_mb > 1'000'000)
        return out_of_range("[history] max_mb", s.history_max_mb, "0 to 1000000");
    if (const Status air = check_air(s); !air.ok()) return air;
    return check_label_materials(s);
}

}  // namespace pliant
