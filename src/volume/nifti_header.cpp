// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// NIfTI-1: 348 bytes of binary header, plain or inside gzip. Its world is RAS. A file may carry two
// affine maps, "sform" and "qform"; which of them counts is decided as ITK does it, so that a point
// means the same here and in programs that stand on ITK: the sform if it is the scanner's or the
// only one, the qform otherwise.

#include "volume/image_header.h"
#include "volume/text.h"

#include <zlib.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kHeaderBytes = 348;

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

namespace at {  // offsets of the fields that are used
constexpr std::size_t kSizeofHdr = 0, kDim = 40, kDatatype = 70, kPixdim = 76, kVoxOffset = 108,
                      kSclSlope = 112, kSclInter = 116, kXyztUnits = 123, kQformCode = 252,
                      kSformCode = 254, kQuatern = 256, kQoffset = 268, kSrow = 280, kMagic = 344;
}  // namespace at

Error damaged(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unreadable, path.string() + ": " + message};
}
Error unsupported(const fs::path& path, const std::string& message) {
    return {ErrorCode::Unsupported, path.string() + ": " + message};
}

Result<Bytes> read_bytes(const fs::path& path) {
    Bytes header;
    const gzFile file = gzopen(path.c_str(), "rb");
    if (!file) return damaged(path, "can't be opened");
    const int count = gzread(file, header.bytes.data(), unsigned(kHeaderBytes));
    gzclose(file);
    if (count != int(kHeaderBytes))
        return damaged(path, "is damaged or ends early: expected 348 bytes of NIfTI header");
    if (header.get<std::int32_t>(at::kSizeofHdr) != std::int32_t(kHeaderBytes)) {
        header.swapped = true;
        const auto swapped_size = header.get<std::int32_t>(at::kSizeofHdr);
        header.swapped = swapped_size == std::int32_t(kHeaderBytes);
        const auto size = header.get<std::int32_t>(at::kSizeofHdr);
        if (size == 540 || swapped_size == 540)
            return unsupported(path, "is NIfTI-2, expected NIfTI-1");
        if (!header.swapped)
            return damaged(
                path, "is no NIfTI file: sizeof_hdr is " + std::to_string(size) + ", expected 348");
    }
    const std::string_view magic(reinterpret_cast<const char*>(&header.bytes[at::kMagic]), 3);
    if (magic == "ni1")
        return unsupported(path, "is a NIfTI pair, expected header and data in one");
    if (magic != "n+1")
        return damaged(path, "magic is '" + shown(magic) + "', expected 'n+1' (NIfTI-1)");
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
    header.component = found->second;
    const int dimension = bytes.get<std::int16_t>(at::kDim);
    if (dimension < 1 || dimension > 7)
        return damaged(path, "dim[0] is " + std::to_string(dimension) + ", expected 1 to 7");
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

struct Affine {
    Vec3d steps[3];
    Vec3d origin;
};

Affine sform_of(const Bytes& bytes) {
    Affine affine{};
    for (int row = 0; row < 3; ++row) {
        const std::size_t start = at::kSrow + 16 * std::size_t(row);
        for (int c = 0; c < 3; ++c) affine.steps[c][row] = bytes.number(start + 4 * std::size_t(c));
        affine.origin[row] = bytes.number(start + 12);
    }
    return affine;
}

/// The unit quaternion (a, b, c, d), of which the file has b, c, d, as a rotation.
Affine qform_of(const Bytes& bytes) {
    double b = bytes.number(at::kQuatern), c = bytes.number(at::kQuatern + 4),
           d = bytes.number(at::kQuatern + 8);
    const double rest = 1 - (b * b + c * c + d * d);
    double a = rest > 0 ? std::sqrt(rest) : 0;
    if (rest < 1e-7) {  // a half turn: rounding may have left b, c, d a little too long
        const double scale = 1 / std::sqrt(b * b + c * c + d * d);
        a = 0, b *= scale, c *= scale, d *= scale;
    }
    const double qfac = bytes.number(at::kPixdim) < 0 ? -1 : 1;
    const double pixdim[3] = {bytes.number(at::kPixdim + 4), bytes.number(at::kPixdim + 8),
                              bytes.number(at::kPixdim + 12)};
    Affine affine;
    affine.steps[0] =
        pixdim[0] * Vec3d{a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)};
    affine.steps[1] =
        pixdim[1] * Vec3d{2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)};
    affine.steps[2] = (qfac * pixdim[2]) * Vec3d{2 * (b * d + a * c), 2 * (c * d - a * b),
                                                 a * a + d * d - c * c - b * b};
    affine.origin = {bytes.number(at::kQoffset), bytes.number(at::kQoffset + 4),
                     bytes.number(at::kQoffset + 8)};
    return affine;
}

Status take_affine(const fs::path& path, const char* name, Affine affine, double unit_mm,
                   ImageHeader& header) {
    for (Vec3d& step : affine.steps) {
        if (!(norm(step) > 0) || !is_finite(step))
            return damaged(path, std::string(name) + " has the axis (" + text_of(step) +
                                     "), expected a direction");
        step = unit_mm * Vec3d{-step.x, -step.y, step.z};
    }
    set_axes(header.grid, affine.steps);
    header.grid.origin_mm = unit_mm * Vec3d{-affine.origin.x, -affine.origin.y, affine.origin.z};
    header.vector_sign = {-1, -1, 1};
    return Ok{};
}

Status read_grid(const fs::path& path, const Bytes& bytes, ImageHeader& header) {
    const int qform_code = bytes.get<std::int16_t>(at::kQformCode);
    const int sform_code = bytes.get<std::int16_t>(at::kSformCode);
    const double unit_mm = millimetres_per_unit(bytes);
    const bool prefer_sform = sform_code > 0 && (sform_code == 1 || qform_code <= 0);
    if (prefer_sform) {
        Status status = take_affine(path, "sform", sform_of(bytes), unit_mm, header);
        if (!status || qform_code <= 0 || is_perpendicular(header.grid.direction)) return status;
        header.notes.push_back("the sform is sheared; the qform is used");
    }
    if (qform_code > 0) {
        for (std::size_t a = 1; a <= 3; ++a)
            if (const double step = bytes.number(at::kPixdim + 4 * a); !(step > 0))
                return damaged(path, "spacing (pixdim) of axis " + std::to_string(a) + " is " +
                                         text_of(step) + ", expected more than 0");
        return take_affine(path, "qform", qform_of(bytes), unit_mm, header);
    }
    header.notes.push_back("no orientation; the axes are taken as L, P, S from (0, 0, 0)");
    for (std::size_t a = 0; a < 3; ++a)
        header.grid.spacing_mm[int(a)] = unit_mm * bytes.number(at::kPixdim + 4 + 4 * a);
    return Ok{};
}

Status read_data_place(const fs::path& path, const Bytes& bytes, ImageHeader& header) {
    const double offset = bytes.number(at::kVoxOffset);
    if (!(offset == 0 || (offset >= double(kHeaderBytes) && offset < 1e9)))
        return damaged(path, "vox_offset is " + text_of(offset) + ", expected 352 or more");
    DataPlace& data = header.data;
    data.files = {path};
    data.big_endian = bytes.swapped != (std::endian::native == std::endian::big);
    const auto start = std::uint64_t(offset == 0 ? 352 : offset);
    if (lower_case(path.extension().string()) == ".gz") {
        data.encoding = DataEncoding::Deflated;
        data.inner_skip = start;
    } else {
        data.byte_skip = start;
    }
    const double slope = bytes.number(at::kSclSlope), intercept = bytes.number(at::kSclInter);
    if (slope != 0 && std::isfinite(slope) && std::isfinite(intercept)) {
        header.slope = slope;
        header.intercept = intercept;
    }
    return Ok{};
}

}  // namespace

Result<ImageHeader> read_nifti_header(const fs::path& path) {
    auto bytes = read_bytes(path);
    if (!bytes) return bytes.error();
    ImageHeader header;
    header.format = ImageFormat::Nifti;
    if (Status status = read_type_and_sizes(path, *bytes, header); !status) return status.error();
    if (header.sizes.size() == 3 && header.components == 1)  // else it will be refused for that
        if (Status status = read_grid(path, *bytes, header); !status) return status.error();
    if (Status status = read_data_place(path, *bytes, header); !status) return status.error();
    return header;
}

}  // namespace pliant
