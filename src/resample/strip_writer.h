// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes voxels, strip by strip of cells.
//
// Where the lattice hangs together and no cell is folded, φ maps the scan to itself one to one, and
// every voxel lies in one cell (on faces, half-open cells share out). So all threads take strips as
// they come, each strip once, and nobody meets. If there are folded cells, whatever lies in several
// cells lies in a folded one too (a voxel is covered once more from the right side than from the
// wrong one): the boxes around those are contested, and opened again.
//
// Beside cuts and carved cells, more may lie in several cells. Then each thread has some layers of
// the scan, visits the strips that reach into them, and marks what two cells hold: that is
// contested, too.
//
// Open voxels that are few, contested ones and those that no cell took for its own, are claimed:
// again threads take strips as they come, but only say which cell would write what. Of all claims
// on a voxel, the first cell's in one fixed order is written. So the result depends neither on the
// number of threads nor on what was written when.

#pragma once

#include <algorithm>
#include <atomic>
#include <vector>

#include "resample/cell_kernel.h"
#include "resample/open_voxels.h"

namespace pliant {

/// Strips that nobody has taken yet: those from here on.
using NextStrip = std::atomic<std::size_t>;

/// Strips that several threads share out. Who comes takes much at first and less and less later:
/// so all are ready at once, and yet work far from each other most of the time. Strips that lie
/// side by side write to the same lines of memory, which go to and fro between the processors'
/// caches when two threads write them at once.
class StripQueue {
  public:
    StripQueue(std::size_t strips, std::size_t threads)
        : m_end(strips), m_parts(2 * std::max<std::size_t>(threads, 1)) {}
    /// Takes some: first to end. @returns whether any were left
    bool take(std::size_t& first, std::size_t& end) {
        first = m_next;
        do {
            const std::size_t left = m_end - first;
            end = first + std::min(std::max(left / m_parts, kLeast), left);
        } while (!m_next.compare_exchange_weak(first, end));
        return first < end;
    }

  private:
    static constexpr std::size_t kLeast = 4;
    std::atomic<std::size_t> m_next = 0;
    const std::size_t m_end, m_parts;
};

/// How cells claim what is open. Cells that the kernel can invert lie in their tetrahedra as well
/// as anybody needs: by those they claim what is shared, and no more.
struct ClaimPass {
    Mapping mapping;
    CellFaces faces;
};

class StripWriter {
  public:
    /// Writes strips until none are left. Voxels on edges stay behind as claims, and boxes around
    /// cells that may be folded, cut into bricks, as contested().
    void write_each_once(const ScatterJob& job, const CellTarget& target, StripQueue& queue);

    /// Likewise, writes target.box from all strips that reach it, which are other threads' too.
    void write_each_once(const ScatterJob& job, const CellTarget& target);

    /// The readable twin: each voxel of target.box is written by the first cell that holds it.
    void write_in_order(const ScatterJob& job, const CellTarget& target);

    /// Claims what is open from strips, until none are left.
    void claim(const ScatterJob& job, const CellTarget& target, const OpenBoxes& open,
               ClaimPass pass, NextStrip& next);

    /// Of all calls since the last forget().
    const std::vector<Claim>& claims() const { return m_left.claims; }
    const std::vector<Box3i>& contested() const { return m_contested; }
    /// Voxels that were open and are written. What lies in contested boxes may count twice.
    std::int64_t written() const { return m_left.written; }
    void forget() {
        m_left.written = 0;
        m_left.claims.clear();
        m_contested.clear();
    }

  private:
    void forget_leftovers();
    void write_once(const ScatterJob& job, const CellTarget& target, std::size_t strip);
    bool load(const ScatterJob& job, const ReachingStrip& strip, std::span<const Box3i> within);
    void write_leftovers(const ScatterJob& job, const CellTarget& target, Mapping mapping);
    void write_all_cells(const ScatterJob& job, const CellTarget& target, Mapping mapping);
    void write_shared(const ScatterJob& job, const CellTarget& target, Mapping mapping);
    void write_cell(const ScatterJob& job, const CellTarget& target, Mapping mapping, int cell,
                    bool only_shared = false);
    std::array<Vec3d, 8> corners_of(const Lattice& lattice, int cell) const;
    Box3i box_of(int cell) const;
    void contest(const Box3i& voxels, int brick_size);
    void note_next(const ScatterJob& job, const CellTarget& target, std::size_t strip);

    StripNodes m_strip;
    Leftovers m_left;
    Ahead m_ahead;
    std::vector<Box3i> m_contested, m_open;
};

}  // namespace pliant
