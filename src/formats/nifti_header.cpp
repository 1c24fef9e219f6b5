// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NIfTI-1 [NIfTI2007]: 348 bytes of binary header, plain or inside gzip. The world is RAS. A file
// may have two affine maps, "sform" and "qform"; nifti_placement.h chooses between them.

#include "core/errors.h"
#include "core/text.h"
#include "formats/data_check.h"
#include "formats/image_header.h"
#include "formats/nifti_placement.h"

#include <zlib.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <span>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kHeaderBytes = 348;
/// Tolerance of positions due to rounding to 32-bit floats [mm].
constexpr double kSamePlaceMm = 0.01;

/// The header's bytes with typed access by offset.
struct Bytes {
    std::array<unsigned char, kHeaderBytes> bytes{};
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
    double number(std::size_t offset) const { return double(get<float>(offset)); }
};

namespace at {  // offsets of the fields in use
constexpr std::size_t kSizeofHdr = 0, kDim = 40, kDatatype = 70, kPixdim = 76, kVoxOffset = 108,
                      kSclSlope = 112, kSclInter = 116, kXyztUnits = 123, kQformCode = 252,
                      kSformCode = 254, kQuatern = 256, kSrow = 280, kMagic = 344;
}  // namespace at

Result<Bytes> read_bytes(const fs::path& path) {
    Bytes header;
    const gzFile file = gzopen(path.c_str(), "rb");
    if (!file) return unreadable(path, "can't be opened");
    const int count = gzread(file, header.bytes.data(), unsigned(kHeaderBytes));
    gzclose(file);
    if (count != int(kHeaderBytes))
        return unreadable(path, "is damaged or ends early: expected 348 bytes of NIfTI header");
    if (header.get<std::int32_t>(at::kSizeofHdr) != std::int32_t(kHeaderBytes)) {
        header.swapped = true;
        const auto swapped_size = header.get<std::int32_t>(at::kSizeofHdr);
        header.swapped = swapped_size == std::int32_t(kHeaderBytes);
        const auto size = header.get<std::int32_t>(at::kSizeofHdr);
        if (size == 540 || swapped_size == 540)
            return unsupported(path, "is NIfTI-2, expected NIfTI-1");
        if (!header.swapped)
            return unreadable(
                path, "is no NIfTI file: sizeof_hdr is " + std::to_string(size) + ", expected 348");
    }
    const std::string_view magic(reinterpret_cast<const char*>(&header.bytes[at::kMagic]), 3);
    if (magic == "ni1")
        return unsupported(path, "is a NIfTI pair, expected header and data in one");
    if (magic != "n+1")
        return unreadable(path, "magic is '" + shown(magic) + "', expected 'n+1' (NIfTI-1)");
    return header;
}

Status read_type_and_sizes(const fs::path& path, const Bytes& bytes, ImageHeader& header) {
    static const std::map<int, Component> kTypes = {
        {256, Component::Int8},   {2, Component::UInt8},     {4, Component::Int16},
        {512, Component::UInt16}, {8, Component::Int32},     {768, Component::UInt32},
        {1024, Component::Int64}, {1280, Component::UInt64}, {16, Component::Float32},
        {64, Component::Float64}};
    const int type = bytes.get<std::int16_t>(at::kDatatype);
    const auto found = kTypes.find(type);
    if (found == kTypes.end()) {
        const char* what = type == 128 || type == 2304  ? " (colour)"
                           : type == 32 || type == 1792 ? " (complex)"
                                                        : "";
        return unsupported(path, "datatype is " + std::to_string(type) + what +
                                     ", expected integers, float or double");
    }
    header.stored = found->second;
    const int dimension = bytes.get<std::int16_t>(at::kDim);
    if (dimension < 1 || dimension > 7)
        return unreadable(path, "dim[0] is " + std::to_string(dimension) + ", expected 1 to 7");
    for (int a = 1; a <= dimension; ++a)
        header.sizes.push_back(bytes.get<std::int16_t>(at::kDim + 2 * std::size_t(a)));
    if (header.sizes.size() == 5 && header.sizes[3] == 1 && header.sizes[4] > 1) {
        header.components = header.sizes[4];
        header.sizes.resize(3);
    }
    while (header.sizes.size() > 3 && header.sizes.back() == 1) header.sizes.pop_back();
    return Ok{};
}

double millimetres_per_unit(const Bytes& bytes) {
    switch (bytes.bytes[at::kXyztUnits] & 7) {
        case 1:
            return 1000;
        case 3:
            return 1e-3;
        default:
            return 1;
    }
}

NiftiForms forms_of(const Bytes& bytes) {
    NiftiForms forms;
    forms.qform_code = bytes.get<std::int16_t>(at::kQformCode);
    forms.sform_code = bytes.get<std::int16_t>(at::kSformCode);
    forms.qfac = bytes.get<float>(at::kPixdim);
    for (std::size_t a = 0; a < 3; ++a) {
        forms.step[a] = bytes.get<float>(at::kPixdim + 4 + 4 * a);
        forms.quaternion[a] = bytes.get<float>(at::kQuatern + 4 * a);
        forms.offset[a] = bytes.get<float>(at::kQuatern + 12 + 4 * a);
    }
    for (std::size_t n = 0; n < 12; ++n) forms.srow[n] = bytes.get<float>(at::kSrow + 4 * n);
    return forms;
}

/// Converts a map's column to LPS.
Vec3d column_in_lps(const NiftiMap& map, std::size_t column) {
    const auto& c = map.columns[column];
    return {-double(c[0]), -double(c[1]), double(c[2])};
}

/// The sform in LPS [mm]: steps to the next voxel along i, j and k, then the first voxel's
/// position.
std::array<Vec3d, 4> sform_in_mm(const Bytes& bytes) {
    NiftiForms forms = forms_of(bytes);
    forms.sform_code = 1;
    const NiftiMap map = sform_of(forms);
    std::array<Vec3d, 4> columns;
    for (std::size_t c = 0; c < 4; ++c)
        columns[c] = millimetres_per_unit(bytes) * column_in_lps(map, c);
    return columns;
}

Status check_geometry(const fs::path& path, const Bytes& bytes) {
    const bool has_sform = bytes.get<std::int16_t>(at::kSformCode) > 0;
    const auto sform = sform_in_mm(bytes);
    for (std::size_t a = 0; a < 3; ++a) {
        if (has_sform && (!is_finite(sform[a]) || norm(sform[a]) == 0))
            return unreadable(
                path, "sform has the axis (" + text_of(sform[a]) + "), expected a direction");
        const double steps[] = {bytes.number(at::kPixdim + 4 + 4 * a), norm(sform[a])};
        for (const double step : std::span(steps, has_sform ? 2 : 1))
            if (Status status = check_spacing(path, int(a), step); !status) return status;
    }
    if (has_sform)
        if (Status status = check_origin(path, sform[3]); !status) return status;
    for (std::size_t n = 0; n < 6 && bytes.get<std::int16_t>(at::kQformCode) > 0; ++n)
        if (const double number = bytes.number(at::kQuatern + 4 * n);
            !(std::abs(number) <= (n < 3 ? 1.01 : kMaxOriginMm)))
            return unreadable(path,
                              "qform has " + text_of(number) + ", expected a rotation and a place");
    const double slope = bytes.number(at::kSclSlope), intercept = bytes.number(at::kSclInter);
    if ((slope == 0 || !std::isfinite(slope)) && std::isfinite(intercept) && intercept != 0)
        return unreadable(path, "scl_slope is " + text_of(slope) + " with scl_inter " +
                                    text_of(intercept) + ", expected a slope");
    return Ok{};
}

/// Uses the sform alone. check_grid detects shear.
void take_sform(const Bytes& bytes, Grid& grid) {
    const auto sform = sform_in_mm(bytes);
    for (int a = 0; a < 3; ++a) {
        grid.spacing_mm[a] = norm(sform[std::size_t(a)]);
        grid.direction.columns[a] = (1 / grid.spacing_mm[a]) * sform[std::size_t(a)];
    }
    grid.origin_mm = sform[3];
}

/// Places the grid. Spacings always come from pixdim, independent of the chosen map.
void place_grid(const Bytes& bytes, Grid& grid) {
    const NiftiForms forms = forms_of(bytes);
    const double unit_mm = millimetres_per_unit(bytes);
    for (int a = 0; a < 3; ++a) grid.spacing_mm[a] = double(forms.step[std::size_t(a)]) * unit_mm;
    if (forms.qform_code <= 0 && forms.sform_code <= 0) return;
    const NiftiChoice choice = chosen_map(forms);
    if (choice == NiftiChoice::None) return take_sform(bytes, grid);
    const NiftiMap map = choice == NiftiChoice::Sform ? sform_of(forms) : qform_of(forms);
    for (std::size_t a = 0; a < 3; ++a) {
        const Vec3d step = column_in_lps(map, a);
        const double length = std::sqrt(step.x * step.x + step.y * step.y + step.z * step.z);
        if (length > 0)
            grid.direction.columns[a] = {step.x / length, step.y / length, step.z / length};
    }
    grid.origin_mm = unit_mm * column_in_lps(map, 3);
}

/// Notes the chosen map if there was a choice.
void note_orientation(const Bytes& bytes, ImageHeader& header) {
    const bool has_sform = bytes.get<std::int16_t>(at::kSformCode) > 0;
    if (!has_sform && bytes.get<std::int16_t>(at::kQformCode) <= 0)
        header.notes.push_back("no orientation; the axes are taken as L, P, S from (0, 0, 0)");
    if (!has_sform) return;
    const auto sform = sform_in_mm(bytes);
    const Grid& grid = header.grid;
    bool same = norm(sform[3] - grid.origin_mm) <= kSamePlaceMm;
    for (int a = 0; a < 3; ++a) {
        const Vec3d step = grid.spacing_mm[a] * grid.direction.columns[a];
        same = same && norm(sform[std::size_t(a)] - step) * grid.size[a] <= kSamePlaceMm;
    }
    if (!same) header.notes.push_back("the qform is used; the sform differs from it");
}

Status find_data(const fs::path& path, const Bytes& bytes, DataPlace& data) {
    const double offset = bytes.number(at::kVoxOffset);
    if (!(offset >= 352 && offset < 1e9))
        return unreadable(path, "vox_offset is " + text_of(offset) + ", expected 352 or more");
    data.files = {path};
    data.swapped = bytes.swapped;
    const auto start = std::uint64_t(offset);
    if (lower_case(path.extension().string()) == ".gz") {
        data.encoding = DataEncoding::Deflated;
        data.inner_skip = start;
    } else {
        data.byte_skip = start;
    }
    return Ok{};
}

/// Reads slope and intercept if they are meaningful. @pre check_geometry succeeded
void read_rescale(const Bytes& bytes, DataPlace& data) {
    constexpr double kNothing = std::numeric_limits<double>::epsilon();
    double slope = bytes.number(at::kSclSlope), intercept = bytes.number(at::kSclInter);
    if (!std::isfinite(slope) || std::abs(slope) < kNothing) slope = 1;
    if (!std::isfinite(intercept)) intercept = 0;
    data.rescaled = std::abs(slope - 1) > kNothing || std::abs(intercept) > kNothing;
    data.slope = slope;
    data.intercept = intercept;
}

}  // namespace

Result<ImageHeader> read_nifti_header(const fs::path& path) {
    const auto bytes = read_bytes(path);
    if (!bytes) return bytes.error();
    ImageHeader header;
    header.format = ImageFormat::Nifti;
    if (Status status = read_type_and_sizes(path, *bytes, header); !status) return status.error();
    if (Status status = check_size(path, header.sizes); !status) return status.error();
    if (header.components != 1) return header;  // refused later
    if (Status status = check_geometry(path, *bytes); !status) return status.error();
    if (Status status = find_data(path, *bytes, header.data); !status) return status.error();
    read_rescale(*bytes, header.data);
    place_grid(*bytes, header.grid);
    note_orientation(*bytes, header);
    return header;
}

}  // namespace pliant
