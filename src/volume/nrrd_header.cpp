// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NRRD: lines `field: value`, `key:=value` and comments, up to an empty line; then the data, or a
// field that names the file with the data. ITK reads the lines; here they are searched for what ITK
// would misread, for where the data are, and for words to say what ITK could not read.

#include "core/errors.h"
#include "volume/data_check.h"
#include "volume/image_header.h"
#include "volume/itk_io.h"
#include "volume/text.h"

#include <algorithm>
#include <bit>
#include <fstream>
#include <map>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxNrrdHeaderBytes = 1 << 20;

struct Lines {
    std::map<std::string, std::string, std::less<>> fields;
    std::string keys;                       ///< the lines with keys, as they are
    std::vector<std::string> listed_files;  ///< after "data file: LIST"
    std::size_t header_bytes = 0;

    std::string_view field(std::string_view name) const {
        const auto found = fields.find(name);
        return found == fields.end() ? std::string_view{} : found->second;
    }
};

Error bad_field(const fs::path& path, std::string_view field, std::string_view found,
                const std::string& expected) {
    return unreadable(path,
                      std::string(field) + " is '" + shown(found) + "', expected " + expected);
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
    std::string text(kMaxNrrdHeaderBytes, '\0');
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
            return unreadable(path, "header line '" + shown(line) + "' has no colon");
        if (line.substr(colon).starts_with(":=")) {
            lines.keys += '\n' + std::string(line);
            continue;
        }
        const std::string name = field_name(line.substr(0, colon));
        lines.fields[name] = trimmed(line.substr(colon + 1));
        list = name == "data file" && lower_case(lines.fields[name]).starts_with("list");
    }
    if (lines.field("data file").empty())
        return unreadable(path, "ends early: the header has no end and names no data file");
    return lines;
}

/// Words for what ITK, with its description, could not read.
Error explained(const fs::path& path, const Lines& lines, std::string_view description) {
    static const std::map<std::string, const char*, std::less<>> kExpected = {
        {"type", "a type of number"},
        {"endian", "little or big"},
        {"sizes", "as many whole numbers as the dimension says"},
        {"kinds", "one word for each axis"},
        {"space", "left-posterior-superior or another 3-D space"},
        {"space directions", "a vector (x,y,z) for each axis of space"},
        {"space origin", "a vector (x,y,z)"}};
    std::string_view field;
    constexpr std::string_view kTrouble = "trouble parsing ";
    if (const std::size_t at = description.find(kTrouble); at != description.npos) {
        field = description.substr(at + kTrouble.size());
        field = field.substr(0, field.find(" info |"));
    }
    if (description.find("require endian info") != description.npos) field = "endian";
    if (description.find("type is block") != description.npos) field = "type";
    if (!lines.fields.contains(field) && field != "endian")
        return unreadable(path,
                          "its header can't be read (" +
                              shown(trimmed(description.substr(description.rfind(": ") + 1))) +
                              "), expected that of a NRRD file");
    const auto expected = kExpected.find(field);
    return bad_field(path, field, lines.field(field),
                     expected == kExpected.end() ? "another value" : expected->second);
}

/// Sizes, which ITK takes modulo some power of two, and geometry that it takes for missing where it
/// is no number.
Status check_numbers(const fs::path& path, const Lines& lines, std::vector<std::int64_t>& sizes) {
    for (const std::string_view text : split(lines.field("sizes"), ' ')) {
        const auto size = whole_number_from(text);
        if (!size) return bad_field(path, "sizes", lines.field("sizes"), "whole numbers");
        sizes.push_back(*size);
    }
    for (const char* field : {"space directions", "space origin"})
        for (const char* no_number : {"nan", "inf"})
            if (lower_case(lines.field(field)).find(no_number) != std::string::npos)
                return bad_field(path, field, lines.field(field), "finite numbers");
    const std::string_view text = lines.field("spacings");
    const auto spacings = numbers_from(text);
    if (!text.empty() && (!spacings || spacings->size() != sizes.size()))
        return bad_field(path, "spacings", text, "a number for each axis");
    for (std::size_t a = 0; a < 3 && !text.empty() && sizes.size() >= 3; ++a)
        if (Status status = check_spacing(path, int(a), (*spacings)[sizes.size() - 3 + a]); !status)
            return status;
    return check_counts(path, sizes);
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

/// Puts right what ITK made of the grid, and notes what had to be assumed.
Status finish_grid(const fs::path& path, const Lines& lines, ImageHeader& header) {
    Grid& grid = header.grid;
    std::string space = lower_case(lines.field("space"));
    if (lines.field("space directions").empty()) {
        grid.origin_mm = {};
        header.notes.push_back("no orientation; the axes are taken as L, P, S from (0, 0, 0)");
        if (lines.field("spacings").empty()) header.notes.push_back("no spacings; taken as 1 mm");
        return Ok{};
    }
    for (int a = 0; a < 3; ++a)
        if (grid.spacing_mm[a] == 0)
            return bad_field(path, "space directions", lines.field("space directions"),
                             "vectors that are longer than zero");
    const bool ras = space == "right-anterior-superior" || space == "ras";
    const bool las = space == "left-anterior-superior" || space == "las";
    if (las) {  // ITK 5.2 flips the first component, and it should be the second
        for (Vec3d& axis : grid.direction.columns) axis = {-axis.x, -axis.y, axis.z};
        grid.origin_mm = {-grid.origin_mm.x, -grid.origin_mm.y, grid.origin_mm.z};
    }
    if (ras || las) {
        header.notes.push_back("converted from " + std::string(ras ? "RAS" : "LAS") + " to LPS");
        header.vector_sign = {ras ? -1.0 : 1.0, -1, 1};
    } else if (space.empty()) {
        header.notes.push_back("no space is named; taken as LPS");
    } else if (space != "left-posterior-superior" && space != "lps") {
        header.notes.push_back("space '" + shown(space) + "' is taken as LPS");
    }
    if (lines.field("space origin").empty())
        header.notes.push_back("no space origin; the first voxel is put at (0, 0, 0)");
    const auto unit_mm = millimetres_per_unit(path, lines.field("space units"));
    if (!unit_mm) return unit_mm.error();
    grid.spacing_mm = *unit_mm * grid.spacing_mm;
    grid.origin_mm = *unit_mm * grid.origin_mm;
    return Ok{};
}

Status find_encoding(const fs::path& path, const Lines& lines, DataPlace& data) {
    const std::string encoding = lower_case(lines.field("encoding"));
    if (encoding == "raw") {
        data.encoding = DataEncoding::Raw;
    } else if (encoding == "gz" || encoding == "gzip") {
        data.encoding = DataEncoding::Deflated;
    } else if (encoding == "txt" || encoding == "text" || encoding == "ascii") {
        data.encoding = DataEncoding::Text;
    } else {
        return Error{ErrorCode::Unsupported, path.string() + ": encoding is '" + shown(encoding) +
                                                 "', expected raw, gzip or text"};
    }
    return Ok{};
}

Status find_skips(const fs::path& path, const Lines& lines, DataPlace& data) {
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
    if (data.encoding == DataEncoding::Deflated)
        data.inner_skip = std::uint64_t(*byte_skip);
    else if (*byte_skip > 0)
        data.byte_skip = std::uint64_t(*byte_skip);
    data.at_end = *byte_skip == -1;
    return Ok{};
}

Status find_data(const fs::path& path, const Lines& lines, DataPlace& data) {
    if (Status status = find_encoding(path, lines, data); !status) return status;
    if (Status status = find_skips(path, lines, data); !status) return status;
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

/// Whether numbers are stored as they are wanted. ITK moves the numbers of a voxel side by side
/// where they aren't.
void find_layout(const Lines& lines, ImageHeader& header) {
    const bool big = lower_case(lines.field("endian")) == "big";
    header.data.swapped =
        size_of(header.stored) > 1 && big != (std::endian::native == std::endian::big);
    const auto axes = split(lines.field("space directions"), ' ');
    const bool vectors_first = !axes.empty() && lower_case(axes[0]) == "none";
    header.data.plain =
        header.data.encoding != DataEncoding::Text && (header.components == 1 || vectors_first);
}

/// Whether vectors are measured along other axes than those of the space.
bool has_turned_vectors(const Lines& lines) {
    std::string frame(lines.field("measurement frame"));
    std::erase_if(frame, [](char c) { return c == ' ' || c == '\t'; });
    return !frame.empty() && frame != "(1,0,0)(0,1,0)(0,0,1)";
}

/// ITK sorts by key.
void sort_as_in_file(const Lines& lines, KeyValues& key_values) {
    const auto place = [&](const std::string& key) { return lines.keys.find('\n' + key + ":="); };
    std::stable_sort(key_values.begin(), key_values.end(),
                     [&](const auto& a, const auto& b) { return place(a.first) < place(b.first); });
}

}  // namespace

Result<ImageHeader> read_nrrd_header(const fs::path& path) {
    const auto lines = read_lines(path);
    if (!lines) return lines.error();
    ImageHeader header;
    header.format = ImageFormat::Nrrd;
    std::vector<std::int64_t> sizes;
    if (Status status = check_numbers(path, *lines, sizes); !status) return status.error();
    if (Status status = find_data(path, *lines, header.data); !status) return status.error();
    if (Status status = check_data_files(path, header.data); !status) return status.error();
    if (Status status = itk_read_header(path, header); !status) {
        const std::string& description = status.error().message;
        if (description.find("#independent axes") != description.npos && sizes.size() != 3)
            return check_size(path, sizes).error();
        return explained(path, *lines, description);
    }
    if (header.sizes.size() == 3)  // else it will be refused for that
        if (Status status = finish_grid(path, *lines, header); !status) return status.error();
    sort_as_in_file(*lines, header.key_values);
    header.stored = header.component;
    find_layout(*lines, header);
    header.turned_vectors = has_turned_vectors(*lines);
    return header;
}

}  // namespace pliant
