// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Validity checks of walls from any source.

#include <string>

#include "base/errors.h"
#include "vessel/wall.h"

namespace pliant {
namespace {

std::string counted(std::int64_t count, const char* one, const char* many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
}

Status check_ghost(const VesselWall& wall) {
    const SurfaceTopology ghost = surface_topology(wall.ghost);
    if (ghost.pieces != 1)
        return vessel::wrong("its inner surface has " + counted(ghost.pieces, "piece", "pieces") +
                             ", expected 1");
    const std::int64_t spots =
        ghost.non_manifold_edges + ghost.disagreeing_edges + ghost.pinched_nodes;
    if (spots > 0)
        return vessel::wrong("its inner surface branches or touches itself in " +
                             counted(spots, "edge or node", "edges and nodes") +
                             ", expected a manifold");
    const auto openings = vessel::openings_of(wall.ghost);
    if (!openings) return openings.error();
    if (openings->size() != wall.ends.size())
        return vessel::wrong("its inner surface has " +
                             counted(std::int64_t(openings->size()), "opening", "openings") +
                             ", expected " + std::to_string(wall.ends.size()) +
                             ", one at each end of the vessel");
    if (wall.ghost_positions.size() != wall.ghost.nodes_mm.size())
        return vessel::wrong("ghost_positions: expected " +
                             std::to_string(wall.ghost.nodes_mm.size()) + ", found " +
                             std::to_string(wall.ghost_positions.size()));
    std::int64_t away = 0;
    for (std::size_t n = 0; n < wall.ghost_positions.size(); ++n)
        away += vessel::is_beside(wall.ghost_positions[n], wall.ghost.nodes_mm[n], wall.mesh);
    if (away > 0)
        return vessel::wrong(
            counted(away, "node of its inner surface lies", "nodes of its inner surface lie") +
            " beside the wall, expected all on it");
    return Ok{};
}

Status check_parts_of(const VesselWall& wall, int layers) {
    if (const Status s = check_cells(wall.ghost); !s) return s;
    if (const Status s = check_mesh(wall.mesh); !s) return s;
    const TetQuality quality = tet_quality(wall.mesh);
    if (const Status s = check_quality(quality); !s) return vessel::wrong(s.error().message);
    if (quality.pieces != 1)
        return vessel::wrong("it has " + counted(quality.pieces, "piece", "pieces") +
                             ", expected 1");
    if (const Status s = check_ghost(wall); !s) return s;
    if (wall.min_layers < layers)
        return vessel::wrong(counted(wall.min_layers, "layer", "layers") +
                             " of tetrahedra across it, expected " + std::to_string(layers) +
                             " or more");
    return Ok{};
}

}  // namespace

Status check_wall(const VesselWall& wall, int layers) noexcept {
    return attempt([&] { return check_parts_of(wall, layers); });
}

}  // namespace pliant
