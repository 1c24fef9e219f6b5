// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "protocol/record_json.h"

#include <vector>

namespace pliant::serve {
namespace {

bool is_pair(const Json& json) {
    return json.is_array() && json.size() == 2 && json[0].is_number() && json[1].is_number();
}

}  // namespace

SettingValue value_of_json(const Json& json) {
    if (json.is_boolean()) return json.get<bool>();
    if (json.is_number_unsigned() && json.get<std::uint64_t>() > std::uint64_t(INT64_MAX))
        return json.get<double>();
    if (json.is_number_integer()) return json.get<std::int64_t>();
    if (json.is_number()) return json.get<double>();
    if (json.is_string()) return json.get<std::string>();
    if (!json.is_array()) return {};
    std::vector<double> numbers;
    std::vector<NumberPair> pairs;
    std::vector<std::string> texts;
    for (const Json& element : json) {
        if (element.is_number())
            numbers.push_back(element.get<double>());
        else if (element.is_string())
            texts.push_back(element.get<std::string>());
        else if (is_pair(element))
            pairs.push_back({element[0].get<double>(), element[1].get<double>()});
    }
    if (numbers.size() == json.size()) return numbers;
    if (pairs.size() == json.size()) return pairs;
    if (texts.size() == json.size()) return texts;
    return {};
}

Json json_of_value(const SettingValue& value) {
    struct {
        Json operator()(std::monostate) const { return nullptr; }
        Json operator()(bool flag) const { return flag; }
        Json operator()(std::int64_t number) const { return number; }
        Json operator()(double number) const { return number; }
        Json operator()(const std::string& text) const { return text; }
        Json operator()(const std::vector<double>& numbers) const { return numbers; }
        Json operator()(const std::vector<Vec3d>& points) const {
            Json list = Json::array();
            for (const Vec3d p : points) list.push_back({p.x, p.y, p.z});
            return list;
        }
        Json operator()(const std::vector<NumberPair>& pairs) const { return pairs; }
        Json operator()(const std::vector<std::string>& texts) const { return texts; }
    } const json;
    return std::visit(json, value);
}

void put(Json& object, const Record& record) {
    for (const NamedValue& named : record) object[named.name] = json_of_value(named.value);
}

void put_springs(Json& object, const TissueChoice& choice) {
    for (const Setting<SpringDeformationSettings>& row : spring_rows())
        if (!follows_scan(choice, row.name))
            object[std::string(row.name)] = json_of_value(value_of(choice.springs, row));
    object[kExplicit] = true;
}

void set_given(const Json& object, TissueChoice& choice) {
    choice.given.clear();
    for (const std::string_view name : kFollowing)
        if (object.contains(std::string(name))) choice.given.emplace_back(name);
}

void set_given_of_session(const Json& object, TissueChoice& choice) {
    set_given(object, choice);
    if (object.contains(kExplicit)) return;
    const SpringDeformationSettings usual;
    for (const Setting<SpringDeformationSettings>& row : spring_rows())
        if (value_of(choice.springs, row) == value_of(usual, row))
            std::erase(choice.given, row.name);
}

}  // namespace pliant::serve
