// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// MetaImage: lines `Field = Value`, the last of which says where the data are. World coordinates
// are LPS, as everybody who writes the format takes them.

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

constexpr std::size_t kMaxMetaHeaderBytes = 1 << 16;

struct Fields {
    std::map<std::string, std::string, std::less<>> values;
    std::vector<std::string> names;         ///< in the file's order
    std::vector<std::string> listed_files;  ///< after "ElementDataFile = LIST"
    std::size_t header_bytes = 0;

    /// Value of the first of these names that is there.
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

/// Lines as they are, without empty ones at the end.
std::vector<std::string> lines_of(std::string_view text) {
    std::vector<std::string> lines(1);
    for (const char c : text) {
        if (c == '\n')
            lines.emplace_back();
        else
            lines.back() += c;
    }
    while (!lines.empty() && lines.back().empty()) lines.pop_back();
    return lines;
}

bool is_geometry(std::string_view name) {
    constexpr std::string_view kNames[] = {
        "NDims",    "DimSize", "ElementNumberOfChannels", "ElementSpacing", "ElementSize", "Offset",
        "Position", "Origin",  "TransformMatrix",         "Rotation",       "Orientation"};
    return std::find(std::begin(kNames), std::end(kNames), name) != std::end(kNames);
}

Result<Fields> read_fields(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text(kMaxMetaHeaderBytes, '\0');
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
            return unreadable(path, "header line '" + shown(line) + "' has no '='");
        const std::string name(trimmed(line.substr(0, equals)));
        const std::string value(trimmed(line.substr(equals + 1)));
        // ITK goes by the first one, and reads until memory ends where that is a negative NDims.
        if (fields.values.contains(name) && is_geometry(name))
            return unreadable(path, name + " is there twice, expected once");
        fields.names.push_back(name);
        fields.values[name] = value;
        if (name != "ElementDataFile") continue;
        fields.header_bytes = at;
        if (lower_case(value).starts_with("list")) fields.listed_files = lines_of(text.substr(at));
        return fields;
    }
    return unreadable(path, "ends early: the header has no ElementDataFile");
}

/// ITK takes no notice of a number that overflows, and little of one that is no number.
Status check_sizes(const fs::path& path, const Fields& fields) {
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
    return check_size(path, sizes);
}

Status check_geometry(const fs::path& path, const Fields& fields, ImageHeader& header) {
    const auto spacing_text = fields.value({"ElementSpacing", "ElementSize"});
    const auto spacing = numbers_from(spacing_text);
    if (!spacing_text.empty() && (!spacing || spacing->size() != 3))
        return bad_field(path, "ElementSpacing", spacing_text, "three numbers");
    if (spacing_text.empty()) header.notes.push_back("no ElementSpacing; taken as 1 mm");
    for (int a = 0; a < 3 && !spacing_text.empty(); ++a)
        if (Status status = check_spacing(path, a, (*spacing)[std::size_t(a)]); !status)
            return status;

    const auto origin_text = fields.value({"Offset", "Position", "Origin"});
    const auto origin = numbers_from(origin_text);
    if (!origin_text.empty() && (!origin || origin->size() != 3))
        return bad_field(path, "Offset", origin_text, "three numbers");
    if (origin_text.empty()) header.notes.push_back("no Offset; taken as (0, 0, 0)");
    if (!origin_text.empty())
        if (Status status = check_origin(path, {(*origin)[0], (*origin)[1], (*origin)[2]}); !status)
            return status;

    const auto matrix_text = fields.value({"TransformMatrix", "Rotation", "Orientation"});
    const auto matrix = numbers_from(matrix_text);
    if (!matrix_text.empty() && (!matrix || matrix->size() != 9))
        return bad_field(path, "TransformMatrix", matrix_text, "nine numbers");
    if (matrix_text.empty())
        header.notes.push_back("no TransformMatrix; the axes are taken as L, P, S");
    for (std::size_t n = 0; n < 9 && !matrix_text.empty(); n += 3) {
        const double length = norm(Vec3d{(*matrix)[n], (*matrix)[n + 1], (*matrix)[n + 2]});
        if (!(length > 0) || !std::isfinite(length))
            return bad_field(path, "TransformMatrix", matrix_text, "three directions");
    }
    return Ok{};
}

/// @returns whether there should be a file for each slice: ITK crashes where some are missing
bool find_data(const fs::path& path, const Fields& fields, DataPlace& data) {
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
    data.plain = data.encoding != DataEncoding::Text;
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
    return lower.starts_with("list") || name.find('%') != name.npos;
}

/// ITK crashes where words of several names aren't separated as it writes them.
Status check_names(const fs::path& path, const Fields& fields) {
    const std::string_view value = fields.value({"ElementDataFile"});
    bool sound = value.find("  ") == value.npos && value.find('\t') == value.npos;
    for (const std::string& name : fields.listed_files)
        sound = sound && name.find_first_of(" \t") == name.npos;
    if (sound) return Ok{};
    return bad_field(path, "ElementDataFile", value,
                     "names without blanks, and single blanks after them");
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
    const auto fields = read_fields(path);
    if (!fields) return fields.error();
    if (const auto type = fields->value({"ObjectType"}); !type.empty() && type != "Image")
        return bad_field(path, "ObjectType", type, "Image");
    ImageHeader header;
    header.format = ImageFormat::MetaImage;
    if (Status status = check_sizes(path, *fields); !status) return status.error();
    if (Status status = check_geometry(path, *fields, header); !status) return status.error();
    const bool one_a_slice = find_data(path, *fields, header.data);
    if (Status status = check_data_files(path, header.data); !status) return status.error();
    if (one_a_slice)
        if (Status status = check_names(path, *fields); !status) return status.error();
    if (Status status = itk_read_header(path, header); !status) {
        if (status.error().code == ErrorCode::Unsupported)
            return bad_field(path, "ElementType", fields->value({"ElementType"}),
                             "MET_SHORT or the like");
        return unreadable(path, "its header can't be read, expected a MetaImage's");
    }
    const auto count = std::int64_t(header.data.files.size());
    if (one_a_slice && count != header.sizes[2])
        return unreadable(path, "names " + std::to_string(count) + " data files, expected " +
                                    std::to_string(header.sizes[2]) + ", one for each slice");
    for (Vec3d& axis : header.grid.direction.columns) axis = normalized(axis);
    const auto place = [&](const std::string& key) {
        return std::find(fields->names.begin(), fields->names.end(), key);
    };
    std::stable_sort(header.key_values.begin(), header.key_values.end(),
                     [&](const auto& a, const auto& b) { return place(a.first) < place(b.first); });
    header.stored = header.component;
    note_what_is_left_out(*fields, header);
    return header;
}

}  // namespace pliant
