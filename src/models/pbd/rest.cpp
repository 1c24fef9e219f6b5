// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rest values of constraints.

#include <cmath>

#include "pbd/arithmetic.h"
#include "pbd/ogden.h"
#include "pbd/solver.h"

namespace pliant::pbd {
namespace {

Vec3d position(const PbdParts& parts, std::int32_t node) {
    return parts.positions[std::size_t(node)];
}

}  // namespace

double tetrahedron_volume(const std::array<std::int32_t, 4>& nodes,
                          std::span<const Vec3d> positions) {
    const auto at = [&](std::size_t n) { return positions[std::size_t(nodes[n])]; };
    return pliant::dot(pliant::cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0)) / 6;
}

double rest_length(const PbdParts& parts, const PbdDistance& d) {
    return d.rest_length >= 0 ? d.rest_length
                              : norm(position(parts, d.nodes[0]) - position(parts, d.nodes[1]));
}

double rest_angle(const PbdParts& parts, const PbdBend& bend) {
    if (!std::isnan(bend.rest_angle)) return bend.rest_angle;
    Corner<double> p[4];
    for (std::size_t n = 0; n < 4; ++n) {
        const Vec3d at = position(parts, bend.nodes[n]);
        p[n] = {{at.x, at.y, at.z}, 1};
    }
    return bend_constraint(p, 0.0).value;
}

double rest_volume(const PbdParts& parts, const PbdVolume& volume) {
    return volume.rest_volume >= 0 ? volume.rest_volume
                                   : tetrahedron_volume(volume.nodes, parts.positions);
}

SolidNumbers solid_numbers(const PbdParts& parts, const PbdSolid& solid) {
    const Vec3d origin = position(parts, solid.nodes[0]);
    Mat3d edges{};
    for (std::size_t n = 0; n < 3; ++n)
        edges.columns[n] = position(parts, solid.nodes[n + 1]) - origin;
    const Mat3d inverse = pliant::inverse(edges);
    const double volume = determinant(edges) / 6, nu = solid.poisson_ratio;
    const double mu = solid.young_modulus / (2 * (1 + nu));
    const double lambda = solid.young_modulus * nu / ((1 + nu) * (1 - 2 * nu));
    SolidNumbers s{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            s.inverse[3 * row + column] = inverse.columns[column][row];
    const double bulk = solid.ogden_alpha == 2
                            ? lambda
                            : mu * ogden_volume_stiffness(solid.ogden_alpha, lambda / mu);
    s.h_compliance = 1 / (bulk * volume);
    s.e_compliance = 1 / (mu * volume);
    s.ogden_alpha = solid.ogden_alpha == 2 ? 0 : solid.ogden_alpha;
    return s;
}

WarmSolid<double> warm_solid(const SolidNumbers& s) {
    const auto row = [&](int n) {
        return Vec3d{s.inverse[3 * n], s.inverse[3 * n + 1], s.inverse[3 * n + 2]};
    };
    const auto m = [&](int a, int b) { return pliant::dot(row(a), row(b)); };
    return {m(0, 0),
            m(0, 1),
            m(0, 2),
            m(1, 1),
            m(1, 2),
            m(2, 2),
            pliant::dot(pliant::cross(row(0), row(1)), row(2)),
            1 / s.h_compliance,
            1 / s.e_compliance};
}

}  // namespace pliant::pbd
