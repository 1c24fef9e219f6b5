// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// VTK's legacy files with structured points [VTK2010]: lines of keywords, then numbers in text or
// big-endian bytes. Without orientation; VTK's world is taken as LPS.

#include "base/errors.h"
#include "base/text.h"
#include "formats/header_lines.h"
#include "formats/image_header.h"

#include <bit>
#include <map>

namespace pliant {
namespace fs = std::filesystem;
namespace {

Error bad_keyword(const fs::path& path, const std::string& keyword, std::string_view found,
                  const std::string& expected) {
    return unreadable(path, keyword + " is '" + shown(found) + "', expected " + expected);
}

/// A line of keywords: the first one in lower case, and the rest.
struct KeywordLine {
    std::string keyword, rest;
};

/// The next line that isn't empty. @returns Unreadable at the end of the file
Result<KeywordLine> next_keyword(const fs::path& path, HeaderLines& lines) {
    for (;;) {
        auto text = lines.next();
        if (!text) return text.error();
        if (!*text) return unreadable(path, "ends early: the header has no SCALARS");
        const std::string_view line = trimmed(**text);
        if (line.empty()) continue;
        const std::size_t blank = std::min(line.find_first_of(" \t"), line.size());
        return KeywordLine{lower_case(line.substr(0, blank)),
                           std::string(trimmed(line.substr(blank)))};
    }
}

/// Reads the first three lines. @returns whether numbers are text
Result<bool> read_start(const fs::path& path, HeaderLines& lines) {
    for (int n = 0; n < 2; ++n) {
        auto line = lines.next();
        if (!line) return line.error();
        if (!*line) return unreadable(path, "ends early: expected two lines of header");
    }
    const auto kind = next_keyword(path, lines);
    if (!kind) return kind.error();
    if (kind->keyword != "ascii" && kind->keyword != "binary")
        return bad_keyword(path, "the third line", kind->keyword, "ASCII or BINARY");
    return kind->keyword == "ascii";
}

Result<Vec3d> three_numbers(const fs::path& path, const KeywordLine& line) {
    const auto numbers = numbers_from(line.rest);
    if (!numbers || numbers->size() != 3)
        return bad_keyword(path, line.keyword, line.rest, "three numbers");
    return Vec3d{(*numbers)[0], (*numbers)[1], (*numbers)[2]};
}

Status take_vtk_type(const fs::path& path, std::string_view name, ImageHeader& header) {
    // VTK's long has 64 bits where its files are usually written.
    static const std::map<std::string, Component, std::less<>> kTypes = {
        {"char", Component::Int8},
        {"signed_char", Component::Int8},
        {"unsigned_char", Component::UInt8},
        {"short", Component::Int16},
        {"unsigned_short", Component::UInt16},
        {"int", Component::Int32},
        {"unsigned_int", Component::UInt32},
        {"long", Component::Int64},
        {"unsigned_long", Component::UInt64},
        {"vtktypeint64", Component::Int64},
        {"vtktypeuint64", Component::UInt64},
        {"float", Component::Float32},
        {"double", Component::Float64}};
    const auto found = kTypes.find(lower_case(name));
    if (found == kTypes.end())
        return bad_keyword(path, "the type of its values", name, "short, float or the like");
    header.stored = found->second;
    return Ok{};
}

/// Reads "SCALARS name type [components]", and the line of the lookup table.
Status take_scalars(const fs::path& path, const KeywordLine& line, HeaderLines& lines,
                    ImageHeader& header) {
    const auto words = split(line.rest, ' ');
    if (words.size() < 2 || words.size() > 3)
        return bad_keyword(path, "SCALARS", line.rest, "a name, a type and a number");
    if (Status status = take_vtk_type(path, words[1], header); !status) return status;
    const auto components = words.size() == 3 ? whole_number_from(words[2]) : 1;
    if (!components || *components < 1 || *components > 4)
        return bad_keyword(path, "SCALARS", line.rest, "1 to 4 numbers for each point");
    header.components = *components;
    const auto table = next_keyword(path, lines);
    if (!table) return table.error();
    if (table->keyword != "lookup_table")
        return bad_keyword(path, "the line after SCALARS", table->keyword, "LOOKUP_TABLE");
    header.data.start = lines.bytes_read();
    return Ok{};
}

/// Reads "COLOR_SCALARS name components": as VTK writes images of bytes. Text would be fractions of
/// 255.
Status take_color_scalars(const fs::path& path, const KeywordLine& line, bool is_text,
                          const HeaderLines& lines, ImageHeader& header) {
    if (is_text) return unsupported(path, "has COLOR_SCALARS in text, expected bytes or SCALARS");
    const auto words = split(line.rest, ' ');
    const auto components = words.size() == 2 ? whole_number_from(words[1]) : std::nullopt;
    if (!components || *components < 1 || *components > 4)
        return bad_keyword(path, "COLOR_SCALARS", line.rest, "a name and a number from 1 to 4");
    header.stored = Component::UInt8;
    header.components = *components;
    header.data.start = lines.bytes_read();
    return Ok{};
}

/// Reads "FIELD name arrays", and the line of the first array: "name components tuples type".
Status take_field(const fs::path& path, HeaderLines& lines, ImageHeader& header) {
    const auto array = next_keyword(path, lines);
    if (!array) return array.error();
    const auto words = split(array->rest, ' ');
    const auto components = words.size() == 3 ? whole_number_from(words[0]) : std::nullopt;
    if (!components || *components < 1)
        return bad_keyword(path, "an array of FIELD", array->rest,
                           "numbers of components and points, and a type");
    header.components = *components;
    header.data.start = lines.bytes_read();
    return take_vtk_type(path, words[2], header);
}

/// Reads the keywords up to the values.
Status read_keywords(const fs::path& path, bool is_text, HeaderLines& lines, ImageHeader& header) {
    bool at_points = false;
    std::string number_of_points;
    for (;;) {
        const auto line = next_keyword(path, lines);
        if (!line) return line.error();
        if (line->keyword == "dataset") {
            if (lower_case(line->rest) != "structured_points")
                return unsupported(path,
                                   "holds a " + shown(line->rest) + ", expected STRUCTURED_POINTS");
        } else if (line->keyword == "dimensions") {
            const auto size = three_numbers(path, *line);
            if (!size) return size.error();
            header.sizes.clear();
            for (int a = 0; a < 3; ++a) {
                const double n = (*size)[a];
                if (n != std::trunc(n) || !(n >= 1 && n < 1e9))
                    return bad_keyword(path, "DIMENSIONS", line->rest, "three whole numbers");
                header.sizes.push_back(std::int64_t(n));
            }
        } else if (line->keyword == "spacing" || line->keyword == "aspect_ratio") {
            const auto spacing = three_numbers(path, *line);
            if (!spacing) return spacing.error();
            header.grid.spacing_mm = *spacing;
        } else if (line->keyword == "origin") {
            const auto origin = three_numbers(path, *line);
            if (!origin) return origin.error();
            header.grid.origin_mm = *origin;
        } else if (line->keyword == "point_data") {
            at_points = true;
            number_of_points = line->rest;
        } else if (line->keyword == "scalars" && at_points) {
            if (Status status = take_scalars(path, *line, lines, header); !status) return status;
            break;
        } else if (line->keyword == "color_scalars" && at_points) {
            if (Status status = take_color_scalars(path, *line, is_text, lines, header); !status)
                return status;
            break;
        } else if (line->keyword == "field" && at_points) {
            if (Status status = take_field(path, lines, header); !status) return status;
            break;
        } else {
            return unsupported(path, "has the keyword '" + shown(line->keyword) +
                                         "', expected those of structured points with scalars");
        }
    }
    if (Status status = check_size(path, header.sizes); !status) return status;
    const std::int64_t points = header.sizes[0] * header.sizes[1] * header.sizes[2];
    if (whole_number_from(number_of_points) != points)
        return bad_keyword(path, "POINT_DATA", number_of_points, std::to_string(points));
    return Ok{};
}

}  // namespace

Result<ImageHeader> read_vtk_header(const fs::path& path) {
    HeaderLines lines(path);
    const auto is_text = read_start(path, lines);
    if (!is_text) return is_text.error();
    ImageHeader header;
    header.format = ImageFormat::Vtk;
    if (Status status = read_keywords(path, *is_text, lines, header); !status)
        return status.error();
    header.data.files = {path};
    header.data.encoding = *is_text ? DataEncoding::Text : DataEncoding::Raw;
    header.data.swapped = std::endian::native == std::endian::little;
    header.notes.push_back("no orientation; the axes are taken as L, P, S");
    return header;
}

}  // namespace pliant
