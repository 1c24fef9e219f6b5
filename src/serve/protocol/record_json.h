// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings in JSON: one key per row, named like the row.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/vec.h>

#include <nlohmann/json.hpp>
#include <string>

#include "protocol/tissue_choice.h"

namespace pliant {

template <class T>
nlohmann::json json_of(const Vec3<T>& v) {
    return {v.x, v.y, v.z};
}

}  // namespace pliant

namespace pliant::serve {

using Json = nlohmann::json;

/// Field that a session writes beside the settings of springs: those that follow the scan are
/// absent. Without it (older sessions) they are those that equal their defaults.
inline constexpr const char* kExplicit = "explicit";

/// Converts the value of a setting; monostate for other JSON types, such as objects.
SettingValue value_of_json(const Json& json);
Json json_of_value(const SettingValue& value);

/// Writes the values of a record by name.
void put(Json& object, const Record& record);

/// Writes all settings that have a value.
template <class T>
void put(Json& object, const T& settings, SettingRows<T> rows) {
    for (const Setting<T>& row : rows)
        if (const SettingValue value = value_of(settings, row);
            !std::holds_alternative<std::monostate>(value))
            object[std::string(row.name)] = json_of_value(value);
}

/// Reads the fields whose keys an object has. Ignores other keys.
/// @returns InvalidArgument that names the field
template <class T>
Status read(const Json& object, std::type_identity_t<SettingRows<T>> rows, T& settings) {
    for (const Setting<T>& row : rows) {
        const auto found = object.find(std::string(row.name));
        if (found == object.end()) continue;
        if (const Status s = assign(settings, row, value_of_json(*found)); !s) return s;
    }
    return Ok{};
}

/// Writes the settings of springs for a session, without those that follow the scan.
void put_springs(Json& object, const TissueChoice& choice);
/// Names the settings that an object has and that would otherwise follow the scan.
void set_given(const Json& object, TissueChoice& choice);
/// The same for the object of a session, which may lack kExplicit.
void set_given_of_session(const Json& object, TissueChoice& choice);

}  // namespace pliant::serve
