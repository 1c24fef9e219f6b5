// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes voxels, strip by strip of cells.
//
// In a lattice without gaps and folded cells, φ maps the scan to itself one to one, and every voxel
// lies in one cell (half-open cells divide the faces among them). So all threads take strips in
// turn, each strip once, without conflicts. If there are folded cells, a voxel in several cells
// lies in a folded one too (a voxel is covered once more with positive orientation than with
// negative): the boxes around folded cells are contested, and opened again.
//
// Beside cuts and carved cells, other voxels can lie in several cells, too. Then each thread owns
// some layers of the scan, visits the strips that reach into them, and marks voxels that two cells
// hold: these are contested, too.
//
// The few remaining open voxels, contested ones and those not taken by any cell, are
// claimed. Again threads take strips in turn, but only record the cell and the value for each
// voxel. Of all claims on a voxel, the first cell's in one fixed order is written. So the result
// depends neither on the number of threads nor on the order of writes.

#pragma once

#include <algorithm>
#include <atomic>
#include <vector>

#include "resample/cell_kernel.h"
#include "resample/open_voxels.h"

namespace pliant {

/// First strip that no thread has taken yet.
using NextStrip = std::atomic<std::size_t>;

/// Strips that several threads share out. A thread takes large portions at first and smaller ones
/// later. So all finish together, and yet work far from each other most of the time. Adjacent
/// strips write to the same cache lines, which move to and fro between the cores' caches when two
/// threads write them at once.
class StripQueue {
  public:
    StripQueue(std::size_t strips, std::size_t threads)
        : m_end(strips), m_parts(2 * std::max<std::size_t>(threads, 1)) {}
    /// Takes a portion: first to end. @returns whether any strips were left
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

/// How cells claim open voxels. For cells that the kernel can invert, tetrahedra give practically
/// the same result: with these they claim shared voxels only.
struct ClaimPass {
    Mapping mapping;
    CellFaces faces;
};

/// For each voxel of a box, the first cell of a strip that surely holds it: later cells' claims
/// would lose. Notes nothing in a box that is too large.
class FirstCells {
  public:
    void begin(const Box3i& box) {
        m_box = box;
        const std::size_t count = dense_count(box.end - box.begin);
        m_cell.assign(count <= kMostVoxels ? count : 0, INT32_MAX);
    }
    /// @pre p is in the box
    bool is_before(Vec3i p, int cell) const { return !m_cell.empty() && m_cell[index(p)] < cell; }
    void note(Vec3i p, int cell) {
        if (m_cell.empty()) return;
        std::int32_t& first = m_cell[index(p)];
        first = std::min(first, cell);
    }

  private:
    static constexpr std::size_t kMostVoxels = 1 << 17;

    std::size_t index(Vec3i p) const {
        return dense_index(p - m_box.begin, m_box.end - m_box.begin);
    }

    Box3i m_box;
    std::vector<std::int32_t> m_cell;
};

class StripWriter {
  public:
    /// Writes strips until none are left. Voxels on edges remain as claims, and boxes around cells
    /// that may be folded, cut into bricks, as contested().
    void write_each_once(const ScatterJob& job, const CellTarget& target, StripQueue& queue);

    /// Writes target.box from all strips that reach it, including other threads' strips.
    void write_each_once(const ScatterJob& job, const CellTarget& target);

    /// The readable twin: each voxel of target.box is written by the first cell that holds it.
    void write_in_order(const ScatterJob& job, const CellTarget& target);

    /// Claims open voxels for cells of strips, until none are left.
    void claim(const ScatterJob& job, const CellTarget& target, const OpenBoxes& open,
               ClaimPass pass, NextStrip& next);

    /// Claims of all calls since the last forget().
    const std::vector<Claim>& claims() const { return m_left.claims; }
    const std::vector<Box3i>& contested() const { return m_contested; }
    /// Number of open voxels that were written. Voxels in contested boxes may count twice.
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
    std::array<Vec3d, 8> corners_of(const Field& field, int cell) const;
    Box3i box_of(int cell) const;
    void contest(const Box3i& voxels, int brick_size);
    void note_next(const ScatterJob& job, const CellTarget& target, std::size_t strip);

    StripNodes m_strip;
    Leftovers m_left;
    Ahead m_ahead;
    FirstCells m_first;  ///< of the strip that is claiming
    std::vector<Box3i> m_contested, m_open;
};

}  // namespace pliant
