// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings as data. A table has one row for each field of a settings struct: name, unit, range and
// a line of text. The default is the struct's own. Files, messages, range checks, help texts, the
// tables of docs/ and the page's types are generated from the rows.
//
// @code
//   ChainMailSettings settings;
//   Status changed = apply({{"offset", 0.1}, {"limits", "rounded"}}, chainmail_rows(), settings);
// @endcode
//
// A table is an array of rows. setting() takes the member, or the path of members to it:
//
// @code
//   constexpr Setting<MySettings> kFields[] = {
//       setting<&MySettings::stiffness_pa>({.name = "stiffness_pa", .unit = "Pa",
//                                         .range = {1, 1e9}, .text = "Young's modulus"})};
// @endcode

#pragma once

#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

using NumberPair = std::array<double, 2>;

/// Value of a field. monostate is an optional field without a value, or text in a file of no other
/// kind.
using SettingValue =
    std::variant<std::monostate, bool, std::int64_t, double, std::string, std::vector<double>,
                 std::vector<Vec3d>, std::vector<NumberPair>, std::vector<std::string>>;

/// A field's name and value.
struct NamedValue {
    std::string name;
    SettingValue value;

    NamedValue(std::string n, SettingValue v) : name(std::move(n)), value(std::move(v)) {}
    NamedValue(std::string n, const char* text) : name(std::move(n)), value(std::string(text)) {}
    NamedValue(std::string n, int whole) : name(std::move(n)), value(std::int64_t(whole)) {}
    NamedValue(std::string n, double number) : name(std::move(n)), value(number) {}
    NamedValue(std::string n, bool flag) : name(std::move(n)), value(flag) {}
    friend bool operator==(const NamedValue&, const NamedValue&) = default;
};
using Record = std::vector<NamedValue>;

enum class SettingKind {
    Flag,
    Whole,
    Number,
    Text,     ///< free text, or one of the choices
    Choice,   ///< text for an enumerator, numbered from 0
    Numbers,  ///< two or three; one number means three equal ones
    Wholes,   ///< one or more whole numbers
    Points,   ///< any number of points [mm, LPS]
    Pairs,    ///< any number of pairs of numbers
    Texts,    ///< any number of texts, of the choices if there are any
};

struct SettingRange {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
};

/// Row without its struct.
struct SettingInfo {
    std::string_view table{};    ///< table of a settings file; empty: none
    std::string_view key{};      ///< key in that table; empty: the name
    std::string_view name{};     ///< unique in the struct
    std::string_view unit{};     ///< empty: a pure number, a text or a flag
    SettingRange range{};        ///< of each number
    bool above_low = false;      ///< whether low is excluded
    bool below_high = false;     ///< whether high is excluded
    int count = 0;               ///< length of Numbers
    std::string_view choices{};  ///< separated by '|'
    std::string_view text{};     ///< meaning, one line
    SettingKind kind{};          ///< set by setting()
    bool is_optional = false;    ///< set by setting()

    constexpr std::string_view key_in_file() const { return key.empty() ? name : key; }
};

/// Row of the table of T.
template <class T>
struct Setting : SettingInfo {
    SettingValue (*get)(const T&) = nullptr;  ///< choices as numbers
    /// @pre the value was returned by checked_value
    void (*set)(T&, const SettingValue& value) = nullptr;
};
template <class T>
using SettingRows = std::span<const Setting<T>>;

/// Rows of one table of a settings file.
template <class T, std::size_t kCount>
constexpr std::array<Setting<T>, kCount> in_table(std::string_view table,
                                                  const Setting<T> (&rows)[kCount]) {
    std::array<Setting<T>, kCount> named{};
    for (std::size_t n = 0; n < kCount; ++n) {
        named[n] = rows[n];
        named[n].table = table;
    }
    return named;
}
/// Rows of several tables, in this order.
template <class T, std::size_t... kCounts>
constexpr auto joined(const std::array<Setting<T>, kCounts>&... tables) {
    std::array<Setting<T>, (kCounts + ...)> all{};
    auto* end = all.data();
    ((end = std::copy(tables.begin(), tables.end(), end)), ...);
    return all;
}

/// Name in messages: "[material] offset", or the name alone without a table.
std::string title_of(const SettingInfo& field);
/// Range or choices: "0 to 500 mm", "\"box\" or \"rounded\"".
std::string expected_of(const SettingInfo& field);
/// A value in TOML syntax, with the shortest digits that round-trip.
std::string toml_text(const SettingValue& value);

/// Converts a value to the kind of a field: whole numbers to numbers, one number to a list, the
/// text of a choice to its number.
/// @returns InvalidArgument for an inconvertible kind
Result<SettingValue> value_of_kind(const SettingInfo& field, SettingValue value);
/// @param value  result of value_of_kind
/// @returns InvalidArgument if it is out of range
Status check_range(const SettingInfo& field, const SettingValue& value);
/// Both: value_of_kind, then check_range.
Result<SettingValue> checked_value(const SettingInfo& field, SettingValue value);
/// Converts a stored choice to its text; other values are unchanged.
SettingValue shown_value(const SettingInfo& field, SettingValue stored);

/// Error about an unknown name. @param names  of all rows
Error unknown_setting(std::string_view name, const std::string& names);

template <class T>
const Setting<T>* find_setting(std::string_view name, SettingRows<T> rows) {
    for (const Setting<T>& field : rows)
        if (field.name == name) return &field;
    return nullptr;
}

/// Value of a field, choices as text.
template <class T>
SettingValue value_of(const T& object, const Setting<T>& field) {
    return shown_value(field, field.get(object));
}

/// Sets a field. @returns InvalidArgument, and the object is unchanged
template <class T>
Status assign(T& object, const Setting<T>& field, SettingValue value) {
    Result<SettingValue> checked = checked_value(field, std::move(value));
    if (!checked) return checked.error();
    field.set(object, *checked);
    return Ok{};
}

/// Checks all settings against their ranges.
template <class T>
Status check(const T& object, SettingRows<T> rows) {
    for (const Setting<T>& field : rows)
        if (Status s = check_range(field, field.get(object)); !s) return s;
    return Ok{};
}

/// All settings by name, without optional ones that aren't set.
template <class T>
Record record_of(const T& object, SettingRows<T> rows) {
    Record record;
    for (const Setting<T>& field : rows)
        if (SettingValue value = value_of(object, field);
            !std::holds_alternative<std::monostate>(value))
            record.emplace_back(std::string(field.name), std::move(value));
    return record;
}

/// Sets the named settings of an object, all or none.
/// @returns InvalidArgument that names the field, for unknown names too
template <class T>
Status apply(const Record& record, std::type_identity_t<SettingRows<T>> rows, T& object) {
    T changed = object;
    for (const NamedValue& named : record) {
        const Setting<T>* field = find_setting<T>(named.name, rows);
        if (!field) {
            std::string names;
            for (const Setting<T>& known : rows)
                names.append(names.empty() ? "" : ", ").append(known.name);
            return unknown_setting(named.name, names);
        }
        if (Status s = assign(changed, *field, named.value); !s) return s;
    }
    object = std::move(changed);
    return Ok{};
}

/// Access of rows to the members of a struct.
namespace record {

template <class Value>
struct Unwrapped {
    using type = Value;
    static constexpr bool is_optional = false;
};
template <class Value>
struct Unwrapped<std::optional<Value>> {
    using type = Value;
    static constexpr bool is_optional = true;
};

template <class Value>
constexpr SettingKind kind_of(bool has_choices) {
    using std::same_as;
    if constexpr (same_as<Value, bool>)
        return has_choices ? SettingKind::Choice : SettingKind::Flag;
    else if constexpr (std::is_enum_v<Value>)
        return SettingKind::Choice;
    else if constexpr (std::integral<Value>)
        return SettingKind::Whole;
    else if constexpr (same_as<Value, double>)
        return SettingKind::Number;
    else if constexpr (same_as<Value, std::string>)
        return SettingKind::Text;
    else if constexpr (same_as<Value, Vec3d>)
        return SettingKind::Numbers;
    else if constexpr (same_as<Value, std::vector<int>>)
        return SettingKind::Wholes;
    else if constexpr (same_as<Value, std::vector<Vec3d>>)
        return SettingKind::Points;
    else if constexpr (same_as<Value, std::vector<NumberPair>>)
        return SettingKind::Pairs;
    else if constexpr (same_as<Value, std::vector<std::string>>)
        return SettingKind::Texts;
}

template <class Value>
SettingValue pack(const Value& value) {
    if constexpr (Unwrapped<Value>::is_optional)
        return value ? pack(*value) : SettingValue{};
    else if constexpr (std::is_enum_v<Value> ||
                       (std::integral<Value> && !std::same_as<Value, bool>))
        return std::int64_t(value);
    else if constexpr (std::same_as<Value, Vec3d>)
        return std::vector<double>{value.x, value.y, value.z};
    else if constexpr (std::same_as<Value, std::vector<int>>)
        return std::vector<double>(value.begin(), value.end());
    else
        return value;
}

template <class Value>
void unpack(const SettingValue& from, Value& to) {
    const auto numbers = [&] { return std::get_if<std::vector<double>>(&from); };
    if constexpr (Unwrapped<Value>::is_optional) {
        unpack(from, to.emplace());
    } else if constexpr (std::same_as<Value, bool>) {
        const bool* flag = std::get_if<bool>(&from);
        to = flag ? *flag : *std::get_if<std::int64_t>(&from) != 0;
    } else if constexpr (std::is_enum_v<Value> || std::integral<Value>) {
        to = Value(*std::get_if<std::int64_t>(&from));
    } else if constexpr (std::same_as<Value, Vec3d>) {
        to = {numbers()->at(0), numbers()->at(1), numbers()->at(2)};
    } else if constexpr (std::same_as<Value, std::vector<int>>) {
        to.clear();
        for (const double number : *numbers()) to.push_back(int(number));
    } else {
        to = *std::get_if<Value>(&from);
    }
}

template <class T, class V>
T owner(V T::*);

template <auto First, auto... Rest, class T>
auto& member(T& object) {
    if constexpr (sizeof...(Rest) == 0)
        return object.*First;
    else
        return member<Rest...>(object.*First);
}

}  // namespace record

/// Makes a row for the member at the path First, Rest.
template <auto First, auto... Rest>
constexpr auto setting(SettingInfo info) {
    using T = decltype(record::owner(First));
    using Member =
        std::remove_reference_t<decltype(record::member<First, Rest...>(std::declval<T&>()))>;
    using Value = record::Unwrapped<Member>;
    info.kind = record::kind_of<typename Value::type>(!info.choices.empty());
    info.is_optional = Value::is_optional;
    if (std::same_as<typename Value::type, Vec3d>) info.count = 3;
    return Setting<T>{
        {info},
        [](const T& object) { return record::pack(record::member<First, Rest...>(object)); },
        [](T& object, const SettingValue& value) {
            record::unpack(value, record::member<First, Rest...>(object));
        }};
}

}  // namespace pliant
#pragma GCC visibility pop
