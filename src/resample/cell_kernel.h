// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes the voxels inside deformed cells, a vector of cells at a time.
//
// A cell is the image of the cube −1 ≤ s ≤ 1 under φ(s) = c + J·s + C(s), where C holds the
// products of coordinates: q_xy·s_x·s_y + q_xz·s_x·s_z + q_yz·s_y·s_z + q_xyz·s_x·s_y·s_z.
// Multiplied by J⁻¹, φ(s) = p reads
//
//     s + G(s) = s₁   with   s₁ = J⁻¹(p − c),   G = J⁻¹C,
//
// and is solved by s ← s₁ − G(s). That costs a quarter of a Newton step, and contracts at a rate
// that is known beforehand from the sizes of G's coefficients. They say how many steps a cell
// needs, and how far s₁ can be from the answer: nearly all voxels that are not in the cell are seen
// off by s₁ and their place in the cell's bounding box. Cells of one material under a push are
// parallelepipeds: G = 0.
//
// A group of cells holds as many voxels as cells, but one cell none and the next one four. So the
// voxels that may lie in a group's cells are listed, and solved a full vector at a time; what is
// left over waits for the next group's.
//
// Every target does the same single-precision operations in the same order on each cell, with the
// same fused multiply-adds (in software where the processor has none), and cells are taken in
// groups of kCellGroup whatever the vector's width: so the results are the same bits on each
// machine.

#pragma once

#include <atomic>
#include <vector>

#include "resample/open_map.h"
#include "resample/strip_nodes.h"

namespace pliant {

/// Which of two cells that share a face writes the voxels on it.
enum class CellFaces {
    HalfOpen,  ///< one of them: a face on the high side is left to the neighbour
    Closed,    ///< both, and the first one wins: where the neighbour is missing
};

/// Where cells are written to.
struct CellTarget {
    Box3i box;                         ///< voxels that may be written; inside the scan
    Vec3i grid_size;                   ///< of the scan
    Open* open = nullptr;              ///< per voxel of the scan
    Turn turn;                         ///< that it is
    bool takes = false;                ///< voxels that write_cells writes become taken
    std::int16_t* voxels16 = nullptr;  ///< one of the two
    float* voxels32 = nullptr;
    Vec3f* inverse_mm = nullptr;  ///< over inverse_box; null: not wanted
    Box3i inverse_box;
    Vec3f world_from_voxels[3];  ///< columns: a step along i, j, k [mm, LPS]
};

/// Two threads may write one voxel, where the map is folded; it is opened and written again then.
template <class Value>
inline void put(Value& to, Value value) {
    std::atomic_ref(to).store(value, std::memory_order_relaxed);
}

/// @param back  φ⁻¹(p) − p [voxels]
inline void store_inverse(const CellTarget& target, std::ptrdiff_t voxel, Vec3f back) {
    std::ptrdiff_t at = voxel;
    const Vec3i n = target.inverse_box.end - target.inverse_box.begin;
    if (n != target.grid_size) {  // else there is nothing to be divided
        const std::ptrdiff_t nx = target.grid_size.x, ny = target.grid_size.y;
        const std::ptrdiff_t x = voxel % nx - target.inverse_box.begin.x;
        const std::ptrdiff_t y = voxel / nx % ny - target.inverse_box.begin.y;
        const std::ptrdiff_t z = voxel / (nx * ny) - target.inverse_box.begin.z;
        at = x + n.x * (y + n.y * z);
    }
    const Vec3f* m = target.world_from_voxels;
    const Vec3f mm = back.x * m[0] + back.y * m[1] + back.z * m[2];
    Vec3f& to = target.inverse_mm[at];
    put(to.x, mm.x), put(to.y, mm.y), put(to.z, mm.z);
}

/// What a cell would write.
struct Claim {
    std::ptrdiff_t voxel;
    bool is_edge;  ///< just outside of the cell, by so little that the one beside it may leave the
                   ///< voxel out as well
    int strip, cell;
    double value;
    Vec3f back;  ///< φ⁻¹(p) − p [voxels]
};

/// Which of the voxels that it finds a strip writes at once; the others it claims.
enum class Writes { AllButEdges, None };

/// What a strip leaves for later.
struct Leftovers {
    Writes writes = Writes::AllButEdges;
    int strip = 0;              ///< its number, for the claims
    std::int64_t written = 0;   ///< voxels that were open
    std::vector<Claim> claims;  ///< in any order
    /// A voxel whose place in a cell was not found, and may lie in it.
    struct Unsettled {
        int cell;
        std::ptrdiff_t voxel;
    };
    std::vector<Unsettled> unsettled;
    /// Cells that may be folded, are very thin, or reach too far: to be written one by one.
    std::vector<int> slow;
    /// Those of them that may be folded.
    std::vector<int> folded;
};

/// Writes the open voxels that lie in cells of `strip.use()`, and closes them; or claims them.
/// @param[in,out] left  is appended to. @param[in,out] ahead  all of it is asked for in passing
/// @pre !strip.is_wild()
void write_cells(const StripNodes& strip, const CellTarget& target, CellFaces faces,
                 Leftovers& left, Ahead& ahead);

/// Writes a claimed voxel and closes it, if it is open. @returns whether it was
bool write_claim(const Claim& claim, const CellTarget& target);

/// Takes away the cells that have no voxel in any of some boxes; perhaps not all of them.
/// @param[in,out] use  as StripNodes::use. @returns whether any are left
/// @pre !strip.is_wild()
bool keep_cells_near(const StripNodes& strip, std::span<const Box3i> boxes, std::span<RowBits> use);

}  // namespace pliant
