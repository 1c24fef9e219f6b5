// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "keywords.h"

#include <algorithm>
#include <cmath>

namespace pliant::python {
namespace {

/// "a|b" as typing.Literal["a", "b"].
std::string literal_of(std::string_view choices) {
    std::string list;
    while (!choices.empty()) {
        const std::string_view choice = choices.substr(0, choices.find('|'));
        list.append(list.empty() ? "" : ", ").append("\"").append(choice).append("\"");
        choices.remove_prefix(std::min(choices.size(), choice.size() + 1));
    }
    return "typing.Literal[" + list + "]";
}

std::string type_of(const SettingInfo& row) {
    const std::string numbers =
        "collections.abc.Sequence[float] | numpy.typing.NDArray[typing.Any]";
    if (row.kind == SettingKind::Texts)
        return "collections.abc.Sequence[" +
               (row.choices.empty() ? "str" : literal_of(row.choices)) + "]";
    if (!row.choices.empty()) return literal_of(row.choices);
    switch (row.kind) {
        case SettingKind::Flag:
            return "bool";
        case SettingKind::Whole:
            return "int";
        case SettingKind::Number:
            return "float";
        case SettingKind::Text:
        case SettingKind::Choice:
            return "str";
        case SettingKind::Numbers:
            return row.count == 2 ? numbers : "float | " + numbers;
        case SettingKind::Wholes:
            return "int | collections.abc.Sequence[int] | numpy.typing.NDArray[typing.Any]";
        case SettingKind::Texts:
            break;
        case SettingKind::Points:
        case SettingKind::Pairs:
            return "collections.abc.Sequence[" + numbers + "] | numpy.typing.NDArray[typing.Any]";
    }
    return "typing.Any";
}

/// A default as an expression; infinite numbers have none.
std::string expression_of(const SettingValue& value) {
    if (const double* number = std::get_if<double>(&value); number && !std::isfinite(*number))
        return "...";
    return nb::cast<std::string>(nb::repr(object_of(value)));
}

bool is_word_of_python(const std::string& name) {
    return nb::cast<bool>(nb::module_::import_("keyword").attr("iskeyword")(name));
}

bool is_among(std::string_view name, std::initializer_list<std::string_view> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

std::string replaced(std::string_view text, std::string_view mark, const std::string& by) {
    const std::size_t at = text.find(mark);
    std::string made(text.substr(0, at));
    return made.append(by).append(text.substr(at + mark.size()));
}

}  // namespace

Keyword keyword_of(const SettingInfo& row, const SettingValue& value) {
    std::string range(row.unit);
    if (row.choices.empty() && (std::isfinite(row.range.low) || std::isfinite(row.range.high)))
        range = expected_of(row);
    std::string text(row.text);
    if (!range.empty()) text += " [" + range + "]";
    std::string name(row.name);
    if (is_word_of_python(name)) name += '_';
    return {std::move(name), type_of(row) + (row.is_optional ? " | None" : ""),
            expression_of(value), std::move(text)};
}

std::string name_of_keyword(std::string keyword) {
    if (keyword.ends_with('_') && is_word_of_python(keyword.substr(0, keyword.size() - 1)))
        keyword.pop_back();
    return keyword;
}

Keywords together(std::initializer_list<Keywords> tables) {
    Keywords all;
    for (const Keywords& table : tables)
        for (const Keyword& one : table) {
            const auto known = std::find_if(all.begin(), all.end(),
                                            [&](const Keyword& k) { return k.name == one.name; });
            if (known == all.end()) {
                all.push_back(one);
                continue;
            }
            if (known->type != one.type) known->type += " | " + one.type;
            if (known->value != one.value) known->value = "...";
        }
    return all;
}

Keywords without(Keywords keywords, std::initializer_list<std::string_view> names) {
    std::erase_if(keywords, [&](const Keyword& one) { return is_among(one.name, names); });
    return keywords;
}

Keywords unset(Keywords keywords, std::initializer_list<std::string_view> names) {
    for (Keyword& one : keywords)
        if (names.size() == 0 || is_among(one.name, names)) one.value = "...";
    return keywords;
}

Signature typed(std::string_view signature, const Keywords& keywords) {
    std::string list;
    for (const Keyword& one : keywords) {
        const std::string argument = one.name + ": ";
        if (signature.find(" " + argument) != std::string_view::npos ||
            signature.find("(" + argument) != std::string_view::npos)
            continue;
        list.append(list.empty() ? "" : ", ").append(one.name).append(": ");
        list.append(one.type).append(" = ").append(one.value);
    }
    return {replaced(signature, "**settings", list)};
}

Docstring described(std::string_view text, const Keywords& keywords) {
    std::string lines;
    for (const Keyword& one : keywords) {
        lines.append(lines.empty() ? "" : "\n").append("    ");
        lines.append(one.name).append(": ").append(one.text);
    }
    return {replaced(text, "    **settings", lines)};
}

}  // namespace pliant::python
