// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The decision uses the same rounding as ITK 5.2. ITK's test for shear compares two inverses in
// single precision: far from the origin it finds spurious shear and uses the qform. A point must
// have the same meaning in both programs, so the test is replicated, not improved.

#include "formats/nifti_placement.h"

#include <cmath>
#include <cstddef>

#include "base/small_svd.h"

namespace pliant {
namespace {

/// Columns of a 4×4 matrix with (0, 0, 0, 1) as its last row.
SmallMatrix<4> matrix_of(const NiftiMap& map) {
    SmallMatrix<4> matrix{};
    for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t row = 0; row < 3; ++row) matrix[c][row] = map.columns[c][row];
    matrix[3][3] = 1;
    return matrix;
}
SmallMatrix<3> axes_of(const NiftiMap& map) {
    return {map.columns[0], map.columns[1], map.columns[2]};
}

float determinant_of(const NiftiMap& map) {
    const auto& [x, y, z, place] = map.columns;
    return x[0] * y[1] * z[2] - x[0] * y[2] * z[1] - x[1] * y[0] * z[2] + x[1] * y[2] * z[0] +
           x[2] * y[0] * z[1] - x[2] * y[1] * z[0];
}

/// Whether voxels have a volume, and the inverses of the 4×4 and the 3×3 matrix agree.
bool is_affine(const NiftiMap& map) {
    constexpr float kMinDeterminant = 1e-5F, kMaxDifference = 1e-2F;
    if (std::abs(determinant_of(map)) <= kMinDeterminant) return false;
    const SmallMatrix<4> inverse4 = SmallSvd<4>(matrix_of(map)).inverse();
    const SmallMatrix<3> inverse3 = SmallSvd<3>(axes_of(map)).inverse();
    float of_axes = 0, of_place = 0;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t c = 0; c < 3; ++c)
            of_axes += std::abs(inverse4[c][row] - inverse3[c][row]);
    for (std::size_t row = 0; row < 3; ++row) {
        float place = 0;
        for (std::size_t c = 0; c < 3; ++c) place += inverse3[c][row] * map.columns[3][c];
        of_place += std::abs(inverse4[3][row] - -place);
    }
    return !(of_axes > kMaxDifference || of_place > kMaxDifference);
}

/// Whether the axes have the lengths in pixdim.
bool has_its_spacings(const NiftiMap& map, const NiftiForms& forms) {
    constexpr float kMaxDifference = 1e-3F;
    for (std::size_t a = 0; a < 3; ++a) {
        float sum = 0;
        for (const float x : map.columns[a]) sum += x * x;
        const auto length = float(std::sqrt(double(sum)));
        if (std::abs(forms.step[a] - length) > kMaxDifference) return false;
    }
    return true;
}

template <std::size_t N>
bool is_identity(const std::array<std::array<float, N>, N>& m) {
    constexpr double kMaxDeviation = 1e-4;
    for (std::size_t c = 0; c < N; ++c)
        for (std::size_t row = 0; row < N; ++row)
            if (double(std::abs(m[c][row] - (c == row ? 1.F : 0.F))) > kMaxDeviation) return false;
    return true;
}

/// Whether the axes are perpendicular.
bool has_no_shear(const NiftiMap& map) {
    SmallMatrix<3> axes = axes_of(map);
    for (auto& axis : axes) {
        float sum = 0;
        for (const float x : axis) sum += x * x;
        const auto scale = float(1 / std::sqrt(double(sum)));
        for (float& x : axis) x = scale * x;
    }
    SmallMatrix<3> product{};  // axes · axesᵀ
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < 3; ++k) product[c][row] += axes[k][row] * axes[k][c];
    return is_identity(product);
}

/// Whether all numbers of the two maps are nearly equal.
bool are_equal(const NiftiMap& a, const NiftiMap& b) {
    float of_place = 0;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t c = 0; c < 3; ++c)
            if (double(std::abs(a.columns[c][row] - b.columns[c][row])) > 1e-5) return false;
        of_place += std::abs(a.columns[3][row] - b.columns[3][row]);
    }
    return !(double(of_place) > 1e-7);
}

/// Whether one times the other's transpose is the identity (near the origin, with voxels of 1 mm).
bool are_inverse(const NiftiMap& sform, const NiftiMap& qform) {
    const SmallMatrix<4> s = matrix_of(sform), q = matrix_of(qform);
    SmallMatrix<4> product{};
    for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t c = 0; c < 4; ++c)
            for (std::size_t k = 0; k < 4; ++k) product[c][row] += s[k][row] * q[k][c];
    return is_identity(product);
}

}  // namespace

NiftiMap qform_of(const NiftiForms& forms) {
    NiftiMap map;
    if (forms.qform_code <= 0) {
        for (std::size_t a = 0; a < 3; ++a) map.columns[a][a] = forms.step[a];
        return map;
    }
    // The format's "method 2". Products are rounded once, as in the reference code.
    double b = double(forms.quaternion[0]), c = double(forms.quaternion[1]),
           d = double(forms.quaternion[2]);
    auto a = double(1.0L - (long double)(b * b + c * c + d * d));
    if (a < 1e-7) {  // a half turn: only the axis is known
        a = double(1.0L / (long double)(std::sqrt(b * b + c * c + d * d)));
        b *= a;
        c *= a;
        d *= a;
        a = 0;
    } else {
        a = std::sqrt(a);
    }
    const double turn[3][3] = {{a * a + b * b - c * c - d * d, b * c + a * d, b * d - a * c},
                               {b * c - a * d, a * a + c * c - b * b - d * d, c * d + a * b},
                               {b * d + a * c, c * d - a * b, a * a + d * d - c * c - b * b}};
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t row = 0; row < 3; ++row) {
            double step = forms.step[axis] > 0 ? double(forms.step[axis]) : 1.0;
            if (axis == 2 && forms.qfac < 0) step = -step;
            map.columns[axis][row] =
                axis == row ? float(turn[axis][row] * step)
                            : float(2.0L * (long double)(turn[axis][row]) * (long double)(step));
        }
    map.columns[3] = forms.offset;
    return map;
}

NiftiMap sform_of(const NiftiForms& forms) {
    NiftiMap map;
    if (forms.sform_code > 0)
        for (std::size_t n = 0; n < 12; ++n) map.columns[n % 4][n / 4] = forms.srow[n];
    return map;
}

NiftiChoice chosen_map(const NiftiForms& forms) {
    const NiftiMap sform = sform_of(forms), qform = qform_of(forms);
    const bool has_qform = forms.qform_code > 0, has_sform = forms.sform_code > 0;
    constexpr int kScanner = 1;
    bool take_sform = has_sform && are_equal(sform, qform);
    if (has_sform && is_affine(sform) && has_its_spacings(sform, forms) && has_no_shear(sform))
        take_sform = !has_qform || forms.sform_code == kScanner || are_inverse(sform, qform);
    if (take_sform) return NiftiChoice::Sform;
    return has_qform ? NiftiChoice::Qform : NiftiChoice::None;
}

}  // namespace pliant
