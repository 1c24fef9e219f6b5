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
// and is solved by s ← s₁ − G(s). That costs a quarter of a Newton step. The coefficients of G
// bound the rate of contraction in advance: they give the number of steps that a cell needs, and
// the largest distance of s₁ from the solution. Nearly all voxels outside of a cell are rejected by
// s₁ and by the cell's bounding box. Cells of one material under a push are parallelepipeds: G = 0.
//
// A group of cells holds as many voxels as cells on average, but single cells hold none or four. So
// the candidate voxels of a group's cells are listed, and solved a full vector at a time; the
// remainder waits for the next group's.
//
// Every target does the same single-precision operations in the same order on each cell, with the
// same fused multiply-adds (in software if the processor has none), and cells are processed in
// groups of kCellGroup for every vector width: so the results are the same bits on each machine.

#pragma once

#include <atomic>
#include <vector>

#include "resample/open_map.h"
#include "resample/strip_nodes.h"

namespace pliant {

/// Cell that writes the voxels on a face shared by two cells.
enum class CellFaces {
    HalfOpen,  ///< one of them: a face on the high side is left to the neighbour
    Closed,    ///< both, and the first one wins: for missing neighbours
};

/// Destination of the cells' voxels.
struct CellTarget {
    Box3i box;                         ///< voxels that may be written; inside the scan
    Vec3i grid_size;                   ///< of the scan
    Open* open = nullptr;              ///< [voxel of the scan]
    Turn turn;                         ///< the present turn
    bool takes = false;                ///< voxels that write_cells writes become taken
    std::int16_t* voxels16 = nullptr;  ///< one of the two
    float* voxels32 = nullptr;
    float background = kAirHu;    ///< value of gaps
    Vec3f* inverse_mm = nullptr;  ///< over inverse_box; null: not requested
    Box3i inverse_box;
    Vec3f world_from_voxels[3];  ///< columns: a step along i, j, k [mm, LPS]
};

/// Atomic store: where the map is folded, two threads may write one voxel, which is later opened
/// and written again.
template <class Value>
inline void put(Value& to, Value value) {
    std::atomic_ref(to).store(value, std::memory_order_relaxed);
}

/// @param back  φ⁻¹(p) − p [voxels]
inline void store_inverse(const CellTarget& target, std::ptrdiff_t voxel, Vec3f back) {
    std::ptrdiff_t at = voxel;
    const Vec3i n = target.inverse_box.end - target.inverse_box.begin;
    if (n != target.grid_size) {  // else no division is needed
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

/// A voxel that a cell claims, and its value.
struct Claim {
    std::ptrdiff_t voxel;
    bool is_edge;  ///< outside of the cell by so little that its neighbour may miss the voxel, too
    int strip, cell;
    double value;
    Vec3f back;  ///< φ⁻¹(p) − p [voxels]
};

/// Voxels that a strip writes at once; it claims the others.
enum class Writes { AllButEdges, None };

/// Results of a strip that are processed later.
struct Leftovers {
    Writes writes = Writes::AllButEdges;
    int strip = 0;              ///< its number, for claims
    std::int64_t written = 0;   ///< number of open voxels that were written
    std::vector<Claim> claims;  ///< in any order
    /// A voxel that may lie in a cell, but whose position in it was not found.
    struct Unsettled {
        int cell;
        std::ptrdiff_t voxel;
    };
    std::vector<Unsettled> unsettled;
    /// Cells that may be folded, are very thin, or extend too far: they are written one by one.
    std::vector<int> slow;
    /// The slow cells that may be folded.
    std::vector<int> folded;
};

/// Writes the open voxels that lie in cells of `strip.use()`, and closes them; or claims them.
/// @param[in,out] left  is appended to. @param[in,out] ahead  is prefetched completely meanwhile
/// @pre !strip.is_wild()
void write_cells(const StripNodes& strip, const CellTarget& target, CellFaces faces,
                 Leftovers& left, Ahead& ahead);

/// Writes a claimed voxel and closes it, if it is open. @returns whether it was
bool write_claim(const Claim& claim, const CellTarget& target);

/// Removes cells that have no voxel in any of some boxes; may keep some of them.
/// @param[in,out] use  like StripNodes::use. @returns whether any are left
/// @pre !strip.is_wild()
bool keep_cells_near(const StripNodes& strip, std::span<const Box3i> boxes, std::span<RowBits> use);

}  // namespace pliant
