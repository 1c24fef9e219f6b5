// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "vessel_extremes.h"

#include <algorithm>
#include <cmath>

namespace pliant::app {
namespace {

constexpr std::size_t kPart = 4096;  ///< tetrahedra that are summed up at once

double volume_mm3(const std::array<std::int32_t, 4>& cell, const std::vector<Vec3d>& x) {
    const Vec3d from = x[std::size_t(cell[0])];
    return dot(x[std::size_t(cell[1])] - from,
               cross(x[std::size_t(cell[2])] - from, x[std::size_t(cell[3])] - from)) /
           6;
}

}  // namespace

VesselExtremes::VesselExtremes(const CatheterScene& scene) {
    m_deepest.depth_mm = -1e9;
    if (scene.settings().wall.model == WallModel::Rigid) return;
    const TetMesh& rest = scene.wall().mesh;
    m_begun = m_now = scene.wall_positions();
    m_has_moved.resize(m_begun.size());
    for (const auto& cell : rest.cells) m_rest_mm3.push_back(volume_mm3(cell, rest.nodes_mm));
    for (std::size_t c = 0; c < rest.cells.size(); ++c) m_begun_errors.push_back(error_of(rest, c));
    m_parts.resize((rest.cells.size() + kPart - 1) / kPart);
}

double VesselExtremes::error_of(const TetMesh& rest, std::size_t cell) const {
    return volume_mm3(rest.cells[cell], m_now) / m_rest_mm3[cell] - 1;
}

void VesselExtremes::add(const CatheterScene& scene, const TaskArena& arena) {
    const CatheterMeasures m = scene.quick_measures();
    if (m.depth_mm > m_deepest.depth_mm) m_deepest = m;
    m_force_n = std::max(m_force_n, std::abs(m.force_n));
    m_active = std::max(m_active, m.active_tetrahedra);
    m_sub_steps = std::max(m_sub_steps, m.sub_steps);
    if (m.left_end > 0) m_left_end = m.left_end;
    if (!m_begun.empty()) add_wall(scene, arena);
}

void VesselExtremes::add_wall(const CatheterScene& scene, const TaskArena& arena) {
    const TetMesh& rest = scene.wall().mesh;
    double moved2 = 0;
    for (std::size_t n = 0; n < m_now.size(); ++n) {
        m_now[n] = scene.body().position(std::int32_t(n));
        m_has_moved[n] = m_now[n] != m_begun[n];
        const Vec3d by = m_now[n] - rest.nodes_mm[n];
        moved2 = std::max(moved2, dot(by, by));
    }
    m_wall_moved_mm = std::max(m_wall_moved_mm, std::sqrt(moved2));
    arena.for_each(std::int64_t(m_parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (auto p = std::size_t(begin); p < std::size_t(end); ++p)
            m_parts[p] = volumes_of(rest, p);
    });
    Volumes all;
    for (const Volumes& part : m_parts) {
        all.error_sum += part.error_sum;
        all.largest = std::max(all.largest, part.largest);
        all.inverted += part.inverted;
    }
    m_volume_mean = std::max(m_volume_mean, all.error_sum / double(rest.cells.size()));
    m_volume_largest = std::max(m_volume_largest, all.largest);
    m_inverted = std::max(m_inverted, all.inverted);
}

VesselExtremes::Volumes VesselExtremes::volumes_of(const TetMesh& rest, std::size_t part) const {
    Volumes volumes;
    const std::size_t end = std::min(rest.cells.size(), (part + 1) * kPart);
    for (std::size_t c = part * kPart; c < end; ++c) {
        const auto& cell = rest.cells[c];
        const bool has_moved =
            (m_has_moved[std::size_t(cell[0])] | m_has_moved[std::size_t(cell[1])] |
             m_has_moved[std::size_t(cell[2])] | m_has_moved[std::size_t(cell[3])]) != 0;
        const double error = has_moved ? error_of(rest, c) : m_begun_errors[c];
        volumes.error_sum += std::abs(error);
        volumes.largest = std::max(volumes.largest, std::abs(error));
        volumes.inverted += !(error > -1);
    }
    return volumes;
}

void VesselExtremes::add_energy(const CatheterScene& scene) {
    const CatheterMeasures m = scene.measures();
    m_energy_mj = std::max(m_energy_mj, m.wire_energy_mj + m.wall_energy_mj + m.kinetic_energy_mj);
}

std::vector<std::string> VesselExtremes::warnings() const {
    CatheterMeasures m = m_deepest;
    m.inverted = m_inverted;
    m.left_end = m_left_end;
    return warnings_of(m);
}

}  // namespace pliant::app
