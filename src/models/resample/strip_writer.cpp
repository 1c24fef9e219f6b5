// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/strip_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "field/cell_block.h"
#include "field/tetrahedra.h"
#include "field/trilinear_cell.h"

namespace pliant {
namespace {

constexpr double kOnFace = 1e-9;           ///< tolerance of barycentric coordinates
constexpr float kBoxSlack = 1e-3f;         ///< for single-precision rounding [voxels]
constexpr std::size_t kMaxFetched = 8192;  ///< voxels around a strip

constexpr std::array<Vec3d, 8> kRestCorners = {
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}};

/// Box of the voxels that may lie in a cell. @param points  its corners, relative to `first`
Box3i voxels_around(const std::array<Vec3d, 8>& points, Vec3i first) {
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        double low = points[0][a], high = points[0][a];
        for (const Vec3d& p : points) low = std::min(low, p[a]), high = std::max(high, p[a]);
        box.begin[a] = first[a] + int(std::ceil(low - kOnFace));
        box.end[a] = first[a] + int(std::floor(high + kOnFace)) + 1;
    }
    return box;
}

bool reaches_dirty_brick(const ScatterJob& job, const Box3i& voxels) {
    const Box3i bricks = bricks_of(voxels, job.field.brick_size());
    for (int z = bricks.begin.z; z < bricks.end.z; ++z)
        for (int y = bricks.begin.y; y < bricks.end.y; ++y)
            for (int x = bricks.begin.x; x < bricks.end.x; ++x)
                if (job.dirty[dense_index({x, y, z}, job.bricks)]) return true;
    return false;
}

std::array<double, 8> corner_values(const Volume& original, Vec3i cell) {
    std::array<double, 8> values{};
    const Box3i scan = voxel_box(original.grid);
    std::visit(
        [&](const auto& voxels) {
            for (int c = 0; c < 8; ++c) {
                const Vec3i e = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2};
                values[std::size_t(c)] = contains(scan, e)
                                             ? double(voxels[voxel_index(original.grid, e)])
                                             : double(original.background);
            }
        },
        original.voxels);
    return values;
}

/// Source of a voxel: its position in the cell at rest, and the value there.
struct Source {
    Vec3d t;
    double value;
};

std::optional<Source> find_source(const std::array<Vec3d, 8>& corners, const TrilinearCell& map,
                                  const Volume& original, Vec3i cell, Vec3d p, Mapping mapping) {
    if (mapping == Mapping::Tetrahedra) {
        const auto where = locate_in_tetrahedra(corners, p, kOnFace);
        if (!where) return std::nullopt;
        return Source{combine(*where, kRestCorners),
                      combine(*where, corner_values(original, cell))};
    }
    const auto t = map.locate(p);
    if (!t) return std::nullopt;
    return Source{*t, interpolate(corner_values(original, cell), *t)};
}

}  // namespace

void StripWriter::forget_leftovers() {
    m_left.unsettled.clear();
    m_left.slow.clear();
    m_left.folded.clear();
}

bool StripWriter::load(const ScatterJob& job, const ReachingStrip& strip,
                       std::span<const Box3i> within) {
    return m_strip.load(job.snapshot, job.touched, job.field, job.original, strip.coord,
                        strip.reach, within);
}

void StripWriter::write_each_once(const ScatterJob& job, const CellTarget& target,
                                  StripQueue& queue) {
    for (std::size_t n, end; queue.take(n, end);)
        for (; n < end; ++n) write_once(job, target, n);
}

void StripWriter::write_each_once(const ScatterJob& job, const CellTarget& target) {
    for (std::size_t n = 0; n < job.strips.size(); ++n) write_once(job, target, n);
}

void StripWriter::write_once(const ScatterJob& job, const CellTarget& target, std::size_t n) {
    const ReachingStrip& strip = job.strips[n];
    const Box3i reach = overlap(strip.voxels, target.box);
    if (is_empty(reach) || !reaches_dirty_brick(job, reach) || !load(job, strip, {&target.box, 1}))
        return;
    const int size = job.field.brick_size();
    if (m_strip.is_wild()) {
        contest(reach, size);
        return;
    }
    m_left.writes = Writes::AllButEdges;
    m_left.strip = int(n);
    forget_leftovers();
    note_next(job, target, n + 1);
    write_cells(m_strip, target, CellFaces::HalfOpen, m_left, m_ahead);
    for (const int cell : m_left.folded) contest(overlap(box_of(cell), target.box), size);
}

/// Queues displacements that a strip will read, and voxels that it may write. The original's rows
/// are contiguous for consecutive strips, and are left to the hardware prefetcher.
void StripWriter::note_next(const ScatterJob& job, const CellTarget& target, std::size_t n) {
    m_ahead.clear();
    if (n >= job.strips.size()) return;
    m_strip.note(job.snapshot, job.strips[n].coord, m_ahead);
    Box3i box = overlap(job.strips[n].voxels, target.box);
    if (is_empty(box) || dense_count(box.end - box.begin) > kMaxFetched) return;
    // Lines are longer than strips: this strip has fetched most of the next one's.
    const Vec3i way = job.strips[n].coord - job.strips[n - 1].coord;
    const bool is_beside = way.y == 0 && way.z == 0;
    if (is_beside) box.begin.x = std::max(box.begin.x, job.strips[n - 1].voxels.end.x);
    if (is_empty(box)) return;
    const auto count = std::size_t(box.end.x - box.begin.x);
    for_each_row(box, [&](Vec3i p) {
        const std::ptrdiff_t at = voxel_at(target, p);
        const auto want = [&](const auto* row) {
            if (is_beside)
                m_ahead.want_on(row + at, count * sizeof(*row));
            else
                m_ahead.want(row + at, count * sizeof(*row));
        };
        want(target.open);
        if (target.voxels16)
            want(target.voxels16);
        else
            want(target.voxels32);
    });
}

/// Adds a box's parts in each brick to the contested ones.
void StripWriter::contest(const Box3i& voxels, int brick_size) {
    if (is_empty(voxels)) return;
    for_each_in(bricks_of(voxels, brick_size), [&](Vec3i brick) {
        const Vec3i first = brick_size * brick;
        m_contested.push_back(
            overlap(voxels, {first, first + Vec3i{brick_size, brick_size, brick_size}}));
    });
}

void StripWriter::write_in_order(const ScatterJob& job, const CellTarget& target) {
    m_left.writes = Writes::AllButEdges;
    for (const ReachingStrip& strip : job.strips) {
        const Box3i reach = overlap(strip.voxels, target.box);
        if (is_empty(reach) || !reaches_dirty_brick(job, reach) ||
            !load(job, strip, {&target.box, 1}))
            continue;
        write_all_cells(job, target, job.mapping);
    }
}

void StripWriter::claim(const ScatterJob& job, const CellTarget& target, const OpenBoxes& open,
                        ClaimPass pass, NextStrip& next) {
    m_left.writes = Writes::None;
    CellTarget part = target;
    for (std::size_t n; (n = next.fetch_add(1)) < job.strips.size();) {
        const ReachingStrip& strip = job.strips[n];
        open.within(strip.voxels, m_open);
        if (m_open.empty() || !load(job, strip, m_open)) continue;
        part.box = m_open[0];
        for (const Box3i& box : m_open) part.box = hull(part.box, box);
        m_left.strip = int(n);
        m_first.begin(part.box);
        if (m_strip.is_wild() || job.mapping != Mapping::Cells) {
            write_all_cells(job, part, pass.mapping);
            continue;
        }
        const std::size_t count = m_left.claims.size();
        forget_leftovers();
        m_ahead.clear();
        write_cells(m_strip, part, pass.faces, m_left, m_ahead);
        if (pass.mapping == Mapping::Tetrahedra) {
            m_left.claims.resize(count);
            if (any_shared(part, part.box)) write_shared(job, part, pass.mapping);
        }
        for (std::size_t c = count; c < m_left.claims.size(); ++c) {
            const Claim& claim = m_left.claims[c];
            if (!claim.is_edge) m_first.note(voxel_position(part, claim.voxel), claim.cell);
        }
        write_leftovers(job, part, pass.mapping);
    }
}

/// Writes the voxels that the kernel did not settle.
void StripWriter::write_leftovers(const ScatterJob& job, const CellTarget& target,
                                  Mapping mapping) {
    for (const int cell : m_left.slow) {
        const Box3i box = overlap(box_of(cell), target.box);
        if (!is_empty(box) && any_open(target, box)) write_cell(job, target, mapping, cell);
    }
    CellTarget one = target;
    for (const Leftovers::Unsettled& left : m_left.unsettled) {
        const Vec3i voxel = voxel_position(target, left.voxel);
        one.box = {voxel, voxel + Vec3i{1, 1, 1}};
        write_cell(job, one, mapping, left.cell);
    }
}

void StripWriter::write_all_cells(const ScatterJob& job, const CellTarget& target,
                                  Mapping mapping) {
    const auto use = m_strip.use();
    for (std::size_t r = 0; r < use.size(); ++r)
        for (RowBits bits = use[r]; bits; bits &= bits - 1)
            write_cell(job, target, mapping,
                       m_strip.index(std::countr_zero(bits), int(r) % m_strip.size(),
                                     int(r) / m_strip.size()));
}

void StripWriter::write_shared(const ScatterJob& job, const CellTarget& target, Mapping mapping) {
    const auto use = m_strip.use();
    for (std::size_t r = 0; r < use.size(); ++r)
        for (RowBits bits = use[r]; bits; bits &= bits - 1) {
            const int cell = m_strip.index(std::countr_zero(bits), int(r) % m_strip.size(),
                                           int(r) / m_strip.size());
            const Box3i box = overlap(box_of(cell), target.box);
            if (!is_empty(box) && any_shared(target, box))
                write_cell(job, target, mapping, cell, true);
        }
}

/// Box of the voxels that may lie in a cell, possibly one larger, from single precision.
Box3i StripWriter::box_of(int cell) const {
    Box3i box;
    const Vec3i first = m_strip.origin() + m_strip.local(cell);
    const int row = m_strip.row(), slice = m_strip.slice();
    const int corner[8] = {0, 1, row, row + 1, slice, slice + 1, slice + row, slice + row + 1};
    for (int a = 0; a < 3; ++a) {
        const float* u = m_strip.eighth_u(a) + cell;
        float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
        for (int c = 0; c < 8; ++c) {
            const int side = c >> a & 1;
            low[side] = std::min(low[side], u[corner[c]]);
            high[side] = std::max(high[side], u[corner[c]]);
        }
        const float least = std::min(8 * low[0], 8 * low[1] + 1);
        const float most = std::max(8 * high[0], 8 * high[1] + 1);
        box.begin[a] = first[a] + int(std::ceil(least - kBoxSlack));
        box.end[a] = first[a] + int(std::floor(most + kBoxSlack)) + 1;
    }
    return box;
}

/// Corners relative to the cell's lowest corner at rest [voxels].
std::array<Vec3d, 8> StripWriter::corners_of(const Field& field, int cell) const {
    const Vec3d scale = voxels_per_unit(field.grid());
    const Vec3i first = m_strip.local(cell);
    std::array<Vec3d, 8> points;
    for (int c = 0; c < 8; ++c) {
        const Vec3i corner{c & 1, c >> 1 & 1, c >> 2};
        const Vec3<Fixed> u = m_strip.displacement(first + corner);
        for (int a = 0; a < 3; ++a) points[std::size_t(c)][a] = corner[a] + scale[a] * u[a];
    }
    return points;
}

/// The readable twin of the kernel: one cell, in double precision.
void StripWriter::write_cell(const ScatterJob& job, const CellTarget& target, Mapping mapping,
                             int cell, bool only_shared) {
    const Vec3i first = m_strip.first_element() + m_strip.local(cell);
    const std::array<Vec3d, 8> points = corners_of(job.field, cell);
    const Box3i candidates = overlap(voxels_around(points, first), target.box);
    if (is_empty(candidates) || !any_open(target, candidates)) return;
    const CellPlanes planes(points);
    const TrilinearCell map(points);
    const bool claims = m_left.writes == Writes::None;
    for_each_in(candidates, [&](Vec3i p) {
        const Vec3i d = p - first;
        const Vec3d position{double(d.x), double(d.y), double(d.z)};
        const Open open = *open_at(target, p);
        if (!target.turn.is_open(open) || (only_shared && open != target.turn.shared()) ||
            (claims && m_first.is_before(p, cell)) || !planes.may_hold(position))
            return;
        const auto source = find_source(points, map, job.original, first, position, mapping);
        if (!source) return;
        const Claim claim{
            voxel_at(target, p),
            false,
            m_left.strip,
            cell,
            source->value,
            {float(source->t.x - d.x), float(source->t.y - d.y), float(source->t.z - d.z)}};
        if (claims) {
            m_left.claims.push_back(claim);
            m_first.note(p, cell);
        } else {
            write_claim(claim, target);
        }
    });
}

}  // namespace pliant
