// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/nrrd_fields.h"

#include "base/errors.h"
#include "base/text.h"
#include "formats/header_lines.h"

#include <cmath>

namespace pliant {
namespace fs = std::filesystem;
namespace {

std::string without(std::string_view text, std::string_view characters) {
    std::string result = lower_case(text);
    std::erase_if(result, [&](char c) { return characters.find(c) != characters.npos; });
    return result;
}

/// Standard name of a field; empty for other text. Blanks are optional.
std::string_view field_name(std::string_view text) {
    constexpr std::string_view kNames[] = {"content",
                                           "number",
                                           "type",
                                           "block size",
                                           "dimension",
                                           "space",
                                           "space dimension",
                                           "sizes",
                                           "spacings",
                                           "thicknesses",
                                           "axis mins",
                                           "axis maxs",
                                           "space directions",
                                           "centerings",
                                           "kinds",
                                           "labels",
                                           "units",
                                           "min",
                                           "max",
                                           "old min",
                                           "old max",
                                           "endian",
                                           "encoding",
                                           "line skip",
                                           "byte skip",
                                           "sample units",
                                           "space units",
                                           "space origin",
                                           "measurement frame",
                                           "data file"};
    const std::string name = without(trimmed(text), " ");
    if (name == "centers") return "centerings";
    for (const std::string_view known : kNames)
        if (name == without(known, " ")) return known;
    return {};
}

/// Unescapes "\n" and "\\" to a line's end and a backslash.
std::string unescaped(std::string_view text) {
    std::string result;
    for (std::size_t n = 0; n < text.size(); ++n) {
        const bool escapes = text[n] == '\\' && n + 1 < text.size();
        if (escapes && text[n + 1] == 'n')
            result += '\n', ++n;
        else if (escapes && text[n + 1] == '\\')
            result += '\\', ++n;
        else
            result += text[n];
    }
    return result;
}

/// Parses lines other than comments and empty lines.
class LineTaker {
  public:
    LineTaker(const fs::path& path, NrrdFields& fields) : m_path(path), m_fields(fields) {}
    Status take(std::string_view line);
    /// Whether names of data files follow.
    bool is_list() const { return m_is_list; }

  private:
    Status take_field(std::string_view name, std::string_view value);
    Status take_key(std::string key, std::string value);

    const fs::path& m_path;
    NrrdFields& m_fields;
    std::map<std::string, std::size_t> m_positions;  ///< positions of keys
    bool m_is_list = false;
};

Status LineTaker::take_field(std::string_view name, std::string_view value) {
    if (!m_fields.values.emplace(name, trimmed(value)).second)
        return unreadable(m_path, std::string(name) + " is there twice, expected once");
    m_is_list = name == "data file" && lower_case(m_fields.field(name)).starts_with("list");
    return Ok{};
}

/// Stores a key. A later value replaces an earlier one.
Status LineTaker::take_key(std::string key, std::string value) {
    // Skips ITK's header fields and empty names.
    if (key.empty() || is_itk_key(key)) return Ok{};
    const auto [at, is_new] = m_positions.emplace(key, m_fields.key_values.size());
    if (!is_new) {
        m_fields.key_values[at->second].second = std::move(value);
        return Ok{};
    }
    if (m_positions.size() > kMaxKeyValues)
        return unreadable(m_path, "has more than " + std::to_string(kMaxKeyValues) + " keys");
    m_fields.key_values.emplace_back(std::move(key), std::move(value));
    return Ok{};
}

Status LineTaker::take(std::string_view line) {
    // Keys may hold ": ", unless the text before it is a field; values may hold ":=".
    const std::size_t colon = line.find(':');
    std::string_view name;
    if (const std::size_t at = line.find(": "); at != line.npos)
        name = field_name(line.substr(0, at));
    const std::size_t key_end = line.find(":=");
    if (name.empty() && key_end == line.npos && colon != line.npos)
        name = field_name(line.substr(0, colon));
    if (!name.empty()) return take_field(name, line.substr(colon + 1));
    if (key_end != line.npos)
        return take_key(unescaped(line.substr(0, key_end)), unescaped(line.substr(key_end + 2)));
    const std::string shown_line = "header line '" + shown(line) + "'";
    if (colon == line.npos) return unreadable(m_path, shown_line + " has no colon");
    return unreadable(m_path, shown_line + " has an unknown field, expected one of NRRD's");
}

}  // namespace

Error bad_nrrd_field(const fs::path& path, std::string_view field, std::string_view found,
                     const std::string& expected) {
    return unreadable(path,
                      std::string(field) + " is '" + shown(found) + "', expected " + expected);
}

Result<NrrdFields> read_nrrd_fields(const fs::path& path) {
    HeaderLines lines(path);
    NrrdFields fields;
    LineTaker taker(path, fields);
    for (bool is_first = true;; is_first = false) {
        auto line = lines.next();
        if (!line) return line.error();
        if (!*line) break;
        fields.header_bytes = lines.bytes_read();
        const std::string& text = **line;
        if (is_first) {
            if (text.size() != 8 || text < "NRRD0001" || text > "NRRD0005")
                return unreadable(path, "is '" + shown(text) + "', expected NRRD0001 to NRRD0005");
            continue;
        }
        if (text.empty()) return fields;
        if (taker.is_list()) {
            fields.listed_files.emplace_back(trimmed(text));
        } else if (text[0] != '#') {
            if (Status status = taker.take(text); !status) return status.error();
        }
    }
    if (fields.field("data file").empty())
        return unreadable(path, "ends early: the header has no end and names no data file");
    return fields;
}

std::optional<Component> nrrd_type_from(std::string_view name) {
    static const std::map<std::string, Component, std::less<>> kTypes = {
        {"signed char", Component::Int8},
        {"int8", Component::Int8},
        {"int8_t", Component::Int8},
        {"uchar", Component::UInt8},
        {"unsigned char", Component::UInt8},
        {"uint8", Component::UInt8},
        {"uint8_t", Component::UInt8},
        {"short", Component::Int16},
        {"short int", Component::Int16},
        {"signed short", Component::Int16},
        {"signed short int", Component::Int16},
        {"int16", Component::Int16},
        {"int16_t", Component::Int16},
        {"ushort", Component::UInt16},
        {"unsigned short", Component::UInt16},
        {"unsigned short int", Component::UInt16},
        {"uint16", Component::UInt16},
        {"uint16_t", Component::UInt16},
        {"int", Component::Int32},
        {"signed int", Component::Int32},
        {"int32", Component::Int32},
        {"int32_t", Component::Int32},
        {"uint", Component::UInt32},
        {"unsigned int", Component::UInt32},
        {"uint32", Component::UInt32},
        {"uint32_t", Component::UInt32},
        {"longlong", Component::Int64},
        {"long long", Component::Int64},
        {"long long int", Component::Int64},
        {"signed long long", Component::Int64},
        {"signed long long int", Component::Int64},
        {"int64", Component::Int64},
        {"int64_t", Component::Int64},
        {"ulonglong", Component::UInt64},
        {"unsigned long long", Component::UInt64},
        {"unsigned long long int", Component::UInt64},
        {"uint64", Component::UInt64},
        {"uint64_t", Component::UInt64},
        {"float", Component::Float32},
        {"double", Component::Float64}};
    const auto found = kTypes.find(lower_case(name));
    return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

std::optional<NrrdSpace> nrrd_space_from(std::string_view name) {
    constexpr std::pair<std::string_view, NrrdSpace::Axes> kSpaces[] = {
        {"rightanteriorsuperior", NrrdSpace::Ras}, {"ras", NrrdSpace::Ras},
        {"leftanteriorsuperior", NrrdSpace::Las},  {"las", NrrdSpace::Las},
        {"leftposteriorsuperior", NrrdSpace::Lps}, {"lps", NrrdSpace::Lps},
        {"scannerxyz", NrrdSpace::Other},          {"3drighthanded", NrrdSpace::Other},
        {"3dlefthanded", NrrdSpace::Other}};
    const std::string word = without(name, " -");
    for (const auto& [known, axes] : kSpaces) {
        if (!word.starts_with(known)) continue;
        const std::string_view rest = std::string_view(word).substr(known.size());
        if (rest.empty()) return NrrdSpace{axes, 3};
        const bool is_short = known.size() == 3 || known == "scannerxyz";
        if (rest == "time" ? known.size() > 3 : rest == "t" && is_short) return NrrdSpace{axes, 4};
    }
    return std::nullopt;
}

std::optional<NrrdKind> nrrd_kind_from(std::string_view name) {
    static const std::map<std::string, std::int64_t, std::less<>> kSizes = {
        {"list", 0},      {"point", 0},     {"vector", 0},    {"contravariant-vector", 0},
        {"normal", 0},    {"stub", 1},      {"scalar", 1},    {"covariant-vector", 0},
        {"complex", 2},   {"2-vector", 2},  {"3-color", 3},   {"rgb-color", 3},
        {"rgbcolor", 3},  {"rgb", 3},       {"hsv-color", 3}, {"hsvcolor", 3},
        {"hsv", 3},       {"xyz-color", 3}, {"4-color", 4},   {"rgba-color", 4},
        {"rgbacolor", 4}, {"rgba", 4},      {"3-vector", 3},  {"3-gradient", 3},
        {"3-normal", 3},  {"4-vector", 4},  {"quaternion", 4}};
    const std::string word = lower_case(name);
    if (word == "domain" || word == "space" || word == "time" || word == "???" || word == "none")
        return NrrdKind{};
    if (const auto found = kSizes.find(word); found != kSizes.end())
        return NrrdKind{false, found->second};
    // "2D-symmetric-matrix", "3D-masked-sym-tensor", …: the entries of a matrix, and its mask.
    const bool is_3d = word.starts_with("3d-");
    if (!is_3d && !word.starts_with("2d-")) return std::nullopt;
    std::string_view rest = std::string_view(word).substr(3);
    const auto takes = [&](std::string_view part) {
        if (!rest.starts_with(part)) return false;
        rest.remove_prefix(part.size());
        return true;
    };
    const bool is_masked = takes("masked-");
    const bool is_symmetric = takes("symmetric-") || takes("sym-");
    if (rest != "matrix" && rest != "tensor") return std::nullopt;
    const std::int64_t entries = is_3d ? (is_symmetric ? 6 : 9) : (is_symmetric ? 3 : 4);
    return NrrdKind{false, entries + (is_masked ? 1 : 0)};
}

std::optional<std::vector<std::optional<std::array<double, 4>>>> nrrd_vectors_from(
    std::string_view text, std::size_t dimension) {
    std::vector<std::optional<std::array<double, 4>>> vectors;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        if (vectors.size() == 16) return std::nullopt;  // limit of the format
        if (text.starts_with("none")) {
            text.remove_prefix(4);
            if (!text.empty() && trimmed(text.substr(0, 1)) != "") return std::nullopt;
            vectors.emplace_back(std::nullopt);
            continue;
        }
        const std::size_t end = text.find(')');
        if (text[0] != '(' || end == text.npos) return std::nullopt;
        const std::string_view inside = text.substr(1, end - 1);
        text.remove_prefix(end + 1);
        const auto numbers = numbers_from(inside, ',');
        if (!numbers || numbers->size() != dimension) return std::nullopt;
        std::array<double, 4> vector{};
        for (std::size_t n = 0; n < dimension; ++n) {
            vector[n] = (*numbers)[n];
            if (!std::isfinite(vector[n])) return std::nullopt;
        }
        vectors.emplace_back(vector);
    }
    return vectors;
}

std::optional<std::vector<std::string>> quoted_words_from(std::string_view text) {
    std::vector<std::string> words;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        if (text[0] != '"' || words.size() == 16) return std::nullopt;
        std::string word;
        std::size_t n = 1;
        for (; n < text.size() && text[n] != '"'; ++n) {
            if (text[n] == '\\' && n + 1 < text.size() && text[n + 1] == '"') ++n;
            word += text[n];
        }
        if (n == text.size()) return std::nullopt;
        words.push_back(std::move(word));
        text.remove_prefix(n + 1);
    }
    return words;
}

}  // namespace pliant
