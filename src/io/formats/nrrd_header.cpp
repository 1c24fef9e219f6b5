// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Interpretation of a NRRD header's fields [Kindlmann2008]: axes of space, grid, and location of
// the data.

#include "base/errors.h"
#include "base/text.h"
#include "formats/data_check.h"
#include "formats/image_header.h"
#include "formats/nrrd_fields.h"

#include <algorithm>
#include <bit>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t kMaxAxes = 16;  // limit of the format

Vec3d in_space(const std::array<double, 4>& vector) {
    return {vector[0], vector[1], vector[2]};
}

/// The stored axes.
struct Axes {
    std::vector<std::int64_t> sizes;
    std::vector<std::size_t> domain;  ///< indices of the axes of space or time
};

Status read_sizes(const fs::path& path, const NrrdFields& fields, Axes& axes) {
    const std::string_view dimension = fields.field("dimension"), sizes = fields.field("sizes");
    const auto count = whole_number_from(dimension);
    if (!count || *count < 1 || *count > kMaxAxes)
        return bad_nrrd_field(path, "dimension", dimension, "1 to 16");
    for (const std::string_view text : split(sizes, ' ')) {
        const auto size = whole_number_from(text);
        if (!size) return bad_nrrd_field(path, "sizes", sizes, "whole numbers");
        axes.sizes.push_back(*size);
    }
    if (std::int64_t(axes.sizes.size()) != *count)
        return bad_nrrd_field(path, "sizes", sizes, "as many whole numbers as the dimension says");
    return check_counts(path, axes.sizes);
}

/// Index in axes.domain of the axis of time among four: the one of that kind or without a
/// direction in space, or the last one.
std::size_t time_axis(const NrrdFields& fields, std::size_t dimension, const Axes& axes) {
    const auto words = split(fields.field("kinds"), ' ');
    const auto vectors = nrrd_vectors_from(fields.field("space directions"), dimension);
    for (std::size_t n = 0; n < axes.domain.size(); ++n) {
        const std::size_t a = axes.domain[n];
        if (a < words.size() && lower_case(words[a]) == "time") return n;
        if (!vectors || vectors->size() != axes.sizes.size()) continue;
        const auto& vector = (*vectors)[a];
        if (!vector || (dimension == 4 && norm(in_space(*vector)) == 0)) return n;
    }
    return axes.domain.size() - 1;
}

/// Takes the axis of time of a 4-D image for its images.
void take_time(const NrrdFields& fields, std::size_t dimension, Axes& axes, ImageHeader& header) {
    const auto time = std::ptrdiff_t(time_axis(fields, dimension, axes));
    header.components = header.sizes[std::size_t(time)];
    header.has_frames = true;
    header.data.voxels_before_component = 1;
    for (std::ptrdiff_t n = 0; n < time; ++n)
        header.data.voxels_before_component *= std::uint64_t(header.sizes[std::size_t(n)]);
    header.sizes.erase(header.sizes.begin() + time);
    axes.domain.erase(axes.domain.begin() + time);
}

/// Classifies the axes: those of space and time, and at most one with the components of a voxel.
Status sort_axes(const fs::path& path, const NrrdFields& fields, std::size_t dimension, Axes& axes,
                 ImageHeader& header) {
    const std::string_view text = fields.field("kinds");
    const auto words = split(text, ' ');
    if (!text.empty() && words.size() != axes.sizes.size())
        return bad_nrrd_field(path, "kinds", text, "one word for each axis");
    int component_axes = 0;
    for (std::size_t a = 0; a < axes.sizes.size(); ++a) {
        const auto kind = text.empty() ? NrrdKind{} : nrrd_kind_from(words[a]);
        if (!kind) return bad_nrrd_field(path, "kinds", text, "kinds that the format has");
        if (kind->is_domain) {
            axes.domain.push_back(a);
            header.sizes.push_back(axes.sizes[a]);
            continue;
        }
        if (kind->size != 0 && kind->size != axes.sizes[a])
            return bad_nrrd_field(path, "kinds", text, "kinds that fit the sizes");
        if (++component_axes > 1)
            return unsupported(path, "has two axes of components, expected one");
        header.components = axes.sizes[a];
        header.is_list = lower_case(words[a]) == "list";  // sequences of 3D Slicer
        header.data.voxels_before_component = 1;
        for (const std::int64_t size : header.sizes)
            header.data.voxels_before_component *= std::uint64_t(size);
    }
    if (component_axes == 0 && axes.domain.size() == 4) take_time(fields, dimension, axes, header);
    while (header.sizes.size() < 3) header.sizes.push_back(1);
    return Ok{};
}

/// Millimetres per unit of "space units".
Result<double> millimetres_per_unit(const fs::path& path, std::string_view field,
                                    std::size_t dimension) {
    static const std::map<std::string, double, std::less<>> kUnits = {
        {"mm", 1},   {"millimeter", 1}, {"millimetre", 1},    {"", 1},
        {"???", 1},  {"um", 1e-3},      {"micrometer", 1e-3}, {"cm", 10},
        {"m", 1000}, {"meter", 1000},   {"microns", 1e-3}};
    if (field.empty()) return 1.0;
    auto words = quoted_words_from(field);
    if (!words || words->size() != dimension)
        return bad_nrrd_field(path, "space units", field, "\"mm\" for each axis");
    words->resize(std::min<std::size_t>(3, dimension));
    std::optional<double> scale;
    for (const std::string& unit : *words) {
        const auto found = kUnits.find(lower_case(unit));
        if (found == kUnits.end() || (scale && *scale != found->second))
            return bad_nrrd_field(path, "space units", field, "\"mm\" for each axis");
        scale = found->second;
    }
    return *scale;
}

/// Reads the space: named, or of two dimensions, three, or three and time.
Result<NrrdSpace> read_space(const fs::path& path, const NrrdFields& fields) {
    const std::string_view name = fields.field("space"),
                           dimension = fields.field("space dimension");
    if (!name.empty() && !dimension.empty())
        return bad_nrrd_field(path, "space dimension", dimension, "none beside a space");
    if (name.empty()) {
        const auto count = dimension.empty() ? 3 : whole_number_from(dimension);
        if (!count || *count < 2 || *count > 4)
            return bad_nrrd_field(path, "space dimension", dimension, "2, 3 or 4");
        return NrrdSpace{NrrdSpace::Unnamed, std::size_t(*count)};
    }
    const auto space = nrrd_space_from(name);
    if (!space)
        return bad_nrrd_field(path, "space", name, "left-posterior-superior or another 3-D space");
    return *space;
}

/// Moves the first voxel by the minimum of each axis, which is a border of cells unless the samples
/// are nodes, as ITK does.
Status place_by_mins(const fs::path& path, const NrrdFields& fields, const Axes& axes,
                     ImageHeader& header) {
    const std::string_view text = fields.field("axis mins");
    const auto mins = numbers_from(text);
    if (!mins || mins->size() != axes.sizes.size())
        return bad_nrrd_field(path, "axis mins", text, "a number for each axis");
    const auto centerings = split(fields.field("centerings"), ' ');
    Vec3d origin_mm{0, 0, 0};
    for (std::size_t a = 0; a < axes.domain.size(); ++a) {
        const std::size_t axis = axes.domain[a];
        if (!std::isfinite((*mins)[axis])) return Ok{};  // "nan": not known
        const bool is_node = axis < centerings.size() && lower_case(centerings[axis]) == "node";
        origin_mm[int(a)] = (*mins)[axis] + (is_node ? 0 : header.grid.spacing_mm[int(a)] / 2);
    }
    header.grid.origin_mm = origin_mm;
    return Ok{};
}

/// Places a grid that has at most spacings and minima.
Status place_by_spacings(const fs::path& path, const NrrdFields& fields, const Axes& axes,
                         ImageHeader& header) {
    const std::string_view text = fields.field("spacings");
    const auto spacings = numbers_from(text);
    if (!text.empty() && (!spacings || spacings->size() != axes.sizes.size()))
        return bad_nrrd_field(path, "spacings", text, "a number for each axis");
    for (std::size_t a = 0; a < axes.domain.size() && !text.empty(); ++a) {
        const double spacing_mm = (*spacings)[axes.domain[a]];
        if (Status status = check_spacing(path, int(a), spacing_mm); !status) return status;
        header.grid.spacing_mm[int(a)] = spacing_mm;
    }
    if (!fields.field("axis mins").empty() && !text.empty())
        if (Status status = place_by_mins(path, fields, axes, header); !status) return status;
    header.notes.push_back(std::string("no orientation; the axes are taken as L, P, S from (") +
                           text_of(header.grid.origin_mm) + ")");
    if (text.empty()) header.notes.push_back("no spacings; taken as 1 mm");
    return Ok{};
}

/// Signs that convert components to LPS.
Vec3d sign_of(NrrdSpace space) {
    if (space.axes == NrrdSpace::Ras) return {-1, -1, 1};
    if (space.axes == NrrdSpace::Las) return {1, -1, 1};
    return {1, 1, 1};
}

void note_space(const NrrdFields& fields, NrrdSpace space, ImageHeader& header) {
    if (space.axes == NrrdSpace::Ras || space.axes == NrrdSpace::Las)
        header.notes.push_back("converted from " +
                               std::string(space.axes == NrrdSpace::Ras ? "RAS" : "LAS") +
                               " to LPS");
    else if (space.axes == NrrdSpace::Unnamed)
        header.notes.push_back("no space is named; taken as LPS");
    else if (space.axes == NrrdSpace::Other)
        header.notes.push_back("space '" + shown(lower_case(fields.field("space"))) +
                               "' is taken as LPS");
}

/// Whether units, which belong to spacings, are consistent with directions in millimetres.
bool are_empty_or_mm(std::string_view units) {
    const auto words = quoted_words_from(units);
    return words && std::all_of(words->begin(), words->end(), [](const std::string& word) {
               return word.empty() || word == "???" || lower_case(word) == "mm";
           });
}

Status place_by_directions(const fs::path& path, const NrrdFields& fields, NrrdSpace space,
                           const Axes& axes, ImageHeader& header) {
    const std::string_view text = fields.field("space directions");
    const auto vectors = nrrd_vectors_from(text, space.dimension);
    const std::string a_vector = space.dimension == 2   ? "a vector (x,y)"
                                 : space.dimension == 3 ? "a vector (x,y,z)"
                                                        : "a vector (x,y,z,t)";
    const auto bad_directions = [&] {
        return bad_nrrd_field(path, "space directions", text, a_vector + " for each axis of space");
    };
    if (!vectors || vectors->size() != axes.sizes.size() ||
        (space.dimension == 2 && axes.domain.size() > 2))
        return bad_directions();
    if (space.axes == NrrdSpace::Unnamed && fields.field("space dimension").empty())
        return bad_nrrd_field(path, "space", "", "one for the space directions");
    if (!fields.field("spacings").empty())
        return unreadable(path, "spacings and space directions are both there, expected one");
    if (!are_empty_or_mm(fields.field("units")))
        return bad_nrrd_field(path, "units", fields.field("units"),
                              "space units beside space directions");
    Grid& grid = header.grid;
    const Vec3d sign = sign_of(space);
    const auto unit_mm = millimetres_per_unit(path, fields.field("space units"), space.dimension);
    if (!unit_mm) return unit_mm.error();
    for (std::size_t a = 0; a < axes.domain.size(); ++a) {
        const auto& vector = (*vectors)[axes.domain[a]];
        if (!vector) return bad_directions();
        if ((*vector)[3] != 0)
            return bad_nrrd_field(path, "space directions", text,
                                  "axes of space without a component of time");
        const Vec3d step = in_space(*vector);
        const double length = norm(step);
        if (length == 0)
            return bad_nrrd_field(path, "space directions", text,
                                  "vectors that are longer than zero");
        for (int row = 0; row < 3; ++row)
            grid.direction.columns[a][row] = sign[row] * ((1 / length) * step[row]);
        grid.spacing_mm[int(a)] = *unit_mm * length;
    }
    if (axes.domain.size() == 2)
        grid.direction.columns[2] =
            normalized(cross(grid.direction.columns[0], grid.direction.columns[1]));
    note_space(fields, space, header);
    header.vector_sign = sign;
    const std::string_view origin_text = fields.field("space origin");
    if (origin_text.empty()) {
        header.notes.push_back("no space origin; the first voxel is put at (0, 0, 0)");
        return Ok{};
    }
    const auto origin = nrrd_vectors_from(origin_text, space.dimension);
    if (!origin || origin->size() != 1 || !(*origin)[0])
        return bad_nrrd_field(path, "space origin", origin_text, a_vector);
    for (int row = 0; row < 3; ++row)
        grid.origin_mm[row] = *unit_mm * (sign[row] * (*(*origin)[0])[std::size_t(row)]);
    return Ok{};
}

Status place_grid(const fs::path& path, const NrrdFields& fields, NrrdSpace space, const Axes& axes,
                  ImageHeader& header) {
    if (axes.domain.size() > 3) return Ok{};  // refused later
    if (!fields.field("space directions").empty())
        return place_by_directions(path, fields, space, axes, header);
    if (space.axes != NrrdSpace::Unnamed && !fields.field("spacings").empty())
        return bad_nrrd_field(path, "space directions", "", "a vector (x,y,z) for each axis");
    return place_by_spacings(path, fields, axes, header);
}

Status find_encoding(const fs::path& path, const NrrdFields& fields, DataLocation& data) {
    const std::string encoding = lower_case(fields.field("encoding"));
    if (encoding == "raw") {
        data.encoding = DataEncoding::Raw;
    } else if (encoding == "gz" || encoding == "gzip") {
        data.encoding = DataEncoding::Deflated;
    } else if (encoding == "txt" || encoding == "text" || encoding == "ascii") {
        data.encoding = DataEncoding::Text;
    } else {
        return unsupported(path,
                           "encoding is '" + shown(encoding) + "', expected raw, gzip or text");
    }
    return Ok{};
}

Status find_skips(const fs::path& path, const NrrdFields& fields, DataLocation& data) {
    const std::string_view line_text = fields.field("line skip");
    const std::string_view byte_text = fields.field("byte skip");
    const auto line_skip = line_text.empty() ? 0 : whole_number_from(line_text);
    const auto byte_skip = byte_text.empty() ? 0 : whole_number_from(byte_text);
    if (!line_skip || *line_skip < 0)
        return bad_nrrd_field(path, "line skip", line_text, "a number ≥ 0");
    const bool text = data.encoding == DataEncoding::Text;
    if (!byte_skip || *byte_skip < (text ? 0 : -1))
        return bad_nrrd_field(path, "byte skip", byte_text,
                              text ? "a number ≥ 0" : "a number ≥ -1");
    data.line_skip = *line_skip;
    data.at_end = *byte_skip == -1;
    const auto skipped = std::uint64_t(std::max<std::int64_t>(0, *byte_skip));
    (data.encoding == DataEncoding::Deflated ? data.inner_skip : data.byte_skip) = skipped;
    return Ok{};
}

/// Number of data files: one for each part of the dimension given by the last word, or for parts of
/// one dimension less than the image. Slabs of the whole dimension have equal sizes.
Status find_file_count(const fs::path& path, const Axes& axes, std::string_view dimension,
                       DataLocation& data) {
    const auto count = std::int64_t(axes.sizes.size());
    const auto given = dimension.empty() ? count - 1 : whole_number_from(dimension);
    if (!given || *given < (dimension.empty() ? 0 : 1) || *given > count)
        return bad_nrrd_field(path, "data file's dimension", dimension,
                              "1 to " + std::to_string(count));
    if (*given == count) return Ok{};
    data.expected_files = 1;
    for (std::int64_t a = *given; a < count; ++a) data.expected_files *= axes.sizes[std::size_t(a)];
    return Ok{};
}

Status find_data(const fs::path& path, const NrrdFields& fields, const Axes& axes,
                 DataLocation& data) {
    if (Status status = find_encoding(path, fields, data); !status) return status;
    if (Status status = find_skips(path, fields, data); !status) return status;
    const std::string_view name = fields.field("data file");
    const fs::path folder = path.parent_path();
    if (name.empty()) {
        data.files = {path};
        data.start = fields.header_bytes;
        return Ok{};
    }
    const auto words = split(name, ' ');
    if (lower_case(name).starts_with("list")) {
        for (const std::string& file : fields.listed_files) data.files.push_back(folder / file);
        return find_file_count(path, axes, words.size() > 1 ? words[1] : "", data);
    }
    if (name.find('%') != name.npos) {
        for (const std::string& file : numbered_names(name)) data.files.push_back(folder / file);
        return find_file_count(path, axes, words.size() > 4 ? words[4] : "", data);
    }
    data.files = {folder / fs::path(name)};
    return Ok{};
}

Status read_type(const fs::path& path, const NrrdFields& fields, ImageHeader& header) {
    const auto type = nrrd_type_from(fields.field("type"));
    if (!type) return bad_nrrd_field(path, "type", fields.field("type"), "a type of number");
    header.stored = *type;
    const std::string endian = lower_case(fields.field("endian"));
    const bool matters = size_of(*type) > 1 && header.data.encoding != DataEncoding::Text;
    if (endian != "little" && endian != "big" && (matters || !endian.empty()))
        return bad_nrrd_field(path, "endian", endian, "little or big");
    header.data.swapped =
        size_of(*type) > 1 && (endian == "big") != (std::endian::native == std::endian::big);
    return Ok{};
}

/// Whether vectors have a measurement frame other than the axes of the space.
Status find_frame(const fs::path& path, const NrrdFields& fields, std::size_t dimension,
                  ImageHeader& header) {
    const std::string_view text = fields.field("measurement frame");
    if (text.empty()) return Ok{};
    const auto frame = nrrd_vectors_from(text, dimension);
    if (!frame || frame->size() != dimension)
        return bad_nrrd_field(
            path, "measurement frame", text,
            dimension == 3 ? "three vectors (x,y,z)" : "as many vectors as the space has axes");
    for (std::size_t a = 0; a < dimension; ++a)
        for (std::size_t b = 0; b < dimension; ++b)
            if (!(*frame)[a] || (*(*frame)[a])[b] != (a == b ? 1 : 0)) header.turned_vectors = true;
    return Ok{};
}

}  // namespace

Result<ImageHeader> read_nrrd_header(const fs::path& path) {
    auto fields = read_nrrd_fields(path);
    if (!fields) return fields.error();
    ImageHeader header;
    header.format = ImageFormat::Nrrd;
    Axes axes;
    if (Status status = read_sizes(path, *fields, axes); !status) return status.error();
    if (Status status = find_data(path, *fields, axes, header.data); !status) return status.error();
    if (Status status = read_type(path, *fields, header); !status) return status.error();
    const auto space = read_space(path, *fields);
    if (!space) return space.error();
    if (Status status = sort_axes(path, *fields, space->dimension, axes, header); !status)
        return status.error();
    if (Status status = place_grid(path, *fields, *space, axes, header); !status)
        return status.error();
    if (Status status = find_frame(path, *fields, space->dimension, header); !status)
        return status.error();
    header.key_values = std::move(fields->key_values);
    return header;
}

}  // namespace pliant
