// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NRRD: lines `field: value`, `key:=value` and comments, up to an empty line; then the data, or a
// field that names the file with the data.

#include "volume/image_header.h"
#include "volume/text.h"

#include <fstream>
#include <map>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxHeaderBytes = 1 << 20;

struct Lines {
    std::map<std::string, std::string, std::less<>> fields;
    KeyValues key_values;
    std::vector<std::string> listed_files;  ///< after "data file: LIST"
    std::size_t header_bytes = 0;

    std::string_view field(std::string_view name) const {
        const auto found = fields.find(name);
        return found == fields.end() ? std::string_view{} : found->second;
    }
};

Error damaged(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unreadable, path.string() + ": " + message};
}
Error bad_field(const fs::path& path, std::string_view field, std::string_view found,
                const std::string& expected) {
    return damaged(path, std::string(field) + " is '" + shown(found) + "', expected " + expected);
}

std::string unescaped(std::string_view text) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool escape = text[i] == '\\' && i + 1 < text.size();
        if (escape && text[i + 1] == 'n') {
            result += '\n';
            ++i;
        } else if (escape && text[i + 1] == '\\') {
            result += '\\';
            ++i;
        } else {
            result += text[i];
        }
    }
    return result;
}

/// Fields that may be written with or without a blank.
std::string field_name(std::string_view text) {
    const std::string name = lower_case(trimmed(text));
    static const std::map<std::string, std::string, std::less<>> kAliases = {
        {"datafile", "data file"},
        {"byteskip", "byte skip"},
        {"lineskip", "line skip"},
        {"centers", "centerings"}};
    const auto found = kAliases.find(name);
    return found == kAliases.end() ? name : found->second;
}

Result<Lines> read_lines(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text(kMaxHeaderBytes, '\0');
    file.read(text.data(), std::streamsize(text.size()));
    text.resize(std::size_t(file.gcount()));
    Lines lines;
    std::size_t at = 0;
    bool list = false;
    while (at < text.size()) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        std::string_view line(text.data() + at, end - at);
        if (line.ends_with('\r')) line.remove_suffix(1);
        const bool magic = at == 0;
        at = std::min(end + 1, text.size());
        if (line.empty()) {
            lines.header_bytes = at;
            return lines;
        }
        if (magic || line.starts_with('#')) continue;
        if (list) {
            lines.listed_files.emplace_back(trimmed(line));
            continue;
        }
        const std::size_t colon = line.find(':');
        if (colon == line.npos)
            return damaged(path, "header line '" + shown(line) + "' has no colon");
        if (line.substr(colon).starts_with(":=")) {
            std::string key = unescaped(line.substr(0, colon));
            if (!is_itk_key(key))
                lines.key_values.emplace_back(std::move(key), unescaped(line.substr(colon + 2)));
            continue;
        }
        const std::string name = field_name(line.substr(0, colon));
        lines.fields[name] = trimmed(line.substr(colon + 1));
        list = name == "data file" && lower_case(lines.fields[name]).starts_with("list");
    }
    if (lines.field("data file").empty())
        return damaged(path, "ends early: the header has no end and names no data file");
    return lines;
}

std::optional<Component> component_named(std::string_view name) {
    static const std::map<std::string, Component, std::less<>> kNames = {
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
    const auto found = kNames.find(lower_case(name));
    if (found == kNames.end()) return std::nullopt;
    return found->second;
}

/// "(1,0,0)" → vector.
std::optional<Vec3d> vector_from(std::string_view text) {
    if (!text.starts_with('(') || !text.ends_with(')')) return std::nullopt;
    const auto n = numbers_from(text.substr(1, text.size() - 2), ',');
    if (!n || n->size() != 3) return std::nullopt;
    return Vec3d{(*n)[0], (*n)[1], (*n)[2]};
}

/// "none (1,0,0) (0, 1, 0)" → its words.
std::vector<std::string> vector_words(std::string_view text) {
    std::vector<std::string> words;
    int depth = 0;
    bool open = false;
    for (const char c : text) {
        if (c == ')') --depth;
        if ((c == ' ' || c == '\t') && depth <= 0) {
            open = false;
            continue;
        }
        if (c == '(' && depth++ == 0) open = false;
        if (!open) words.emplace_back();
        open = true;
        words.back() += c;
    }
    return words;
}

Status read_sizes(const fs::path& path, const Lines& lines, ImageHeader& header,
                  std::vector<std::string_view>& kinds) {
    const auto dimension = whole_number_from(lines.field("dimension"));
    if (!dimension || *dimension < 1 || *dimension > 16)
        return bad_field(path, "dimension", lines.field("dimension"), "1 to 16");
    for (const std::string_view text : split(lines.field("sizes"), ' ')) {
        const auto size = whole_number_from(text);
        if (!size) return bad_field(path, "sizes", lines.field("sizes"), "whole numbers");
        header.sizes.push_back(*size);
    }
    if (std::int64_t(header.sizes.size()) != *dimension)
        return bad_field(path, "sizes", lines.field("sizes"),
                         std::to_string(*dimension) + " numbers, as many as the dimension");
    kinds = split(lines.field("kinds"), ' ');
    if (!kinds.empty() && kinds.size() != header.sizes.size())
        return bad_field(path, "kinds", lines.field("kinds"), "one word for each axis");
    return Ok{};
}

/// Takes an axis of vector components, which isn't one of space, out of the sizes.
Status take_out_components(const fs::path& path, const std::vector<std::string_view>& kinds,
                           const std::vector<std::string>& directions, ImageHeader& header) {
    const auto of_space = [&](std::size_t axis) {
        if (axis < directions.size() && directions[axis] == "none") return false;
        if (axis >= kinds.size()) return true;
        const std::string kind = lower_case(kinds[axis]);
        return kind == "domain" || kind == "space" || kind == "time" || kind == "???" ||
               kind == "none";
    };
    for (std::size_t axis = 1; axis < header.sizes.size(); ++axis)
        if (!of_space(axis) && header.sizes.size() > 3 && of_space(0))
            return Error{ErrorCode::Unsupported, path.string() + ": axis " +
                                                     std::to_string(axis + 1) +
                                                     " holds vectors, expected axis 1"};
    if (header.sizes.empty() || of_space(0)) return Ok{};
    header.components = header.sizes.front();
    header.sizes.erase(header.sizes.begin());
    return Ok{};
}

/// Sign of each component that turns a vector of the file's space into LPS.
Result<Vec3d> sign_of_space(const fs::path& path, std::string_view field, ImageHeader& header) {
    std::string space = lower_case(field);
    if (space.ends_with("-time")) space.resize(space.size() - 5);
    if (space == "left-posterior-superior" || space == "lps") return Vec3d{1, 1, 1};
    const bool ras = space == "right-anterior-superior" || space == "ras";
    const bool las = space == "left-anterior-superior" || space == "las";
    if (ras || las) {
        header.notes.push_back("converted from " + std::string(ras ? "RAS" : "LAS") + " to LPS");
        return Vec3d{ras ? -1.0 : 1.0, -1, 1};
    }
    if (space == "scanner-xyz" || space == "3d-right-handed" || space == "3d-left-handed" ||
        space.empty()) {
        header.notes.push_back(space.empty() ? "no space is named; taken as LPS"
                                             : "space '" + space + "' is taken as LPS");
        return Vec3d{1, 1, 1};
    }
    return bad_field(path, "space", field, "left-posterior-superior or another 3-D space");
}

/// Millimetres for each unit that "space units" names.
Result<double> millimetres_per_unit(const fs::path& path, std::string_view field) {
    static const std::map<std::string, double, std::less<>> kUnits = {
        {"mm", 1},   {"millimeter", 1}, {"millimetre", 1},    {"", 1},
        {"???", 1},  {"um", 1e-3},      {"micrometer", 1e-3}, {"cm", 10},
        {"m", 1000}, {"meter", 1000},   {"microns", 1e-3}};
    std::optional<double> scale;
    for (std::string_view unit : split(field, ' ')) {
        if (unit.starts_with('"')) unit.remove_prefix(1);
        if (unit.ends_with('"')) unit.remove_suffix(1);
        const auto found = kUnits.find(lower_case(unit));
        if (found == kUnits.end() || (scale && *scale != found->second))
            return bad_field(path, "space units", field, "\"mm\" for each axis");
        scale = found->second;
    }
    return scale.value_or(1);
}

Status read_oriented_grid(const fs::path& path, const Lines& lines,
                          std::vector<std::string> directions, ImageHeader& header) {
    auto sign = sign_of_space(path, lines.field("space"), header);
    if (!sign) return sign.error();
    auto unit_mm = millimetres_per_unit(path, lines.field("space units"));
    if (!unit_mm) return unit_mm.error();
    header.vector_sign = *sign;
    const auto in_lps = [&](Vec3d v) {
        return *unit_mm * Vec3d{sign->x * v.x, sign->y * v.y, sign->z * v.z};
    };
    std::erase(directions, "none");
    Vec3d steps[3];
    for (std::size_t a = 0; a < 3; ++a) {
        const auto step = a < directions.size() ? vector_from(directions[a]) : std::nullopt;
        if (!step || directions.size() != 3 || !is_finite(*step))
            return bad_field(path, "space directions", lines.field("space directions"),
                             "a vector (x,y,z) for each axis of space");
        steps[a] = in_lps(*step);
        if (norm(steps[a]) == 0)
            return bad_field(path, "space directions", lines.field("space directions"),
                             "vectors that are longer than zero");
    }
    set_axes(header.grid, steps);
    if (lines.field("space origin").empty()) {
        header.notes.push_back("no space origin; the first voxel is put at (0, 0, 0)");
        return Ok{};
    }
    const auto origin = vector_from(lines.field("space origin"));
    if (!origin || !is_finite(*origin))
        return bad_field(path, "space origin", lines.field("space origin"), "a vector (x,y,z)");
    header.grid.origin_mm = in_lps(*origin);
    return Ok{};
}

/// Without directions there are at most the distances between voxels.
Status read_plain_grid(const fs::path& path, const Lines& lines, ImageHeader& header) {
    header.notes.push_back("no orientation; the axes are taken as L, P, S from (0, 0, 0)");
    const std::string_view field = lines.field("spacings");
    if (field.empty()) {
        header.notes.push_back("no spacings; taken as 1 mm");
        return Ok{};
    }
    auto spacings = numbers_from(field);
    const auto skipped = std::size_t(header.components > 1);
    if (!spacings || spacings->size() != skipped + 3)
        return bad_field(path, "spacings", field, "a number for each axis");
    for (int a = 0; a < 3; ++a) header.grid.spacing_mm[a] = (*spacings)[skipped + std::size_t(a)];
    return Ok{};
}

Status read_grid(const fs::path& path, const Lines& lines,
                 const std::vector<std::string>& directions, ImageHeader& header) {
    const auto space_dimension = lines.field("space dimension");
    if (!space_dimension.empty() && trimmed(space_dimension) != "3")
        return bad_field(path, "space dimension", space_dimension, "3");
    if (directions.empty()) return read_plain_grid(path, lines, header);
    return read_oriented_grid(path, lines, directions, header);
}

Status read_encoding(const fs::path& path, const Lines& lines, ImageHeader& header) {
    const std::string encoding = lower_case(lines.field("encoding"));
    if (encoding == "raw") {
        header.data.encoding = DataEncoding::Raw;
    } else if (encoding == "gz" || encoding == "gzip") {
        header.data.encoding = DataEncoding::Deflated;
    } else if (encoding == "txt" || encoding == "text" || encoding == "ascii") {
        header.data.encoding = DataEncoding::Text;
    } else {
        return Error{ErrorCode::Unsupported, path.string() + ": encoding is '" + shown(encoding) +
                                                 "', expected raw, gzip or text"};
    }
    if (header.data.encoding == DataEncoding::Text || size_of(header.component) == 1) return Ok{};
    const std::string endian = lower_case(lines.field("endian"));
    if (endian != "little" && endian != "big")
        return bad_field(path, "endian", endian, "little or big");
    header.data.big_endian = endian == "big";
    return Ok{};
}

Status read_skips(const fs::path& path, const Lines& lines, DataPlace& data) {
    const std::string_view line_text = lines.field("line skip");
    const std::string_view byte_text = lines.field("byte skip");
    const auto line_skip = line_text.empty() ? 0 : whole_number_from(line_text);
    const auto byte_skip = byte_text.empty() ? 0 : whole_number_from(byte_text);
    if (!line_skip || *line_skip < 0)
        return bad_field(path, "line skip", line_text, "a number ≥ 0");
    const bool raw = data.encoding == DataEncoding::Raw;
    if (!byte_skip || *byte_skip < (raw ? -1 : 0))
        return bad_field(path, "byte skip", byte_text, raw ? "a number ≥ -1" : "a number ≥ 0");
    data.line_skip = *line_skip;
    data.at_the_end = *byte_skip < 0;
    if (data.encoding == DataEncoding::Deflated)
        data.inner_skip = std::uint64_t(*byte_skip);
    else if (!data.at_the_end)
        data.byte_skip = std::uint64_t(*byte_skip);
    return Ok{};
}

Status read_data_place(const fs::path& path, const Lines& lines, ImageHeader& header) {
    if (Status status = read_encoding(path, lines, header); !status) return status;
    DataPlace& data = header.data;
    if (Status status = read_skips(path, lines, data); !status) return status;
    const std::string_view name = lines.field("data file");
    const fs::path folder = path.parent_path();
    if (name.empty()) {
        data.files = {path};
        data.start = lines.header_bytes;
    } else if (lower_case(name).starts_with("list")) {
        for (const std::string& file : lines.listed_files) data.files.push_back(folder / file);
    } else if (name.find('%') != name.npos) {
        for (const std::string& file : numbered_names(name)) data.files.push_back(folder / file);
    } else {
        data.files = {folder / fs::path(name)};
    }
    return Ok{};
}

/// Whether vectors are measured along other axes than those of the space.
bool has_turned_vectors(const Lines& lines) {
    const auto words = vector_words(lines.field("measurement frame"));
    for (std::size_t a = 0; a < words.size(); ++a) {
        const auto axis = vector_from(words[a]);
        if (a >= 3 || axis != kIdentity3.columns[a]) return true;
    }
    return false;
}

}  // namespace

Result<ImageHeader> read_nrrd_header(const fs::path& path) {
    auto lines = read_lines(path);
    if (!lines) return lines.error();
    ImageHeader header;
    header.format = ImageFormat::Nrrd;
    const auto component = component_named(lines->field("type"));
    if (!component) return bad_field(path, "type", lines->field("type"), "a type of number");
    header.component = *component;
    header.key_values = lines->key_values;
    std::vector<std::string_view> kinds;
    if (Status status = read_sizes(path, *lines, header, kinds); !status) return status.error();
    const auto directions = vector_words(lines->field("space directions"));
    if (Status status = take_out_components(path, kinds, directions, header); !status)
        return status.error();
    if (header.sizes.size() == 3)  // else it will be refused for that
        if (Status status = read_grid(path, *lines, directions, header); !status)
            return status.error();
    if (Status status = read_data_place(path, *lines, header); !status) return status.error();
    header.turned_vectors = has_turned_vectors(*lines);
    return header;
}

}  // namespace pliant
