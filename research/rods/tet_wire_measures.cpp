// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Measures of a catheter of tetrahedra: forces, energy, its mesh.

#include <algorithm>
#include <cmath>

#include "catheter/frame_along.h"
#include "pbd/solver.h"
#include "rods/tet_wire.h"

namespace pliant::catheter {

/// Forces of the bars between rings and of the volumes on the segment's nodes. Bars of rings are in
/// balance.
Corners TetWire::segment_forces(std::size_t i) const {
    const bool odd = i % 2;
    const SegmentStiffness& k = m_stiffness[i];
    const Corners x = corners(m_nodes, i);
    const auto bars = bars_across(odd);
    const auto cells = tetrahedra(odd);
    Corners forces{};
    for (std::size_t n = 0; n < kAcross; ++n) {
        const Vec3d d = x[bars[n].b] - x[bars[n].a];
        const double stiff = bars[n].is_along ? k.along : k.aslant;
        const Vec3d pull = (stiff * (norm(d) - rest(i).lengths[n]) / norm(d)) * d;
        forces[bars[n].a] = forces[bars[n].a] + pull;
        forces[bars[n].b] = forces[bars[n].b] - pull;
    }
    for (std::size_t n = 0; n < kTets; ++n) {
        const auto g = volume_gradient(cells[n], x);
        const double v0 = rest(i).volumes[n];
        const double pressure = k.bulk / v0 * (volume_of(cells[n], x) - v0);
        for (std::size_t a = 0; a < 4; ++a)
            forces[cells[n][a]] = forces[cells[n][a]] - pressure * g[a];
    }
    return forces;
}

Vec3d TetWire::base_force() const {
    if (m_first >= segments()) return {0, 0, 0};
    const Corners forces = segment_forces(std::size_t(m_first));
    Vec3d sum{0, 0, 0};
    for (std::size_t k = 0; k < kRing; ++k) sum = sum + forces[k];
    return sum;
}

Vec3d TetWire::base_moment() const {
    if (m_first >= segments()) return {0, 0, 0};
    const auto first = std::size_t(m_first);
    const Corners forces = segment_forces(first);
    Vec3d sum{0, 0, 0};
    for (std::size_t k = 0; k < kRing; ++k)
        sum = sum + cross(m_nodes[kRing * first + k] - m_x[first], forces[k]);
    return sum;
}

double TetWire::elastic_energy() const {
    double energy = 0;
    const auto add = [&](double stiffness, double off) { energy += 0.5 * stiffness * off * off; };
    const auto ring = bars_in_ring();
    for (auto i = std::size_t(m_first); i < m_count; ++i) {
        const Corners x = corners(m_nodes, i);
        const SegmentStiffness& k = m_stiffness[i];
        const auto bars = bars_across(i % 2);
        const auto cells = tetrahedra(i % 2);
        for (std::size_t n = 0; n < kAcross; ++n)
            add(bars[n].is_along ? k.along : k.aslant,
                norm(x[bars[n].b] - x[bars[n].a]) - rest(i).lengths[n]);
        for (std::size_t n = 0; n < kInRing; ++n)
            add(k.ring, norm(x[kRing + ring[n][1]] - x[kRing + ring[n][0]]) - m_ring[n]);
        for (std::size_t n = 0; n < kTets; ++n)
            add(k.bulk / rest(i).volumes[n], volume_of(cells[n], x) - rest(i).volumes[n]);
    }
    return energy;
}

bool TetWire::is_good() const {
    return std::all_of(m_nodes.begin(), m_nodes.end(), is_finite) &&
           std::all_of(m_node_v.begin(), m_node_v.end(), is_finite);
}

Rotation TetWire::tip_frame() const {
    const std::size_t last = kRing * m_count, before = last - kRing;
    const Rotation ahead = frame_along(m_x[m_count] - m_x[m_count - 1]);
    const Vec3d first =
        (m_nodes[last] - m_nodes[last + 2]) + (m_nodes[before] - m_nodes[before + 2]);
    const double angle =
        std::atan2(dot(first, rotated(ahead, {0, 1, 0})), dot(first, rotated(ahead, {1, 0, 0})));
    return ahead * rotation_by({0, 0, angle});
}

TetMesh TetWire::mesh() const {
    TetMesh mesh{m_nodes, {}};
    for (std::size_t i = 0; i < m_count; ++i)
        for (const auto& tet : tetrahedra(i % 2)) {
            auto& cell = mesh.cells.emplace_back();
            for (std::size_t k = 0; k < 4; ++k) cell[k] = std::int32_t(kRing * i + tet[k]);
        }
    return mesh;
}

std::int64_t TetWire::inverted() const {
    std::int64_t count = 0;
    for (std::size_t i = 0; i < m_count; ++i) {
        const Corners x = corners(m_nodes, i);
        for (const auto& tet : tetrahedra(i % 2))
            count += !(pbd::tetrahedron_volume({tet[0], tet[1], tet[2], tet[3]}, x) > 0);
    }
    return count;
}

}  // namespace pliant::catheter
