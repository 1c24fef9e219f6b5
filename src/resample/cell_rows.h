// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What the vector kernel keeps of its cells and voxels between its two stages.
//
// First all cells of a group are made ready for inversion, a lane each, and the grid points that
// may lie in them are listed. Then the listed voxels are solved, a lane each, and every lane
// fetches what it needs of its cell from the rows below: so lanes are full however many voxels the
// single cells hold.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "resample/cell_kernel.h"

namespace pliant {

/// Voxels along one axis of a cell's bounding box; a cell with more is slow.
inline constexpr int kMaxAlong = 4;
inline constexpr int kMaxCandidates = kMaxAlong * kMaxAlong * kMaxAlong;

/// Steps of s ← s₁ − G(s) after which a cell that has not settled is slow.
inline constexpr int kMaxSteps = 40;
inline constexpr int kNewtonSteps = 16;  ///< of strongly bent cells, likewise

/// Steps from which on is watched whether they still move s; fewer are simply taken.
inline constexpr std::size_t kWatched = 5;

/// Steps that are taken by all voxels of a vector if any of them needs one.
inline constexpr std::size_t kFlatSteps = 2;

/// What is kept of a cell while its voxels are solved: the rows of CellRows.
enum Row {
    kRowJ = 0,       ///< J⁻¹, by columns
    kRowG = 9,       ///< coefficients of G: xy, xz, yz, xyz, each with three components
    kRowS = 21,      ///< s₁ of the first grid point in the bounding box
    kRowBend = 24,   ///< bound of |G|
    kRowValue = 25,  ///< original values at the corners
    kRowBegin = 33,  ///< that grid point, from the cell's lowest corner on
    kRowPlace = 36,  ///< and from the strip's origin on
    kRowVoxel = 39,  ///< its index, bits of a whole number
    kRowCount = 40,
};

/// Groups of cells that are kept: one that is made ready, the two before, whose voxels are solved
/// together in full vectors, and one more to make it a power of two.
inline constexpr unsigned kKeptGroups = 4;

/// Cells of a group that lie in a row; the other half may be in another row. A brick's row, mostly.
inline constexpr int kHalfGroup = kCellGroup / 2;

struct CellRows {
    static constexpr int kLanes = kKeptGroups * kCellGroup;
    alignas(64) float row[kRowCount][kLanes];
    int first_cell[kKeptGroups][2];  ///< of both halves of a group

    int cell_of(int lane) const {
        return first_cell[lane / kCellGroup][lane % kCellGroup / kHalfGroup] + lane % kHalfGroup;
    }
};

/// Voxels to be solved, first to last, each with the lane in CellRows and the candidate, which is
/// i + 4·j + 16·k steps from the first one. They are solved a group later than listed: memory that
/// was written in pieces takes a while until it can be read as a whole.
struct Waiting {
    static constexpr int kCapacity = 4 * kCellGroup * kMaxCandidates;
    static constexpr int kFew = 256;
    alignas(64) std::int32_t item[kCapacity + kCellGroup];
    int begin = 0;   ///< of those that are not solved yet
    int oldest = 0;  ///< end of those from groups before the last but one …
    int last = 0;    ///< … and of those from groups before the latest
    int end = 0;
};
inline constexpr int kLaneBits = 6;  ///< of an item: lane in CellRows
static_assert(1u << kLaneBits == kKeptGroups * kCellGroup);
constexpr std::int32_t item_of(unsigned lane, int i, int j, int k) {
    return std::int32_t(lane) | i << kLaneBits | j << (kLaneBits + 2) | k << (kLaneBits + 4);
}

/// What was found out of a vector of voxels.
struct Solved {
    alignas(64) std::int32_t voxel[kCellGroup];  ///< index, from the strip's origin on
    alignas(64) std::int32_t whole[kCellGroup];  ///< value, rounded: of 16-bit targets
    alignas(64) float value[kCellGroup];         ///< of others
    alignas(64) float back[3][kCellGroup];       ///< φ⁻¹(p) − p, but for the strip's shift

    /// φ⁻¹(p) − p [voxels], if it was wanted
    Vec3f back_of(int lane, Vec3f shift) const {
        return {back[0][lane] - shift.x, back[1][lane] - shift.y, back[2][lane] - shift.z};
    }
};

/// What is the same for all cells of a strip.
struct StripTarget {
    Vec3f low, high;          ///< first and last voxel of the target's box, from the origin on
    bool is_inside;           ///< all that the strip reaches lies in the box
    std::int32_t row, slice;  ///< voxels from one row, one layer, to the next
    std::ptrdiff_t origin;    ///< index of the strip's origin
    Vec3f shift;              ///< of the origin
    float high_slack;
    bool is_16_bit, with_inverse;
};

/// Largest bound of |G| [units of s] with which n steps leave an error below `settled`: the rate of
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
