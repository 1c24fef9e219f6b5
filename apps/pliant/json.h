// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// JSON of reports: its keys stay in the order in which they are written.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/vec.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <variant>
#include <vector>

namespace pliant::app {

using Json = nlohmann::ordered_json;

/// Lists of whole numbers, such as counts along three axes, are written as such.
inline Json value_json(const SettingValue& value) {
    const auto write = [](const auto& v) -> Json {
        using Value = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<Value, std::monostate>)
            return nullptr;
        else if constexpr (std::is_same_v<Value, std::vector<Vec3d>>) {
            Json list = Json::array();
            for (const Vec3d& one : v) list.push_back({one.x, one.y, one.z});
            return list;
        } else if constexpr (std::is_same_v<Value, std::vector<double>>) {
            const bool are_whole = std::all_of(
                v.begin(), v.end(), [](double number) { return number == std::floor(number); });
            return are_whole ? Json(std::vector<std::int64_t>(v.begin(), v.end())) : Json(v);
        } else
            return v;
    };
    return std::visit(write, value);
}

}  // namespace pliant::app
