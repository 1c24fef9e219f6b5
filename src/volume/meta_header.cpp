// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// MetaImage: lines `Field = Value`, the last of which says where the data are. World coordinates
// are LPS, as everybody who writes the format takes them.

#include "volume/image_header.h"
#include "volume/text.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxHeaderBytes = 1 << 16;

struct Fields {
    std::map<std::string, std::string, std::less<>> values;
    KeyValues others;                       ///< fields that the format doesn't know
    std::vector<std::string> listed_files;  ///< after "ElementDataFile = LIST"
    std::size_t header_bytes = 0;

    /// Value of the first of these names that is there.
    std::string_view value(std::initializer_list<std::string_view> names) const {
        for (const std::string_view name : names)
            if (const auto found = values.find(name); found != values.end()) return found->second;
        return {};
    }
    bool is_true(std::string_view name) const {
        const std::string_view text = value({name});
        return !text.empty() && (text[0] == 'T' || text[0] == 't' || text[0] == '1');
    }
};

const std::set<std::string_view> kKnownFields = {"ObjectType",
                                                 "ObjectSubType",
                                                 "NDims",
                                                 "Name",
                                                 "ID",
                                                 "ParentID",
                                                 "Color",
                                                 "Comment",
                                                 "BinaryData",
                                                 "BinaryDataByteOrderMSB",
                                                 "ElementByteOrderMSB",
                                                 "CompressedData",
                                                 "CompressedDataSize",
                                                 "CompressionLevel",
                                                 "TransformMatrix",
                                                 "Rotation",
                                                 "Orientation",
                                                 "Offset",
                                                 "Position",
                                                 "Origin",
                                                 "CenterOfRotation",
                                                 "DistanceUnits",
                                                 "AnatomicalOrientation",
                                                 "ElementSpacing",
                                                 "ElementSize",
                                                 "DimSize",
                                                 "HeaderSize",
                                                 "ElementNumberOfChannels",
                                                 "ElementType",
                                                 "ElementMin",
                                                 "ElementMax",
                                                 "ElementToIntensityFunctionSlope",
                                                 "ElementToIntensityFunctionOffset",
                                                 "SequenceID",
                                                 "Modality",
                                                 "ElementDataFile"};

Error damaged(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unreadable, path.string() + ": " + message};
}
Error bad_field(const fs::path& path, const char* field, std::string_view found,
                const std::string& expected) {
    return damaged(path, std::string(field) + " is '" + shown(found) + "', expected " + expected);
}

Result<Fields> read_fields(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text(kMaxHeaderBytes, '\0');
    file.read(text.data(), std::streamsize(text.size()));
    text.resize(std::size_t(file.gcount()));
    Fields fields;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = trimmed(std::string_view(text).substr(at, end - at));
        at = std::min(end + 1, text.size());
        if (line.empty()) continue;
        const std::size_t equals = line.find_first_of("=:");
        if (equals == line.npos)
            return damaged(path, "header line '" + shown(line) + "' has no '='");
        const std::string name(trimmed(line.substr(0, equals)));
        const std::string value(trimmed(line.substr(equals + 1)));
        if (!kKnownFields.contains(name)) fields.others.emplace_back(name, value);
        fields.values[name] = value;
        if (name != "ElementDataFile") continue;
        fields.header_bytes = at;
        if (lower_case(value).starts_with("list"))
            for (const std::string_view listed : split(std::string_view(text).substr(at), '\n'))
                fields.listed_files.emplace_back(listed);
        return fields;
    }
    return damaged(path, "ends early: the header has no ElementDataFile");
}

Status read_component(const fs::path& path, const Fields& fields, ImageHeader& header) {
    static const std::map<std::string, Component, std::less<>> kTypes = {
        {"MET_CHAR", Component::Int8},       {"MET_UCHAR", Component::UInt8},
        {"MET_SHORT", Component::Int16},     {"MET_USHORT", Component::UInt16},
        {"MET_INT", Component::Int32},       {"MET_UINT", Component::UInt32},
        {"MET_LONG", Component::Int32},      {"MET_ULONG", Component::UInt32},
        {"MET_LONG_LONG", Component::Int64}, {"MET_ULONG_LONG", Component::UInt64},
        {"MET_FLOAT", Component::Float32},   {"MET_DOUBLE", Component::Float64}};
    std::string type(fields.value({"ElementType"}));
    constexpr std::string_view kArray = "_ARRAY";
    if (type.ends_with(kArray)) type.resize(type.size() - kArray.size());
    const auto found = kTypes.find(type);
    if (found == kTypes.end()) return bad_field(path, "ElementType", type, "MET_SHORT or the like");
    header.component = found->second;
    const std::string_view channels = fields.value({"ElementNumberOfChannels"});
    if (channels.empty()) return Ok{};
    const auto count = whole_number_from(channels);
    if (!count || *count < 1)
        return bad_field(path, "ElementNumberOfChannels", channels, "a number ≥ 1");
    header.components = *count;
    return Ok{};
}

Status read_sizes(const fs::path& path, const Fields& fields, ImageHeader& header) {
    const std::string_view text = fields.value({"DimSize"});
    for (const std::string_view word : split(text, ' ')) {
        const auto size = whole_number_from(word);
        if (!size) return bad_field(path, "DimSize", text, "whole numbers");
        header.sizes.push_back(*size);
    }
    const std::string_view dimension = fields.value({"NDims"});
    if (whole_number_from(dimension) != std::int64_t(header.sizes.size()))
        return bad_field(path, "DimSize", text,
                         "as many numbers as NDims (" + shown(dimension) + ")");
    return Ok{};
}

Status read_grid(const fs::path& path, const Fields& fields, ImageHeader& header) {
    const auto spacing_text = fields.value({"ElementSpacing", "ElementSize"});
    const auto spacing = numbers_from(spacing_text);
    if (!spacing_text.empty() && (!spacing || spacing->size() != 3))
        return bad_field(path, "ElementSpacing", spacing_text, "three numbers");
    if (spacing_text.empty()) header.notes.push_back("no ElementSpacing; taken as 1 mm");
    for (int a = 0; a < 3 && !spacing_text.empty(); ++a)
        header.grid.spacing_mm[a] = (*spacing)[std::size_t(a)];

    const auto origin_text = fields.value({"Offset", "Position", "Origin"});
    const auto origin = numbers_from(origin_text);
    if (!origin_text.empty() && (!origin || origin->size() != 3))
        return bad_field(path, "Offset", origin_text, "three numbers");
    if (origin_text.empty()) header.notes.push_back("no Offset; taken as (0, 0, 0)");
    for (int a = 0; a < 3 && !origin_text.empty(); ++a)
        header.grid.origin_mm[a] = (*origin)[std::size_t(a)];

    const auto matrix_text = fields.value({"TransformMatrix", "Rotation", "Orientation"});
    const auto matrix = numbers_from(matrix_text);
    if (!matrix_text.empty() && (!matrix || matrix->size() != 9))
        return bad_field(path, "TransformMatrix", matrix_text, "nine numbers");
    if (matrix_text.empty())
        header.notes.push_back("no TransformMatrix; the axes are taken as L, P, S");
    for (std::size_t n = 0; n < 9 && !matrix_text.empty(); ++n)
        header.grid.direction.columns[n / 3][int(n % 3)] = (*matrix)[n];
    for (Vec3d& axis : header.grid.direction.columns) {
        const double length = norm(axis);
        if (!(length > 0) || !std::isfinite(length))
            return bad_field(path, "TransformMatrix", matrix_text, "three directions");
        axis = (1 / length) * axis;
    }
    return Ok{};
}

void read_data_place(const fs::path& path, const Fields& fields, ImageHeader& header) {
    DataPlace& data = header.data;
    const std::string_view binary = fields.value({"BinaryData"});
    if (fields.is_true("CompressedData"))
        data.encoding = DataEncoding::Deflated;
    else if (!binary.empty() && !fields.is_true("BinaryData"))
        data.encoding = DataEncoding::Text;
    data.big_endian =
        fields.is_true("BinaryDataByteOrderMSB") || fields.is_true("ElementByteOrderMSB");
    const std::int64_t skip = whole_number_from(fields.value({"HeaderSize"})).value_or(0);
    data.at_the_end = skip < 0;
    data.byte_skip = skip > 0 ? std::uint64_t(skip) : 0;
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
    }
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

Result<ImageHeader> read_meta_header(const fs::path& path) {
    auto fields = read_fields(path);
    if (!fields) return fields.error();
    if (const auto type = fields->value({"ObjectType"}); !type.empty() && type != "Image")
        return bad_field(path, "ObjectType", type, "Image");
    ImageHeader header;
    header.format = ImageFormat::MetaImage;
    header.key_values = fields->others;
    if (Status status = read_component(path, *fields, header); !status) return status.error();
    if (Status status = read_sizes(path, *fields, header); !status) return status.error();
    if (header.sizes.size() == 3)  // else it will be refused for that
        if (Status status = read_grid(path, *fields, header); !status) return status.error();
    read_data_place(path, *fields, header);
    note_what_is_left_out(*fields, header);
    return header;
}

}  // namespace pliant
