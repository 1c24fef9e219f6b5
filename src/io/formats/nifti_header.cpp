// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NIfTI [NIfTI2007]: 348 bytes of binary header, 540 with doubles in version 2, plain or inside
// gzip. The world is RAS. A file may have two affine maps, "sform" and "qform": as in nibabel, the
// sform counts if there is one, whatever the qform says.

#include "base/errors.h"
#include "base/text.h"
#include "formats/data_check.h"
#include "formats/image_header.h"
#include "formats/inflated_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kHeaderBytes = 348, kHeaderBytes2 = 540;
/// Tolerance of positions due to rounding to 32-bit floats [mm].
constexpr double kSamePositionMm = 0.01;

/// The header's bytes with typed access by offset.
struct HeaderBytes {
    std::array<unsigned char, kHeaderBytes2> bytes{};
    bool swapped = false;

    template <class T>
    T get(std::size_t offset) const {
        std::array<unsigned char, sizeof(T)> piece;
        for (std::size_t i = 0; i < sizeof(T); ++i)
            piece[i] = bytes[offset + (swapped ? sizeof(T) - 1 - i : i)];
        T value;
        std::memcpy(&value, piece.data(), sizeof(T));
        return value;
    }
    /// Reads consecutive numbers.
    template <class T, class To, std::size_t N>
    void get_all(std::size_t offset, std::array<To, N>& out) const {
        for (std::size_t n = 0; n < N; ++n) out[n] = To(get<T>(offset + n * sizeof(T)));
    }
};

/// The fields in use, of either version.
struct NiftiFields {
    int version = 1;
    bool swapped = false;
    int datatype = 0, intent = 0, units = 0, qform_code = 0, sform_code = 0;
    std::array<std::int64_t, 8> dim{};
    std::array<double, 8> pixdim{};
    bool deflated = false;
    double vox_offset = 0, slope = 0, intercept = 0;
    std::array<double, 6> qform{};  ///< quaternion's b, c, d, and offset
    std::array<double, 12> srow{};
};

NiftiFields fields_1(const HeaderBytes& bytes) {
    NiftiFields f;
    f.intent = bytes.get<std::int16_t>(68);
    f.datatype = bytes.get<std::int16_t>(70);
    f.units = bytes.bytes[123];
    f.qform_code = bytes.get<std::int16_t>(252);
    f.sform_code = bytes.get<std::int16_t>(254);
    bytes.get_all<std::int16_t>(40, f.dim);
    bytes.get_all<float>(76, f.pixdim);
    f.vox_offset = double(bytes.get<float>(108));
    f.slope = double(bytes.get<float>(112));
    f.intercept = double(bytes.get<float>(116));
    bytes.get_all<float>(256, f.qform);
    bytes.get_all<float>(280, f.srow);
    return f;
}

NiftiFields fields_2(const HeaderBytes& bytes) {
    NiftiFields f;
    f.version = 2;
    f.datatype = bytes.get<std::int16_t>(12);
    bytes.get_all<std::int64_t>(16, f.dim);
    bytes.get_all<double>(104, f.pixdim);
    f.vox_offset = double(bytes.get<std::int64_t>(168));
    f.slope = bytes.get<double>(176);
    f.intercept = bytes.get<double>(184);
    f.qform_code = bytes.get<std::int32_t>(344);
    f.sform_code = bytes.get<std::int32_t>(348);
    bytes.get_all<double>(352, f.qform);
    bytes.get_all<double>(400, f.srow);
    f.units = bytes.get<std::int32_t>(500) & 255;
    f.intent = bytes.get<std::int32_t>(504);
    return f;
}

/// Reads the first bytes, of gzip's content if it is gzip; fewer at the end of the file.
/// @param[out] deflated  whether it is gzip, whatever the file's name
Result<std::size_t> read_start(const fs::path& path, std::span<unsigned char> bytes,
                               bool& deflated) {
    InputFile file(path);
    std::size_t count = file.read(bytes.data(), bytes.size());
    if (Status status = file.status(); !status) return status.error();
    deflated = count >= 2 && bytes[0] == 0x1f && bytes[1] == 0x8b;
    if (!deflated) return count;
    InflatedFile inflated(path, path, 0);
    for (count = 0; count < bytes.size();) {
        const auto more = inflated.read_some(std::as_writable_bytes(bytes).subspan(count));
        if (Status status = inflated.status(); !status) return status.error();
        if (!more) break;  // cut off, or damaged
        count += *more;
    }
    return count;
}

/// Whether a file is the header of a pair, by its name.
bool is_header_of_pair(const fs::path& path) {
    const std::string name = lower_case(path.filename().string());
    return name.ends_with(".hdr") || name.ends_with(".hdr.gz");
}

/// The data file beside a pair's header: a.img, or a.img.gz of a compressed header.
fs::path data_of_pair(const fs::path& header) {
    std::string name = header.filename().string();
    const std::size_t at = lower_case(name).rfind(".hdr") + 1;
    name.replace(at, 3, name[at] == 'H' ? "IMG" : "img");
    return header.parent_path() / name;
}

Result<NiftiFields> read_nifti_fields(const fs::path& path) {
    HeaderBytes header;
    bool deflated = false;
    const auto read = read_start(path, header.bytes, deflated);
    if (!read) return read.error();
    const std::size_t count = *read;
    const auto ends_early = [&](std::size_t expected) {
        return unreadable(path, "is damaged or ends early: expected " + std::to_string(expected) +
                                    " bytes of NIfTI header");
    };
    if (count < kHeaderBytes) return ends_early(kHeaderBytes);
    const auto size = header.get<std::int32_t>(0);
    header.swapped = true;
    const auto swapped_size = header.get<std::int32_t>(0);
    const auto is_size = [](std::int32_t n) {
        return n == std::int32_t(kHeaderBytes) || n == std::int32_t(kHeaderBytes2);
    };
    header.swapped = !is_size(size);
    if (!is_size(size) && !is_size(swapped_size))
        return unreadable(path, "is no NIfTI file: sizeof_hdr is " + std::to_string(size) +
                                    ", expected 348 or 540");
    const bool second = (header.swapped ? swapped_size : size) == std::int32_t(kHeaderBytes2);
    if (second && count < kHeaderBytes2) return ends_early(kHeaderBytes2);
    const auto* const start = reinterpret_cast<const char*>(&header.bytes[second ? 4 : 344]);
    const bool is_pair = is_header_of_pair(path);
    const std::string_view magic(start, 3), expected = is_pair  ? second ? "ni2" : "ni1"
                                                       : second ? "n+2"
                                                                : "n+1";
    if (!is_pair && (magic == "ni1" || magic == "ni2"))
        return unsupported(path,
                           "is the header of a NIfTI pair, expected a name that ends in .hdr");
    if (is_pair && !second && magic == std::string_view("\0\0\0", 3))
        return unsupported(path,
                           "is an ANALYZE header, which doesn't tell left from right, expected "
                           "NIfTI (\"ni1\")");
    if (magic != expected)
        return unreadable(path, "magic is '" + shown(magic) + "', expected '" +
                                    std::string(expected) + "' (NIfTI-" + (second ? "2" : "1") +
                                    ")");
    NiftiFields fields = second ? fields_2(header) : fields_1(header);
    fields.swapped = header.swapped;
    fields.deflated = deflated;
    return fields;
}

Status read_type_and_sizes(const fs::path& path, const NiftiFields& fields, ImageHeader& header) {
    static const std::map<int, Component> kTypes = {
        {256, Component::Int8},   {2, Component::UInt8},     {4, Component::Int16},
        {512, Component::UInt16}, {8, Component::Int32},     {768, Component::UInt32},
        {1024, Component::Int64}, {1280, Component::UInt64}, {16, Component::Float32},
        {64, Component::Float64}};
    const int type = fields.datatype;
    const auto found = kTypes.find(type);
    if (found == kTypes.end()) {
        const char* what = type == 128 || type == 2304  ? " (colour)"
                           : type == 32 || type == 1792 ? " (complex)"
                                                        : "";
        return unsupported(path, "datatype is " + std::to_string(type) + what +
                                     ", expected integers, float or double");
    }
    header.stored = found->second;
    const std::int64_t dimension = fields.dim[0];
    if (dimension < 1 || dimension > 7)
        return unreadable(path, "dim[0] is " + std::to_string(dimension) + ", expected 1 to 7");
    header.sizes.assign(fields.dim.begin() + 1, fields.dim.begin() + 1 + dimension);
    for (std::size_t a = 3; a < header.sizes.size(); ++a) {
        if (header.sizes[a] != 0) continue;
        header.sizes[a] = 1;
        header.notes.push_back("dim[" + std::to_string(a + 1) + "] is 0, taken as 1");
    }
    if (header.sizes.size() == 5 && header.sizes[3] == 1 && header.sizes[4] > 1) {
        header.components = header.sizes[4];
        header.sizes.resize(3);
    }
    if (Status status = check_counts(path, header.sizes); !status) return status;
    take_axes(header);
    return Ok{};
}

double millimetres_per_unit(const NiftiFields& fields) {
    switch (fields.units & 7) {
        case 1:
            return 1000;
        case 3:
            return 1e-3;
        default:
            return 1;
    }
}

/// The sform in LPS [mm]: steps to the next voxel along i, j and k, then the first voxel's
/// position.
std::array<Vec3d, 4> sform_in_mm(const NiftiFields& fields) {
    std::array<Vec3d, 4> columns;
    for (std::size_t c = 0; c < 4; ++c)
        columns[c] = millimetres_per_unit(fields) *
                     Vec3d{-fields.srow[c], -fields.srow[4 + c], fields.srow[8 + c]};
    return columns;
}

Status check_geometry(const fs::path& path, const NiftiFields& fields) {
    const bool has_sform = fields.sform_code > 0;
    const auto sform = sform_in_mm(fields);
    for (std::size_t a = 0; a < 3; ++a) {
        if (has_sform && (!is_finite(sform[a]) || norm(sform[a]) == 0))
            return unreadable(
                path, "sform has the axis (" + text_of(sform[a]) + "), expected a direction");
        const double steps[] = {fields.pixdim[1 + a], norm(sform[a])};
        for (const double step : std::span(steps, has_sform ? 2 : 1))
            if (Status status = check_spacing(path, int(a), step); !status) return status;
    }
    if (has_sform)
        if (Status status = check_origin(path, sform[3]); !status) return status;
    for (std::size_t n = 0; n < 6 && fields.qform_code > 0; ++n)
        if (const double number = fields.qform[n];
            !(std::abs(number) <= (n < 3 ? 1.01 : kMaxOriginMm)))
            return unreadable(
                path, "qform has " + text_of(number) + ", expected a rotation and a position");
    return Ok{};
}

double pixdim_in_mm(const NiftiFields& fields, int axis) {
    return fields.pixdim[1 + std::size_t(axis)] * millimetres_per_unit(fields);
}

/// Uses the sform, whose axes have the spacings; pixdim has them without the rounding of the axes.
/// check_grid detects shear.
void take_sform(const NiftiFields& fields, Grid& grid) {
    constexpr double kRounding = 1e-6;
    const auto sform = sform_in_mm(fields);
    for (int a = 0; a < 3; ++a) {
        const double length = norm(sform[std::size_t(a)]), pixdim = pixdim_in_mm(fields, a);
        grid.spacing_mm[a] = std::abs(length - pixdim) <= kRounding * pixdim ? pixdim : length;
        grid.direction.columns[a] = (1 / length) * sform[std::size_t(a)];
    }
    grid.origin_mm = sform[3];
}

/// Uses the qform, in double precision.
void take_qform(const NiftiFields& fields, Grid& grid) {
    const auto& q = fields.qform;
    const double b = q[0], c = q[1], d = q[2], squares = b * b + c * c + d * d;
    // Rounding to float moves the squares of a half turn by up to 1e-7: NIfTI's own library takes
    // anything shorter, or longer, for a half turn about its axis.
    const bool half_turn = 1 - squares < 1e-7;
    const double a = half_turn ? 0 : std::sqrt(1 - squares);
    const double scale = half_turn ? 1 / squares : 1;
    const auto turned = [&](Vec3d v) {
        const Vec3d u{b, c, d};
        return scale * ((a * a - squares) * v + 2 * dot(u, v) * u + 2 * a * cross(u, v));
    };
    const Vec3d axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, fields.pixdim[0] < 0 ? -1.0 : 1.0}};
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3d axis = turned(axes[i]);
        grid.direction.columns[i] = {-axis.x, -axis.y, axis.z};
    }
    grid.origin_mm = millimetres_per_unit(fields) * Vec3d{-q[3], -q[4], q[5]};
}

/// Places the grid by the sform, or else by the qform.
void place_grid(const NiftiFields& fields, Grid& grid) {
    if (fields.sform_code > 0) return take_sform(fields, grid);
    for (int a = 0; a < 3; ++a) grid.spacing_mm[a] = pixdim_in_mm(fields, a);
    if (fields.qform_code > 0) take_qform(fields, grid);
}

/// Notes that there is no map, or that there are two.
void note_orientation(const NiftiFields& fields, ImageHeader& header) {
    const bool has_sform = fields.sform_code > 0;
    if (!has_sform && fields.qform_code <= 0)
        header.notes.push_back("no orientation; the axes are taken as L, P, S from (0, 0, 0)");
    if (!has_sform || fields.qform_code <= 0) return;
    NiftiFields other = fields;
    other.sform_code = 0;
    const Grid& grid = header.grid;
    Grid by_qform = grid;
    place_grid(other, by_qform);
    bool same = norm(by_qform.origin_mm - grid.origin_mm) <= kSamePositionMm;
    for (int a = 0; a < 3; ++a) {
        const Vec3d difference = by_qform.spacing_mm[a] * by_qform.direction.columns[a] -
                                 grid.spacing_mm[a] * grid.direction.columns[a];
        same = same && norm(difference) * grid.size[a] <= kSamePositionMm;
    }
    if (!same) header.notes.push_back("the sform is used; the qform differs from it");
}

Status find_data(const fs::path& path, const NiftiFields& fields, DataLocation& data) {
    const bool is_pair = is_header_of_pair(path);
    const double offset = fields.vox_offset, least = is_pair ? 0 : fields.version == 2 ? 544 : 352;
    if (!(offset >= least && offset < 1e9))
        return unreadable(
            path, "vox_offset is " + text_of(offset) + ", expected " + text_of(least) + " or more");
    data.files = {is_pair ? data_of_pair(path) : path};
    data.swapped = fields.swapped;
    const auto start = std::uint64_t(offset);
    if (is_pair ? lower_case(path.extension().string()) == ".gz" : fields.deflated) {
        data.encoding = DataEncoding::Deflated;
        data.inner_skip = start;
    } else {
        data.byte_skip = start;
    }
    return Ok{};
}

/// Reads slope and intercept if they are meaningful: without a slope there is no intercept.
void read_rescale(const NiftiFields& fields, ImageHeader& header) {
    constexpr double kNothing = std::numeric_limits<double>::epsilon();
    DataLocation& data = header.data;
    double slope = fields.slope, intercept = fields.intercept;
    if ((slope == 0 || !std::isfinite(slope)) && std::isfinite(intercept) && intercept != 0) {
        header.notes.push_back("scl_slope is " + text_of(slope) + ", so scl_inter " +
                               text_of(intercept) + " is not added");
        intercept = 0;
    }
    if (!std::isfinite(slope) || std::abs(slope) < kNothing) slope = 1;
    if (!std::isfinite(intercept)) intercept = 0;
    data.rescaled = std::abs(slope - 1) > kNothing || std::abs(intercept) > kNothing;
    data.slope = slope;
    data.intercept = intercept;
}

}  // namespace

namespace {

/// The components of vectors are the slowest axis. Those of displacements are in RAS; those of
/// other vectors are taken as LPS, as by ITK, whose writers and ANTs' leave them so.
void take_vectors(const NiftiFields& fields, ImageHeader& header) {
    constexpr int kDisplacements = 1006;
    std::uint64_t voxels = 1;
    for (const std::int64_t size : header.sizes) voxels *= std::uint64_t(size);
    header.data.voxels_before_component = voxels;
    if (fields.intent == kDisplacements) header.vector_sign = {-1, -1, 1};
}

}  // namespace

Result<ImageHeader> read_nifti_header(const fs::path& path) {
    auto fields = read_nifti_fields(path);
    if (!fields) return fields.error();
    ImageHeader header;
    header.format = ImageFormat::Nifti;
    if (Status status = read_type_and_sizes(path, *fields, header); !status) return status.error();
    if (Status status = check_size(path, header.sizes); !status) return status.error();
    const bool is_vector = header.components == 3 && !header.has_frames;
    if (header.components != 1 && !header.has_frames && !is_vector) return header;  // refused later
    if (is_vector) take_vectors(*fields, header);
    if (fields->dim[0] < 3 && fields->pixdim[3] == 0) fields->pixdim[3] = 1;
    for (std::size_t a = 1; a < 4; ++a) {
        double& pixdim = fields->pixdim[a];
        if (!(pixdim < 0)) continue;
        pixdim = -pixdim;  // as nibabel does
        header.notes.push_back("pixdim[" + std::to_string(a) +
                               "] is negative; its absolute value is used");
    }
    const bool no_sform = std::all_of(fields->srow.begin(), fields->srow.end(),
                                      [](double number) { return number == 0; });
    if (fields->sform_code > 0 && fields->qform_code > 0 && no_sform) {
        fields->sform_code = 0;
        header.notes.push_back("the sform is zero; the qform is used");
    }
    if (Status status = check_geometry(path, *fields); !status) return status.error();
    if (Status status = find_data(path, *fields, header.data); !status) return status.error();
    read_rescale(*fields, header);
    place_grid(*fields, header.grid);
    note_orientation(*fields, header);
    return header;
}

Result<std::string> nifti_extension(const fs::path& path) {
    constexpr double kMaxBytes = 1 << 20;
    const std::string name = lower_case(path.filename().string());
    if (!name.ends_with(".nii") && !name.ends_with(".nii.gz")) return std::string();
    const auto fields = read_nifti_fields(path);
    if (!fields) return fields.error();
    const double first = fields->version == 2 ? 544 : 352;
    if (!(fields->vox_offset > first)) return std::string();
    std::vector<unsigned char> bytes(
        std::size_t(first + std::min(fields->vox_offset - first, kMaxBytes)));
    bool deflated = false;
    const auto count = read_start(path, bytes, deflated);
    if (!count) return count.error();
    const auto begin = std::min(*count, std::size_t(first));
    return std::string(bytes.begin() + std::ptrdiff_t(begin),
                       bytes.begin() + std::ptrdiff_t(*count));
}

}  // namespace pliant
