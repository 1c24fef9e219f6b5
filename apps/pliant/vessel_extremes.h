// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Largest values of a catheter's run, of all of its steps. Only the energy, whose computation would
// take as long as a step, is that of some steps.
//
// A step's pass over the wall skips tetrahedra that nothing has moved, which are most of a wall in
// boxes.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/models/catheter.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pliant::app {

class VesselExtremes {
  public:
    /// @pre the wall is at rest
    explicit VesselExtremes(const CatheterScene& scene);
    /// Call it after each step.
    void add(const CatheterScene& scene, const TaskArena& arena);
    void add_energy(const CatheterScene& scene);
    void add_way(double way_mm) { m_way_mm = way_mm > m_way_mm ? way_mm : m_way_mm; }

    /// Warnings of the run, of its deepest step.
    std::vector<std::string> warnings() const;
    double depth_mm() const { return m_deepest.depth_mm; }
    double force_n() const { return m_force_n; }
    double wall_moved_mm() const { return m_wall_moved_mm; }
    double energy_mj() const { return m_energy_mj; }
    double volume_mean() const { return m_volume_mean; }
    double volume_largest() const { return m_volume_largest; }
    double way_mm() const { return m_way_mm; }
    std::int64_t inverted() const { return m_inverted; }
    std::int32_t active() const { return m_active; }
    std::int32_t left_end() const { return m_left_end; }
    std::int32_t sub_steps() const { return m_sub_steps; }

  private:
    /// Volumes of the tetrahedra of one part of the wall.
    struct Volumes {
        double error_sum = 0, largest = 0;  ///< relative deviations from the volume at rest
        std::int64_t inverted = 0;
    };
    void add_wall(const CatheterScene& scene, const TaskArena& arena);
    Volumes volumes_of(const TetMesh& rest, std::size_t part) const;
    double error_of(const TetMesh& rest, std::size_t cell) const;

    CatheterMeasures m_deepest;
    double m_force_n = 0, m_wall_moved_mm = 0, m_energy_mj = 0, m_volume_mean = 0,
           m_volume_largest = 0, m_way_mm = 0;
    std::int64_t m_inverted = 0;
    std::int32_t m_active = 0, m_left_end = 0, m_sub_steps = 0;

    std::vector<Vec3d> m_begun, m_now;      ///< [node]; a body rounds its positions at rest
    std::vector<std::uint8_t> m_has_moved;  ///< [node]
    std::vector<double> m_rest_mm3;         ///< [tetrahedron]
    std::vector<double> m_begun_errors;     ///< [tetrahedron]: of the rounded positions
    std::vector<Volumes> m_parts;
};

}  // namespace pliant::app
