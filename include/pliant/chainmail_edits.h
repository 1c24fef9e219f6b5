// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cutting and carving remove links and elements from a lattice.
//
//        line[0]      line[1]   line[2]
//           +-----------+---------+        The path of a blade through the deformed scan: a line
//          /           /         /         swept along the depth vector. Links that cross this
//         /           /         /          ribbon are cut.
//        +-----------+---------+
//
// Both use the current positions of the elements. ChainMail::undo reverts both exactly.

#pragma once

#include <pliant/vec.h>

#include <cstdint>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// A line swept along a vector.
struct CutSurface {
    std::vector<Vec3d> line_mm;  ///< two or more points in the deformed scan, LPS
    Vec3d depth_mm{0, 0, 0};     ///< LPS; not along the line
};

struct CutReport {
    std::int64_t cut_links = 0;  ///< links that this cut added
    double cut_ms = 0;
    int forgotten_steps = 0;  ///< oldest steps that can't be undone any more
};

/// Sphere that sweeps from one position to another: a capsule.
struct CarveTool {
    Vec3d from_mm{0, 0, 0};  ///< centre, in the deformed scan, LPS
    Vec3d to_mm{0, 0, 0};
    double radius_mm = 0;      ///< above 0, up to 500
    bool spare_fixed = false;  ///< leaves elements that never move (bone) intact
};

struct CarveReport {
    std::int64_t carved_elements = 0;  ///< elements that this carving added
    double carve_ms = 0;
    int forgotten_steps = 0;
};

}  // namespace pliant
#pragma GCC visibility pop
