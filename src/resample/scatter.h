// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Brings a deformed scan up to date with the lattice: finds the bricks of the scan that have to be
// written again, opens the voxels in them that can change, lets strips of cells write those, and
// fills what no cell covers with air.

#pragma once

#include <pliant/resample.h>

#include <vector>

#include "resample/dirty.h"
#include "resample/strip_writer.h"

namespace pliant {

/// Voxels that can change.
struct OpenVoxels {
    std::int64_t count = 0;
    Box3i box;  ///< that holds them all
};

class Scatter {
  public:
    /// Keeps references. @param original  stays as it is; what is written starts as its copy
    Scatter(const Volume& original, const TaskArena& arena);

    /// Finds what has to be written. @returns the voxels that can change, in those bricks
    OpenVoxels look(const Lattice& lattice, Mapping mapping, Volume& deformed);
    /// Writes it. @param inverse_mm  over inverse_box; may be null
    /// @returns the number of gaps
    std::int64_t write(const Lattice& lattice, Mapping mapping, Volume& deformed, Vec3f* inverse_mm,
                       const Box3i& inverse_box);

    /// Sets φ⁻¹(p) − p to zero where write() will write, over the whole scan: for fields that are
    /// kept from one update to the next. To be called between look() and write().
    void clear_inverse(const Lattice& lattice, Vec3f* inverse_mm);
    /// The next look() takes everything that is deformed for new.
    void forget() { m_now = {}; }
    /// Puts back the scan's voxels, also after look() or write() has thrown, and sets inverse_mm to
    /// zero there. The next pair of calls writes all that is deformed, and its boxes hold the
    /// bricks that were put back as well. Allocates nothing.
    /// @param inverse_mm  over the whole scan; may be null
    void start_over(Volume& deformed, Vec3f* inverse_mm) noexcept;
    const Snapshot& snapshot() const { return m_now.snapshot; }

    /// Boxes of voxels that the last update wrote: whole bricks, cut to the scan.
    const std::vector<Box3i>& written_boxes() const { return m_boxes; }

  private:
    void write_each_once(const ScatterJob& job, const CellTarget& target);
    void write_slabs(const ScatterJob& job, const CellTarget& target);
    bool open_contested(const ScatterJob& job, const CellTarget& target);
    void claim(const ScatterJob& job, const CellTarget& target, ClaimPass pass);
    std::int64_t write_claims(const CellTarget& target);
    void list_strips(const Lattice& lattice);
    void note_dirty();
    void list_boxes(int brick_size);
    void add_box(Vec3i brick, int brick_size);
    template <class Work>
    void for_dirty(const Work& work);
    template <class Work>
    void for_writers(const Work& work);
    CellTarget target_of(Volume& deformed);
    ScatterJob job_of(const Lattice& lattice, Mapping mapping) const;

    const Volume& m_original;
    const TaskArena& m_arena;
    Motion m_now, m_before;
    Dirty m_dirty;
    std::vector<ReachingStrip> m_strips;
    std::vector<StripWriter> m_writers;  ///< one for each thread
    std::vector<Claim> m_claims;
    std::int64_t m_opened = 0;  ///< voxels, by the last look()
    OpenBoxes m_open_boxes;
    OpenMap m_open;
    /// Per brick of the scan: it differs from the scan, or an update that failed began to write it.
    std::vector<std::uint8_t> m_differs;
    /// Likewise, of bricks that were put back since the last update.
    std::vector<std::uint8_t> m_put_back;
    bool m_has_put_back = false;
    std::vector<Box3i> m_boxes;
};

#pragma GCC visibility push(default)  // for other components
Deformed deform_by_lattice(const Volume& original, const Lattice& lattice, Mapping mapping,
                           bool with_inverse, const TaskArena& arena);
#pragma GCC visibility pop

}  // namespace pliant
