// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The displacements of the lattices, written to the bricks of a field for each voxel.

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "elastic/levels.h"
#include "field/writable_field.h"

namespace pliant {

class ShownDisplacement {
  public:
    explicit ShownDisplacement(const Grid& grid) : m_field(grid) {}
    const Field& field() const { return m_field; }

    /// Replaces the edits of some bricks. On an error nothing has changed.
    void edit(EditMap& bricks);

    /// Writes the bricks that lag most behind the lattices, of max_elements elements at most. Those
    /// that lag by less than 0.02 mm are written when no other lags. Voxels of bone are at
    /// rest, and so are bricks that move by less than 0.02 mm.
    /// @returns whether no brick lags. Throws std::bad_alloc, and nothing has changed
    bool show(const ElasticLevels& levels, const StiffnessMap& map, std::int64_t max_elements,
              const TaskArena& arena);

  private:
    struct Lag {
        Vec3i coord;
        Fixed units;
        std::size_t chunk = 0, at = 0;  ///< of its displacements
    };
    using BrickRow = std::array<std::array<float, kMaxBrickSize>, 3>;  ///< [component]

    void find_row(const ElasticLevels& levels, const StiffnessMap& map, Vec3i first, int count,
                  BrickRow& row) const;
    static bool is_before(const Lag& a, const Lag& b);
    void fill(const ElasticLevels& levels, const StiffnessMap& map, Vec3i coord,
              const std::array<Fixed*, 3>& u) const;
    void measure(const ElasticLevels& levels, const StiffnessMap& map, Lag& lag,
                 std::vector<Fixed>& filled) const;
    Fixed sampled_lag(const ElasticLevels& levels, const StiffnessMap& map, Vec3i coord) const;
    bool keep_farthest(const ElasticLevels& levels, const StiffnessMap& map, std::size_t most,
                       std::vector<Lag>& lags, const TaskArena& arena) const;
    std::vector<Lag> find_lags(const ElasticLevels& levels, const StiffnessMap& map,
                               std::size_t most, const TaskArena& arena);

    WritableField m_field;
    bool m_is_sampled = false;                 ///< the last lags were found by samples
    std::vector<std::vector<Fixed>> m_chunks;  ///< displacements of the bricks that lag
};

}  // namespace pliant
