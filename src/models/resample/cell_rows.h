// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Data of cells and voxels between the two stages of the vector kernel.
//
// First all cells of a group are prepared for inversion, one per lane, and their candidate grid
// points are listed. Then the listed voxels are solved, one per lane, and every lane gathers the
// data of its cell from the rows below: so lanes are full for any number of voxels per cell.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "resample/cell_kernel.h"

namespace pliant {

/// Maximum number of voxels along one axis of a cell's bounding box; larger cells are slow.
inline constexpr int kMaxAlong = 4;
inline constexpr int kMaxCandidates = kMaxAlong * kMaxAlong * kMaxAlong;

/// Maximum number of steps of s ← s₁ − G(s); a cell that has not converged by then is slow.
inline constexpr int kMaxSteps = 40;
inline constexpr int kNewtonSteps = 16;  ///< likewise, for strongly bent cells

/// Number of steps from which on convergence is tested; fewer are always executed.
inline constexpr std::size_t kWatched = 5;

/// Number of steps that all voxels of a vector execute if any of them needs one.
inline constexpr std::size_t kFlatSteps = 2;

/// Data of a cell during the solution of its voxels: the rows of CellRows.
enum Row {
    kRowJ = 0,          ///< J⁻¹, by columns
    kRowG = 9,          ///< coefficients of G: xy, xz, yz, xyz, each with three components
    kRowS = 21,         ///< s₁ of the first grid point in the bounding box
    kRowBend = 24,      ///< bound of |G|
    kRowValue = 25,     ///< original values at the corners
    kRowBegin = 33,     ///< the same point, from the cell's lowest corner on
    kRowPosition = 36,  ///< the same point, from the strip's origin on
    kRowVoxel = 39,     ///< its voxel's index, bits of a whole number
    kRowCount = 40,
};

/// Number of stored groups of cells: one in preparation, the two before, whose voxels are solved
/// together in full vectors, and one more for a power of two.
inline constexpr unsigned kKeptGroups = 4;

/// Cells of a group that lie in a row, usually a brick's; the other half may be in another row.
inline constexpr int kHalfGroup = kCellGroup / 2;

struct CellRows {
    static constexpr int kLanes = kKeptGroups * kCellGroup;
    alignas(64) float row[kRowCount][kLanes];
    int first_cell[kKeptGroups][2];  ///< of both halves of a group

    int cell_of(int lane) const {
        return first_cell[lane / kCellGroup][lane % kCellGroup / kHalfGroup] + lane % kHalfGroup;
    }
};

/// Voxels to be solved, in order, each with the lane in CellRows and the candidate, which is i +
/// 4·j + 16·k steps from the first one. They are solved one group after they were listed, since
/// reading memory as a whole right after writing it in pieces stalls.
struct Waiting {
    static constexpr int kCapacity = 4 * kCellGroup * kMaxCandidates;
    static constexpr int kFew = 256;
    alignas(64) std::int32_t item[kCapacity + kCellGroup];
    int begin = 0;   ///< first unsolved voxel
    int oldest = 0;  ///< end of voxels from groups before the last but one …
    int last = 0;    ///< … and of voxels from groups before the latest
    int end = 0;
};
inline constexpr int kLaneBits = 6;  ///< bits of an item for the lane in CellRows
static_assert(1u << kLaneBits == kKeptGroups * kCellGroup);
constexpr std::int32_t item_of(unsigned lane, int i, int j, int k) {
    return std::int32_t(lane) | i << kLaneBits | j << (kLaneBits + 2) | k << (kLaneBits + 4);
}

/// Solution of a vector of voxels.
struct Solved {
    alignas(64) std::int32_t voxel[kCellGroup];  ///< index, from the strip's origin on
    alignas(64) std::int32_t whole[kCellGroup];  ///< rounded value, for 16-bit targets
    alignas(64) float value[kCellGroup];         ///< value, for other targets
    alignas(64) float back[3][kCellGroup];       ///< φ⁻¹(p) − p, without the strip's shift

    /// φ⁻¹(p) − p [voxels], if it was requested
    Vec3f back_of(int lane, Vec3f shift) const {
        return {back[0][lane] - shift.x, back[1][lane] - shift.y, back[2][lane] - shift.z};
    }
};

/// Data common to all cells of a strip.
struct StripTarget {
    Vec3f low, high;          ///< first and last voxel of the target's box, from the origin on
    bool is_inside;           ///< whether the reach of the strip lies in the box
    std::int32_t row, slice;  ///< voxel strides
    std::ptrdiff_t origin;    ///< index of the strip's origin
    Vec3f shift;              ///< of the origin
    float high_slack;
    bool is_16_bit, with_inverse;
};

/// Largest bound of |G| [units of s] for which n steps leave an error below `settled`: the rate of
/// contraction on the way is at most 2·bend·(1 + 2·bend)².
constexpr std::array<float, kWatched> bends_by_steps(double settled) {
    std::array<float, kWatched> bends{};
    for (int n = 0; n < int(kWatched); ++n) {
        double low = 0, high = 0.19;
        for (int bisection = 0; bisection < 40; ++bisection) {
            const double bend = 0.5 * (low + high);
            double error = bend;
            for (int step = 0; step < n; ++step)
                error *= 2 * bend * (1 + 2 * bend) * (1 + 2 * bend);
            (error <= settled ? low : high) = bend;
        }
        bends[std::size_t(n)] = float(low);
    }
    return bends;
}

}  // namespace pliant
