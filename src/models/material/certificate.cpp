// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "material/certificate.h"

#include <algorithm>

namespace pliant {
namespace {

double fold_number(const MaterialTable& table, Vec3d spacing_mm, int entries) {
    Vec3d compress{0, 0, 0}, shear{0, 0, 0};
    for (int id = kVoidMaterial + 1; id < entries; ++id) {
        const HalfLimits& half = table[MaterialId(id)];
        for (int b = 0; b < 3; ++b) {
            const double length_units = spacing_mm[b] * kUnitsPerMm;
            compress[b] = std::max(compress[b], 2 * half.compress[b] / length_units);
            shear[b] = std::max(shear[b], 2 * half.shear[b] / length_units);
        }
    }
    return fold_number(compress, shear);
}

}  // namespace

double fold_number(Vec3d compress, Vec3d shear) {
    // For any x > 0 the radius is at most the largest (N x)_a/x_a [Berman1994]. The iteration with
    // N + 1 turns x towards the vector for which the bound is sharp, and keeps it above 0.
    constexpr int kIterations = 200;
    Vec3d x{1, 1, 1};
    double least = HUGE_VAL;
    for (int n = 0; n < kIterations; ++n) {
        Vec3d next{};
        double largest = 0, sum = 0;
        for (int a = 0; a < 3; ++a) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            next[a] = compress[a] * x[a] + shear[b] * x[b] + shear[c] * x[c];
            largest = std::max(largest, next[a] / x[a]);
            next[a] += x[a];
            sum += next[a];
        }
        least = std::min(least, largest);
        x = (3 / sum) * next;
    }
    return least;
}

FoldCertificate fold_certificate(const MaterialTable& table, Vec3d spacing_mm, bool exceeding) {
    FoldCertificate certificate;
    certificate.all = fold_number(table, spacing_mm, table.size());
    certificate.tissue = fold_number(table, spacing_mm, table.law_size());
    certificate.certified = certificate.all < 1 && !exceeding;
    return certificate;
}

}  // namespace pliant
