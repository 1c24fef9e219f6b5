// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// MetaImage [MetaIO2007]: lines `Field = Value`; the last one locates the data. World coordinates
// are LPS, as in all known writers.

#include "base/errors.h"
#include "base/text.h"
#include "formats/data_check.h"
#include "formats/header_lines.h"
#include "formats/image_header.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <span>

namespace pliant {
namespace fs = std::filesystem;
namespace {

struct Fields {
    std::map<std::string, std::string, std::less<>> values;
    KeyValues others;                       ///< fields outside of the format, in the file's order
    std::vector<std::string> listed_files;  ///< after "ElementDataFile = LIST"
    std::uint64_t header_bytes = 0;

    /// Value of the first present name.
    std::string_view value(std::initializer_list<std::string_view> some) const {
        for (const std::string_view name : some)
            if (const auto found = values.find(name); found != values.end()) return found->second;
        return {};
    }
    bool is_true(std::string_view name) const {
        const std::string_view text = value({name});
        return !text.empty() && (text[0] == 'T' || text[0] == 't' || text[0] == '1');
    }
};

Error bad_field(const fs::path& path, const char* field, std::string_view found,
                const std::string& expected) {
    return unreadable(path,
                      std::string(field) + " is '" + shown(found) + "', expected " + expected);
}

bool is_one_of(std::string_view name, std::span<const std::string_view> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_geometry(std::string_view name) {
    constexpr std::string_view kNames[] = {
        "NDims",          "DimSize",     "ElementNumberOfChannels",
        "ElementSpacing", "ElementSize", "Offset",
        "Position",       "Origin",      "ImagePosition",
        "Rotation",       "Orientation", "TransformMatrix"};
    return is_one_of(name, kNames);
}

/// Fields of the format that don't affect grid or data.
bool is_remark(std::string_view name) {
    constexpr std::string_view kNames[] = {"Comment",
                                           "ObjectType",
                                           "ObjectSubType",
                                           "Name",
                                           "ID",
                                           "ParentID",
                                           "Color",
                                           "AcquisitionDate",
                                           "CenterOfRotation",
                                           "Modality",
                                           "SequenceID",
                                           "ElementMin",
                                           "ElementMax",
                                           "ElementNBits",
                                           "BinaryData",
                                           "DistanceUnits",
                                           "HeaderSize",
                                           "CompressedData",
                                           "AnatomicalOrientation",
                                           "ElementType",
                                           "ElementByteOrderMSB",
                                           "BinaryDataByteOrderMSB",
                                           "CompressedDataSize",
                                           "ElementDataFile",
                                           "ElementToIntensityFunctionSlope",
                                           "ElementToIntensityFunctionOffset"};
    return is_one_of(name, kNames);
}

/// Reads names of data files, one per line, to the end of the header.
Status read_listed_files(HeaderLines& lines, Fields& fields) {
    for (;;) {
        auto line = lines.next();
        if (!line) return line.error();
        if (!*line) break;
        fields.listed_files.emplace_back(trimmed(**line));
    }
    auto& files = fields.listed_files;
    while (!files.empty() && files.back().empty()) files.pop_back();
    return Ok{};
}

Result<Fields> read_fields(const fs::path& path) {
    HeaderLines lines(path);
    Fields fields;
    std::map<std::string, std::size_t> positions;  // positions in others
    for (;;) {
        auto text = lines.next();
        if (!text) return text.error();
        if (!*text) return unreadable(path, "ends early: the header has no ElementDataFile");
        const std::string_view line = trimmed(**text);
        if (line.empty()) continue;
        const std::size_t equals = line.find_first_of("=:");
        if (equals == line.npos)
            return unreadable(path, "header line '" + shown(line) + "' has no '='");
        const std::string name(trimmed(line.substr(0, equals)));
        const std::string_view rest = line.substr(equals);
        const std::string value(
            rest.substr(std::min(rest.find_first_not_of("=: \t"), rest.size())));
        if (fields.values.contains(name) && is_geometry(name))
            return unreadable(path, name + " is there twice, expected once");
        if (is_geometry(name) || is_remark(name)) {
            fields.values[name] = value;
        } else if (!name.empty() && !is_itk_key(name)) {
            const auto [at, is_new] = positions.emplace(name, fields.others.size());
            if (is_new)
                fields.others.emplace_back(name, value);
            else
                fields.others[at->second].second = value;
        }
        if (positions.size() > kMaxKeyValues)
            return unreadable(path, "has more than " + std::to_string(kMaxKeyValues) + " keys");
        if (name != "ElementDataFile") continue;
        fields.header_bytes = lines.bytes_read();
        if (lower_case(value).starts_with("list"))
            if (Status status = read_listed_files(lines, fields); !status) return status.error();
        return fields;
    }
}

Status read_sizes(const fs::path& path, const Fields& fields, ImageHeader& header) {
    const std::string_view text = fields.value({"DimSize"});
    std::vector<std::int64_t> sizes;
    for (const std::string_view word : split(text, ' ')) {
        const auto size = whole_number_from(word);
        if (!size) return bad_field(path, "DimSize", text, "whole numbers");
        sizes.push_back(*size);
    }
    const std::string_view dimension = fields.value({"NDims"});
    if (whole_number_from(dimension) != std::int64_t(sizes.size()))
        return bad_field(path, "DimSize", text,
                         "as many numbers as NDims (" + shown(dimension) + ")");
    const std::string_view channels = fields.value({"ElementNumberOfChannels"});
    if (const auto count = whole_number_from(channels);
        !channels.empty() && (!count || *count < 1 || *count > kMaxAxisSize))
        return bad_field(path, "ElementNumberOfChannels", channels, "a number ≥ 1");
    else if (count)
        header.components = *count;
    header.sizes = sizes;
    if (Status status = check_counts(path, sizes); !status) return status;
    take_axes(header);
    return check_size(path, header.sizes);
}

/// NDims, of a header whose sizes are read.
std::size_t axis_count(const Fields& fields) {
    return split(fields.value({"DimSize"}), ' ').size();
}

Status read_type(const fs::path& path, const Fields& fields, ImageHeader& header) {
    // MET_LONG has 32 bits on every machine.
    static const std::map<std::string, Component, std::less<>> kTypes = {
        {"MET_CHAR", Component::Int8},         {"MET_ASCII_CHAR", Component::Int8},
        {"MET_UCHAR", Component::UInt8},       {"MET_SHORT", Component::Int16},
        {"MET_USHORT", Component::UInt16},     {"MET_INT", Component::Int32},
        {"MET_LONG", Component::Int32},        {"MET_UINT", Component::UInt32},
        {"MET_ULONG", Component::UInt32},      {"MET_LONG_LONG", Component::Int64},
        {"MET_ULONG_LONG", Component::UInt64}, {"MET_FLOAT", Component::Float32},
        {"MET_DOUBLE", Component::Float64}};
    const std::string_view name = fields.value({"ElementType"});
    std::string_view single = name;  // some writers use MET_SHORT_ARRAY for channels
    if (single.ends_with("_ARRAY")) single.remove_suffix(6);
    const auto found = kTypes.find(single);
    if (found == kTypes.end()) return bad_field(path, "ElementType", name, "MET_SHORT or the like");
    header.stored = found->second;
    return Ok{};
}

Status read_spacing(const fs::path& path, const Fields& fields, ImageHeader& header) {
    const auto text = fields.value({"ElementSpacing", "ElementSize"});
    if (text.empty()) {
        header.notes.push_back("no ElementSpacing; taken as 1 mm");
        return Ok{};
    }
    const auto spacing = numbers_from(text);
    const std::size_t axes = axis_count(fields);
    if (!spacing || spacing->size() != axes)
        return bad_field(path, "ElementSpacing", text,
                         axes == 3 ? "three numbers" : std::to_string(axes) + " numbers");
    for (int a = 0; a < int(std::min<std::size_t>(3, axes)); ++a) {
        header.grid.spacing_mm[a] = std::abs((*spacing)[std::size_t(a)]);
        if (Status status = check_spacing(path, a, header.grid.spacing_mm[a]); !status)
            return status;
    }
    return Ok{};
}

Status read_placement(const fs::path& path, const Fields& fields, ImageHeader& header) {
    // The first present field counts.
    const auto origin_text = fields.value({"ImagePosition", "Origin", "Offset", "Position"});
    const auto origin = numbers_from(origin_text);
    const std::size_t axes = axis_count(fields), used = std::min<std::size_t>(3, axes);
    if (!origin_text.empty() && (!origin || origin->size() != axes))
        return bad_field(path, "Offset", origin_text,
                         axes == 3 ? "three numbers" : std::to_string(axes) + " numbers");
    if (origin_text.empty()) header.notes.push_back("no Offset; taken as (0, 0, 0)");
    for (std::size_t a = 0; a < used && origin; ++a)
        if (!origin_text.empty()) header.grid.origin_mm[int(a)] = (*origin)[a];
    if (Status status = check_origin(path, header.grid.origin_mm); !status) return status;

    const auto matrix_text = fields.value({"TransformMatrix", "Rotation", "Orientation"});
    const auto matrix = numbers_from(matrix_text);
    if (!matrix_text.empty() && (!matrix || matrix->size() != axes * axes))
        return bad_field(path, "TransformMatrix", matrix_text,
                         axes == 3 ? "nine numbers" : std::to_string(axes * axes) + " numbers");
    if (matrix_text.empty())
        header.notes.push_back("no TransformMatrix; the axes are taken as L, P, S");
    for (std::size_t a = 0; a < used && !matrix_text.empty(); ++a) {
        Vec3d axis{};
        for (std::size_t row = 0; row < used; ++row) axis[int(row)] = (*matrix)[axes * a + row];
        if (!(norm(axis) > 0) || !std::isfinite(norm(axis)))
            return bad_field(path, "TransformMatrix", matrix_text, "three directions");
        header.grid.direction.columns[a] = axis;
    }
    const auto spacing = numbers_from(fields.value({"ElementSpacing", "ElementSize"}));
    for (std::size_t a = 0; a < 3; ++a) {
        Vec3d& axis = header.grid.direction.columns[a];
        axis = normalized(axis);
        if (a >= used || !spacing || a >= spacing->size() || (*spacing)[a] >= 0) continue;
        axis = -1.0 * axis;  // as ITK does
        header.notes.push_back("spacing of axis " + std::to_string(a + 1) +
                               " is negative; the axis points the other way");
    }
    return Ok{};
}

void find_data(const fs::path& path, const Fields& fields, ImageHeader& header) {
    DataLocation& data = header.data;
    const std::string_view binary = fields.value({"BinaryData"});
    if (fields.is_true("CompressedData"))
        data.encoding = DataEncoding::Deflated;
    else if (!binary.empty() && !fields.is_true("BinaryData"))
        data.encoding = DataEncoding::Text;
    const std::int64_t skip = whole_number_from(fields.value({"HeaderSize"})).value_or(0);
    data.byte_skip = skip > 0 ? std::uint64_t(skip) : 0;
    data.at_end = skip == -1;
    const bool big =
        fields.is_true("BinaryDataByteOrderMSB") || fields.is_true("ElementByteOrderMSB");
    data.swapped = big != (std::endian::native == std::endian::big);
    const std::string_view name = fields.value({"ElementDataFile"});
    const std::string lower = lower_case(name);
    const fs::path folder = path.parent_path();
    if (lower == "local") {
        data.files = {path};
        if (data.byte_skip == 0) data.start = fields.header_bytes;
    } else if (lower.starts_with("list")) {
        for (const std::string& file : fields.listed_files) data.files.push_back(folder / file);
    } else if (name.find('%') != name.npos) {
        for (const std::string& file : numbered_names(name)) data.files.push_back(folder / file);
    } else {
        data.files = {folder / fs::path(name)};
        return;
    }
    if (lower != "local")  // one per slice
        data.expected_files = header.sizes[2] * (header.has_frames ? header.components : 1);
}

void note_what_is_left_out(const Fields& fields, ImageHeader& header) {
    const auto differs = [&](const char* name, double plain) {
        const std::string_view text = fields.value({name});
        return !text.empty() && number_from(text) != plain;
    };
    if (differs("ElementToIntensityFunctionSlope", 1) ||
        differs("ElementToIntensityFunctionOffset", 0))
        header.notes.push_back("ElementToIntensityFunction is not applied");
}

}  // namespace

bool is_meta_field(std::string_view name) {
    return is_geometry(name) || is_remark(name);
}

Result<ImageHeader> read_meta_header(const fs::path& path) {
    auto fields = read_fields(path);
    if (!fields) return fields.error();
    if (const auto type = fields->value({"ObjectType"}); !type.empty() && type != "Image")
        return bad_field(path, "ObjectType", type, "Image");
    ImageHeader header;
    header.format = ImageFormat::MetaImage;
    if (Status status = read_sizes(path, *fields, header); !status) return status.error();
    if (Status status = read_type(path, *fields, header); !status) return status.error();
    if (Status status = read_spacing(path, *fields, header); !status) return status.error();
    if (Status status = read_placement(path, *fields, header); !status) return status.error();
    find_data(path, *fields, header);
    header.key_values = std::move(fields->others);
    note_what_is_left_out(*fields, header);
    return header;
}

}  // namespace pliant
