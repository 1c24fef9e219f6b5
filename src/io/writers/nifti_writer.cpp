// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/scan_files.h>

#include "writers/stream_writers.h"

#include "base/text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// The header and four bytes that announce no extension.
constexpr std::size_t kDataStart = 352;

using NiftiHead = std::array<std::byte, kDataStart>;

template <class T>
void put(NiftiHead& head, std::size_t offset, T value) {
    std::memcpy(&head[offset], &value, sizeof value);
}

/// Unit quaternion of a rotation, with a ≥ 0.
struct Quaternion {
    double a = 1, b = 0, c = 0, d = 0;
};

/// The largest component is computed from the diagonal, the others from it.
Quaternion quaternion_of(const Mat3d& rotation) {
    const auto r = [&](int row, std::size_t column) { return rotation.columns[column][row]; };
    // Four times the square of each component.
    const std::array<double, 4> squares = {
        1 + r(0, 0) + r(1, 1) + r(2, 2), 1 + r(0, 0) - r(1, 1) - r(2, 2),
        1 - r(0, 0) + r(1, 1) - r(2, 2), 1 - r(0, 0) - r(1, 1) + r(2, 2)};
    const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
    const double n = 0.5 * std::sqrt(squares[std::size_t(largest)]), f = 0.25 / n;
    const double bc = f * (r(1, 0) + r(0, 1)), bd = f * (r(2, 0) + r(0, 2)),
                 cd = f * (r(2, 1) + r(1, 2)), ab = f * (r(2, 1) - r(1, 2)),
                 ac = f * (r(0, 2) - r(2, 0)), ad = f * (r(1, 0) - r(0, 1));
    const Quaternion all[] = {{n, ab, ac, ad}, {ab, n, bc, bd}, {ac, bc, n, cd}, {ad, bd, cd, n}};
    const Quaternion q = all[largest];
    return q.a < 0 ? Quaternion{-q.a, -q.b, -q.c, -q.d} : q;
}

void put_geometry(NiftiHead& head, const Grid& grid) {
    constexpr std::size_t kPixdim = 76, kUnits = 123, kForms = 252, kQuatern = 256, kOffset = 268,
                          kSrow = 280;
    constexpr std::int16_t kScanner = 1;
    const Vec3d to_ras{-1, -1, 1};
    Mat3d axes = grid.direction;
    for (Vec3d& axis : axes.columns)
        for (int row = 0; row < 3; ++row) axis[row] *= to_ras[row];
    const Vec3d origin{-grid.origin_mm.x, -grid.origin_mm.y, grid.origin_mm.z};
    for (int row = 0; row < 3; ++row) {
        for (int a = 0; a < 3; ++a)
            put(head, kSrow + 4 * std::size_t(4 * row + a),
                float(grid.spacing_mm[a] * axes.columns[std::size_t(a)][row]));
        put(head, kSrow + 4 * std::size_t(4 * row + 3), float(origin[row]));
        put(head, kOffset + 4 * std::size_t(row), float(origin[row]));
        put(head, kPixdim + 4 + 4 * std::size_t(row), float(grid.spacing_mm[row]));
    }
    const bool mirrored = determinant(axes) < 0;
    if (mirrored) axes.columns[2] = -axes.columns[2];
    put(head, kPixdim, mirrored ? -1.0F : 1.0F);
    const Quaternion q = quaternion_of(axes);
    put(head, kQuatern, float(q.b));
    put(head, kQuatern + 4, float(q.c));
    put(head, kQuatern + 8, float(q.d));
    put(head, kForms, kScanner);
    put(head, kForms + 2, kScanner);
    put(head, kUnits, char(2));  // millimetres
}

}  // namespace

Status check_nifti_size(const fs::path& path, const Grid& grid) {
    constexpr std::int32_t kMost = std::numeric_limits<std::int16_t>::max();
    const std::int32_t largest = std::max({grid.size.x, grid.size.y, grid.size.z});
    if (largest <= kMost) return Ok{};
    return Error{ErrorCode::Unsupported,
                 path.string() + ": NIfTI-1 holds up to " + std::to_string(kMost) +
                     " voxels along an axis, found " + std::to_string(largest)};
}

NiftiWriter::NiftiWriter(const fs::path& path, const NrrdLayout& layout, Encoding) : m_sink(path) {
    constexpr std::int16_t kInt16 = 4, kFloat32 = 16;
    const bool is_short = layout.component == Component::Int16;
    NiftiHead head{};
    put(head, 0, std::int32_t(348));
    put(head, 38, 'r');
    // Vectors are a fifth axis, and along it the data.
    const bool is_vector = layout.components == 3;
    const std::int16_t sizes[] = {std::int16_t(is_vector ? 5 : 3),
                                  std::int16_t(layout.grid.size.x),
                                  std::int16_t(layout.grid.size.y),
                                  std::int16_t(layout.grid.size.z),
                                  1,
                                  std::int16_t(layout.components),
                                  1,
                                  1};
    constexpr std::int16_t kVector = 1007;
    if (is_vector) put(head, 68, kVector);
    for (std::size_t n = 0; n < std::size(sizes); ++n) put(head, 40 + 2 * n, sizes[n]);
    put(head, 70, is_short ? kInt16 : kFloat32);
    put(head, 72, std::int16_t(is_short ? 16 : 32));
    put(head, 108, float(kDataStart));
    put(head, 112, 1.0F);  // slope
    put_geometry(head, layout.grid);
    std::memcpy(&head[344], "n+1", 4);
    if (lower_case(path.extension().string()) == ".gz") m_sink.start(Compression::Gzip);
    m_sink.add(head);
}

Status NiftiWriter::finish() {
    m_sink.end_numbers();
    return m_sink.finish();
}

}  // namespace pliant
