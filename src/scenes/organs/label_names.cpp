// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "organs/label_names.h"

#include <pliant/core/files.h>

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "base/errors.h"
#include "base/input_file.h"
#include "base/text.h"
#include "formats/image_header.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::size_t kMaxNameBytes = 80, kMaxTableBytes = std::size_t(1) << 20;
constexpr std::size_t kColours = 3;  ///< numbers after a name, at least, that are no part of it

std::optional<int> label_from(std::string_view text) {
    const auto number = whole_number_from(trimmed(text));
    if (!number || *number < std::numeric_limits<int>::min() ||
        *number > std::numeric_limits<int>::max())
        return {};
    return int(*number);
}

/// Adds a name, in one line and not too long. @returns false without one, and for the background
bool add(LabelNames& names, int label, std::string_view text) {
    std::string name(trimmed(text));
    for (char& c : name)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    std::size_t end = std::min(name.size(), kMaxNameBytes);
    while (end < name.size() && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
    name.resize(end);
    if (label == 0 || name.empty()) return false;
    names.insert_or_assign(label, std::move(name));
    return true;
}

/// Whether an object maps labels to names: by its keys, or by its values.
/// @param may_be_values  whether {"spleen": 1} counts
bool add_object(const Json& object, bool may_be_values, LabelNames& names) {
    bool any = false;
    for (const auto& [key, value] : object.items()) {
        const auto label = label_from(key);
        if (label && value.is_string()) {
            any |= add(names, *label, value.get<std::string>());
        } else if (may_be_values && value.is_number_integer()) {
            if (const auto number = label_from(value.dump())) any |= add(names, *number, key);
        }
    }
    return any;
}

void add_list(const Json& list, LabelNames& names) {
    for (const Json& one : list) {
        if (!one.is_object()) continue;
        const auto name = one.find("name");
        if (name == one.end() || !name->is_string()) continue;
        for (const char* key : {"value", "label", "labelValue", "id"}) {
            const auto value = one.find(key);
            if (value == one.end() || !value->is_number_integer()) continue;
            if (const auto label = label_from(value->dump()))
                add(names, *label, name->get<std::string>());
            break;
        }
    }
}

/// @param is_beside  other programs write JSON beside images, too: {"EchoTime": 1} is no table
LabelNames names_of_json(const std::string& text, bool is_beside) {
    LabelNames names;
    const Json json = Json::parse(text, nullptr, false);
    if (json.is_array()) add_list(json, names);
    if (!json.is_object()) return names;
    const auto labels = json.find("labels");
    if (labels == json.end())
        add_object(json, !is_beside, names);
    else if (labels->is_array())
        add_list(*labels, names);
    else if (labels->is_object())
        add_object(*labels, true, names);
    return names;
}

std::string with_blanks(std::string_view text) {
    std::string name(text);
    std::replace(name.begin(), name.end(), '_', ' ');
    return name;
}

/// Adds the name in a line: "1,spleen", "1 255 0 0 1 1 1 "spleen"" or "1 spleen 255 0 0 255".
bool add_line(std::string_view line, LabelNames& names) {
    const auto separator = line.find_first_of(",;\t ");
    if (separator == std::string_view::npos) return false;
    std::string_view first = line.substr(0, separator);
    if (first.ends_with(':')) first.remove_suffix(1);
    const auto label = label_from(first);
    if (!label) return false;
    std::string_view rest = trimmed(line.substr(separator + 1));
    const auto opens = rest.find('"');
    if (const auto closes = rest.rfind('"'); opens != std::string_view::npos && closes > opens)
        return add(names, *label, rest.substr(opens + 1, closes - opens - 1)) || *label == 0;
    if (line[separator] == ',' || line[separator] == ';')
        return add(names, *label, with_blanks(rest.substr(0, rest.find(line[separator])))) ||
               *label == 0;
    std::string flat(rest);
    std::replace(flat.begin(), flat.end(), '\t', ' ');
    const auto words = split(flat, ' ');
    std::size_t count = words.size();
    while (count > 0 && number_from(words[count - 1])) --count;
    if (words.size() - count < kColours) count = words.size();
    std::string name;
    for (std::size_t n = 0; n < count; ++n) name += (n > 0 ? " " : "") + std::string(words[n]);
    return add(names, *label, with_blanks(name)) || *label == 0;
}

/// Names of a text most of whose lines have one, without comments.
/// @param is_beside  all lines must have one
LabelNames names_of_lines(std::string_view text, bool is_beside) {
    LabelNames names;
    std::size_t others = 0;
    for (std::size_t number = 0; !text.empty(); ++number) {
        const auto end = std::min(text.find('\n'), text.size());
        const std::string_view line = trimmed(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        if (line.empty() || line.front() == '#' || line.starts_with("//")) continue;
        const bool may_be_head = number == 0 && line.find_first_of(",;") != std::string_view::npos;
        if (!add_line(line, names) && !may_be_head) ++others;
    }
    if (others > (is_beside ? 0 : names.size())) names.clear();
    return names;
}

LabelNames names_of_text(const std::string& content, bool is_beside) {
    std::string_view text = content;
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    const std::string_view start = trimmed(text.substr(0, 256));
    const bool is_json = start.starts_with('{') || start.starts_with('[');
    if (!is_json) return names_of_lines(text, is_beside);
    if (!check_nesting(text, TextSyntax::Json)) return {};
    return names_of_json(std::string(text), is_beside);
}

/// Names of 3D Slicer's segments: Segment0_LabelValue and Segment0_Name.
LabelNames names_of_segments(const KeyValues& key_values) {
    std::map<std::string, std::pair<std::optional<int>, std::string>> segments;
    for (const auto& [key, value] : key_values) {
        const auto end = key.find('_');
        if (!key.starts_with("Segment") || end == std::string::npos) continue;
        auto& segment = segments[key.substr(0, end)];
        if (key.substr(end + 1) == "LabelValue") segment.first = label_from(value);
        if (key.substr(end + 1) == "Name") segment.second = value;
    }
    LabelNames names;
    for (const auto& [key, segment] : segments)
        if (segment.first) add(names, *segment.first, segment.second);
    return names;
}

/// Text of an XML element without its entities and its CDATA.
std::string plain_text(std::string_view xml) {
    constexpr std::string_view kOpens = "<![CDATA[", kCloses = "]]>";
    xml = trimmed(xml);
    if (xml.starts_with(kOpens) && xml.ends_with(kCloses))
        return std::string(xml.substr(kOpens.size(), xml.size() - kOpens.size() - kCloses.size()));
    std::string text;
    while (!xml.empty()) {
        constexpr std::array<std::pair<std::string_view, char>, 5> kEntities = {
            {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}}};
        const auto found = std::find_if(kEntities.begin(), kEntities.end(),
                                        [&](const auto& e) { return xml.starts_with(e.first); });
        text += found == kEntities.end() ? xml.front() : found->second;
        xml.remove_prefix(found == kEntities.end() ? 1 : found->first.size());
    }
    return text;
}

/// Names in an extension of a NIfTI file as TotalSegmentator and Connectome Workbench write it:
/// <Label Key="1" …>spleen</Label>.
LabelNames names_of_extension(std::string_view xml) {
    constexpr std::string_view kTag = "<Label ", kKey = " Key=\"", kEnd = "</Label>";
    LabelNames names;
    for (auto at = xml.find(kTag); at != std::string_view::npos; at = xml.find(kTag, at + 1)) {
        const std::string_view rest = xml.substr(at);
        const auto opened = rest.find('>'), closed = rest.find(kEnd);
        if (opened == std::string_view::npos || closed == std::string_view::npos || opened > closed)
            break;
        const std::string_view head = rest.substr(0, opened);
        const auto key = head.find(kKey);
        if (key == std::string_view::npos) continue;
        const std::string_view number = head.substr(key + kKey.size());
        if (const auto label = label_from(number.substr(0, number.find('"'))))
            add(names, *label, plain_text(rest.substr(opened + 1, closed - opened - 1)));
    }
    return names;
}

/// The map's path without the endings of images.
fs::path without_ending(const fs::path& map) {
    fs::path stem = map.stem();
    for (const char* ending : {".nii", ".seg"})
        if (lower_case(stem.extension().string()) == ending) stem = stem.stem();
    return map.parent_path() / stem;
}

}  // namespace

Result<LabelNames> read_label_names(const fs::path& table) {
    const auto text = read_small_file(table, kMaxTableBytes, "a table of labels' names");
    if (!text) return text.error();
    LabelNames names = names_of_text(*text, false);
    if (names.empty())
        return Error{ErrorCode::Unreadable,
                     table.string() +
                         ": expected lines of a label's value and its name, or JSON of them, "
                         "found none"};
    return names;
}

Result<LabelNames> find_label_names(const fs::path& map, const KeyValues& key_values,
                                    const fs::path& table) {
    if (!table.empty()) return read_label_names(table);
    LabelNames names = names_of_segments(key_values);
    if (names.empty()) {
        const auto extension = nifti_extension(map);
        if (!extension) return extension.error();
        names = names_of_extension(*extension);
    }
    for (const char* ending : {".json", ".ctbl", ".csv", ".txt", ".label"}) {
        if (!names.empty()) break;
        fs::path beside = without_ending(map);
        beside += ending;
        const auto type = type_of(beside);
        if (type && *type != fs::file_type::regular) continue;
        InputFile file(beside);
        if (file.size() > kMaxTableBytes) continue;
        const auto text = file.read_rest();
        if (!text)
            return Error{text.error().code, text.error().message +
                                                "; it may have the labels' names: make it "
                                                "readable, or choose a table with --label-names"};
        names = names_of_text(*text, true);
    }
    return names;
}

}  // namespace pliant
