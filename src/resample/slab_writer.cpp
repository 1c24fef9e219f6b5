// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/slab_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "chainmail/cell_block.h"
#include "chainmail/tetrahedra.h"
#include "resample/trilinear_cell.h"

namespace pliant {
namespace {

constexpr double kOnFace = 1e-9;    ///< tolerance of barycentric coordinates
constexpr float kBoxSlack = 1e-3f;  ///< of single precision [voxels]
constexpr std::size_t kStripsAtOnce = 4;

constexpr std::array<Vec3d, 8> kRestCorners = {
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}};

Box3i overlap(const Box3i& a, const Box3i& b) {
    Box3i both;
    for (int axis = 0; axis < 3; ++axis) {
        both.begin[axis] = std::max(a.begin[axis], b.begin[axis]);
        both.end[axis] = std::min(a.end[axis], b.end[axis]);
    }
    return both;
}

Box3i box_of_brick(const Lattice& lattice, Vec3i coord) {
    const int size = lattice.brick_size();
    const Vec3i first = size * coord;
    return overlap({first, first + Vec3i{size, size, size}}, voxel_box(lattice.grid()));
}

std::ptrdiff_t voxel_at(const CellTarget& target, Vec3i p) {
    return p.x +
           std::ptrdiff_t(target.grid_size.x) * (p.y + std::ptrdiff_t(target.grid_size.y) * p.z);
}
std::uint8_t* open_at(const CellTarget& target, Vec3i p) {
    return target.open + voxel_at(target, p);
}
RowBits low_bits(int count) {
    return (RowBits(1) << count) - 1;
}
void open_row(const CellTarget& target, Vec3i p, int count, RowBits bits) {
    std::uint8_t* open = open_at(target, p);
    // Eight bits become eight bytes: byte i keeps bit i of its copy, and any bit of it becomes 1.
    static_assert(std::endian::native == std::endian::little);
    for (; count >= 8; count -= 8, open += 8, bits >>= 8) {
        const RowBits kept = (bits & 0xff) * 0x0101010101010101u & 0x8040201008040201u;
        const RowBits bytes = (kept + 0x7f7f7f7f7f7f7f7fu) >> 7 & 0x0101010101010101u;
        std::memcpy(open, &bytes, 8);
    }
    for (int x = 0; x < count; ++x) open[x] = bits >> x & 1;
}
bool any_open_in_row(const std::uint8_t* open, int count) {
    RowBits any = 0, eight;
    for (; count >= 8; count -= 8, open += 8) {
        std::memcpy(&eight, open, 8);
        any |= eight;
    }
    for (; count > 0; --count) any |= *open++;
    return any != 0;
}

template <class Visit>
void for_each_row(const Box3i& box, const Visit& visit) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y) visit(Vec3i{box.begin.x, y, z});
}

bool any_open(const CellTarget& target, const Box3i& box) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            if (any_open_in_row(open_at(target, {box.begin.x, y, z}), box.end.x - box.begin.x))
                return true;
    return false;
}

template <class Visit>
void for_each_in(const Box3i& box, const Visit& visit) {
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x) visit(Vec3i{x, y, z});
}

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
    const int size = job.lattice.brick_size();
    for (int z = voxels.begin.z / size; z <= (voxels.end.z - 1) / size; ++z)
        for (int y = voxels.begin.y / size; y <= (voxels.end.y - 1) / size; ++y)
            for (int x = voxels.begin.x / size; x <= (voxels.end.x - 1) / size; ++x)
                if (job.dirty[std::size_t(x + job.bricks.x * (y + job.bricks.y * z))]) return true;
    return false;
}

void put_back(const CellTarget& target, const Volume& original, Vec3i p, int count) {
    const std::size_t at = voxel_index(original.grid, p);
    std::visit(
        [&]<class T>(const VoxelArray<T>& voxels) {
            if constexpr (std::is_integral_v<T>)
                std::copy_n(voxels.data() + at, count, target.voxels16 + at);
            else
                std::copy_n(voxels.data() + at, count, target.voxels32 + at);
        },
        original.voxels);
}

void store(const CellTarget& target, Vec3i p, double value) {
    const std::ptrdiff_t at = voxel_at(target, p);
    if (target.voxels16)
        target.voxels16[at] = std::int16_t(std::lrint(value));
    else
        target.voxels32[at] = float(value);
}

std::array<double, 8> corner_values(const Volume& original, Vec3i cell) {
    std::array<double, 8> values{};
    for (int c = 0; c < 8; ++c) {
        const Vec3i e = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        values[std::size_t(c)] =
            contains(voxel_box(original.grid), e) ? double(original.at(e)) : double(kAirHu);
    }
    return values;
}

/// Where a voxel comes from: its value, and its place in the cell at rest.
struct Source {
    double value;
    Vec3d t;
};

std::optional<Source> find_source(const std::array<Vec3d, 8>& corners, const TrilinearCell& map,
                                  const std::array<double, 8>& values, Vec3d p, Mapping mapping) {
    if (mapping == Mapping::Tetrahedra) {
        const auto where = locate_in_tetrahedra(corners, p, kOnFace);
        if (!where) return std::nullopt;
        return Source{combine(*where, values), combine(*where, kRestCorners)};
    }
    const auto t = map.locate(p);
    if (!t) return std::nullopt;
    return Source{interpolate(values, *t), *t};
}

}  // namespace

OpenVoxels SlabWriter::open(const ScatterJob& job, const CellTarget& target,
                            std::span<DirtyBrick> bricks) {
    const int size = job.lattice.brick_size();
    std::array<RowBits, 32 * 32> rows;
    OpenVoxels opened;
    opened.box = {{INT32_MAX, INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN, INT32_MIN}};
    for (DirtyBrick& brick : bricks) {
        const Box3i box = box_of_brick(job.lattice, brick.coord);
        const int width = box.end.x - box.begin.x;
        brick.is_changeable = false;
        job.touched.changeable_rows(brick.coord, rows.data());
        for_each_row(box, [&](Vec3i p) {
            const Vec3i local = p - size * brick.coord;
            const RowBits bits = rows[std::size_t(local.y + size * local.z)] & low_bits(width);
            if (brick.was_changed && bits != low_bits(width))
                put_back(target, job.original, p, width);
            if (!bits) return;
            open_row(target, p, width, bits);
            brick.is_changeable = true;
            opened.count += std::popcount(bits);
            opened.box.begin = {std::min(opened.box.begin.x, p.x + std::countr_zero(bits)),
                                std::min(opened.box.begin.y, p.y),
                                std::min(opened.box.begin.z, p.z)};
            opened.box.end = {std::max(opened.box.end.x, p.x + int(std::bit_width(bits))),
                              std::max(opened.box.end.y, p.y + 1),
                              std::max(opened.box.end.z, p.z + 1)};
        });
    }
    return opened;
}

void SlabWriter::write_strips(const ScatterJob& job, const CellTarget& target,
                              std::atomic<std::size_t>& next) {
    m_left.edge.clear();
    m_left.wants_edge = true;
    m_contested.clear();
    for (std::size_t first; (first = next.fetch_add(kStripsAtOnce)) < job.strips.size();)
        for (std::size_t n = first; n < std::min(first + kStripsAtOnce, job.strips.size()); ++n) {
            const ReachingStrip& strip = job.strips[n];
            if (!reaches_dirty_brick(job, strip.voxels) ||
                !m_strip.load(job.snapshot, job.touched, job.lattice, job.original, strip.coord,
                              strip.reach, target.box.begin.z, target.box.end.z))
                continue;
            if (m_strip.is_wild()) {
                contest(strip.voxels, job.lattice.brick_size());
                continue;
            }
            const std::size_t edges = m_left.edge.size();
            m_left.slow.clear();
            m_left.folded.clear();
            write_cells(m_strip, target, CellFaces::HalfOpen, m_left);
            for (std::size_t e = edges; e < m_left.edge.size(); ++e) m_left.edge[e].strip = int(n);
            for (const int cell : m_left.folded)
                contest(overlap(box_of(cell), target.box), job.lattice.brick_size());
        }
}

/// Adds a box's parts in each brick.
void SlabWriter::contest(const Box3i& voxels, int brick_size) {
    if (is_empty(voxels)) return;
    Box3i bricks;
    for (int a = 0; a < 3; ++a) {
        bricks.begin[a] = voxels.begin[a] / brick_size;
        bricks.end[a] = (voxels.end[a] - 1) / brick_size + 1;
    }
    for_each_in(bricks, [&](Vec3i brick) {
        const Vec3i first = brick_size * brick;
        m_contested.push_back(
            overlap(voxels, {first, first + Vec3i{brick_size, brick_size, brick_size}}));
    });
}

/// Box of the voxels that may lie in a cell, and perhaps one more, from single precision.
Box3i SlabWriter::box_of(int cell) const {
    Box3i box;
    const Vec3i local = m_strip.local(cell);
    for (int a = 0; a < 3; ++a) {
        float low = INFINITY, high = -INFINITY;
        for (int c = 0; c < 8; ++c) {
            const int n = cell + m_strip.index(c & 1, c >> 1 & 1, c >> 2);
            const float place = 8 * m_strip.eighth_u(a)[n] + float(c >> a & 1);
            low = std::min(low, place), high = std::max(high, place);
        }
        const int first = m_strip.origin()[a] + local[a];
        box.begin[a] = first + int(std::ceil(low - kBoxSlack));
        box.end[a] = first + int(std::floor(high + kBoxSlack)) + 1;
    }
    return box;
}

void open_again(const ScatterJob& job, const CellTarget& target, std::vector<Box3i>& boxes) {
    const int size = job.lattice.brick_size();
    const auto place_of = [&](const Box3i& box) {
        const Vec3i p = box.begin;
        return std::size_t(p.x / size + job.bricks.x * (p.y / size + job.bricks.y * (p.z / size)));
    };
    std::sort(boxes.begin(), boxes.end(),
              [&](const Box3i& a, const Box3i& b) { return place_of(a) < place_of(b); });
    std::array<RowBits, 32 * 32> rows;
    std::size_t last = SIZE_MAX;
    bool can_change = false;
    for (const Box3i& box : boxes) {
        const Vec3i brick = job.lattice.brick_of(box.begin);
        if (const std::size_t place = place_of(box); place != last) {
            last = place;
            can_change = job.dirty[place] && job.touched.changeable_rows(brick, rows.data());
        }
        if (!can_change) continue;
        for_each_in(box, [&](Vec3i p) {
            const Vec3i local = p - size * brick;
            *open_at(target, p) |= rows[std::size_t(local.y + size * local.z)] >> local.x & 1;
        });
    }
}

std::int64_t SlabWriter::write(const ScatterJob& job, const CellTarget& target,
                               std::span<const DirtyBrick> bricks, bool left) {
    const auto is_open = [&] {
        return std::any_of(bricks.begin(), bricks.end(), [&](const DirtyBrick& brick) {
            return brick.is_changeable && any_open(target, box_of_brick(job.lattice, brick.coord));
        });
    };
    if (left && !is_open()) return 0;
    m_met_slow = false;
    m_left.wants_edge = false;
    scatter(job, target, job.mapping, CellFaces::HalfOpen, left);
    if (!is_open()) return 0;
    // Beside a cell that isn't there, the voxels on the face between belong to the other one.
    if (job.mapping == Mapping::Cells) scatter(job, target, job.mapping, CellFaces::Closed, true);
    // Inversion can miss in a strongly folded cell; the tetrahedra always settle. Where nothing is
    // folded, what is open is a gap.
    const bool has_gaps = job.snapshot.has_edits() || job.lattice.is_void({-1, 0, 0});
    if (job.mapping != Mapping::Tetrahedra && (m_met_slow || !has_gaps) && is_open())
        scatter(job, target, Mapping::Tetrahedra, CellFaces::Closed, true);
    std::int64_t gaps = 0;
    for (const DirtyBrick& brick : bricks) {
        if (!brick.is_changeable) continue;
        const Box3i box = box_of_brick(job.lattice, brick.coord);
        for_each_row(box, [&](Vec3i p) {
            const int width = box.end.x - box.begin.x;
            std::uint8_t* open = open_at(target, p);
            if (!any_open_in_row(open, width)) return;
            for (int x = 0; x < width; ++x) {
                if (!open[x]) continue;
                store(target, p + Vec3i{x, 0, 0}, kAirHu);
                open[x] = 0;
                ++gaps;
            }
        });
    }
    return gaps;
}

void SlabWriter::scatter(const ScatterJob& job, const CellTarget& target, Mapping mapping,
                         CellFaces faces, bool left) {
    for (const ReachingStrip& strip : job.strips) {
        const Box3i reach = overlap(strip.voxels, target.box);
        if (is_empty(reach) || !reaches_dirty_brick(job, reach)) continue;
        if (left && !any_open(target, reach)) continue;
        if (!m_strip.load(job.snapshot, job.touched, job.lattice, job.original, strip.coord,
                          strip.reach, target.box.begin.z, target.box.end.z))
            continue;
        if (mapping == Mapping::Cells && !m_strip.is_wild()) {
            m_left.slow.clear();
            m_left.folded.clear();
            write_cells(m_strip, target, faces, m_left);
            for (const int cell : m_left.slow)
                if (any_open(target, overlap(box_of(cell), target.box)))
                    write_cell(job, target, mapping, cell);
            m_met_slow |= !m_left.slow.empty();
            continue;
        }
        m_met_slow |= m_strip.is_wild();
        const auto use = m_strip.use();
        for (std::size_t r = 0; r < use.size(); ++r)
            for (RowBits bits = use[r]; bits; bits &= bits - 1)
                write_cell(job, target, mapping,
                           m_strip.index(std::countr_zero(bits), int(r) % m_strip.size(),
                                         int(r) / m_strip.size()));
    }
}

/// Relative to the cell's lowest corner at rest [voxels].
std::array<Vec3d, 8> SlabWriter::corners_of(const Lattice& lattice, int cell) const {
    const Vec3d scale = voxels_per_unit(lattice.grid());
    std::array<Vec3d, 8> points;
    for (int c = 0; c < 8; ++c) {
        const Vec3i corner{c & 1, c >> 1 & 1, c >> 2};
        const Vec3<Fixed> u = m_strip.displacement(m_strip.local(cell) + corner);
        for (int a = 0; a < 3; ++a) points[std::size_t(c)][a] = corner[a] + scale[a] * u[a];
    }
    return points;
}

/// The readable twin of the kernel: one cell, in double precision.
void SlabWriter::write_cell(const ScatterJob& job, const CellTarget& target, Mapping mapping,
                            int cell) {
    const Vec3i first = m_strip.first_element() + m_strip.local(cell);
    const std::array<Vec3d, 8> points = corners_of(job.lattice, cell);
    const Box3i candidates = overlap(voxels_around(points, first), target.box);
    if (is_empty(candidates) || !any_open(target, candidates)) return;
    const TrilinearCell map(points);
    const std::array<double, 8> values = corner_values(job.original, first);
    for (int z = candidates.begin.z; z < candidates.end.z; ++z)
        for (int y = candidates.begin.y; y < candidates.end.y; ++y)
            for (int x = candidates.begin.x; x < candidates.end.x; ++x) {
                const Vec3i p{x, y, z}, d = p - first;
                if (!*open_at(target, p)) continue;
                const auto source = find_source(points, map, values,
                                                {double(d.x), double(d.y), double(d.z)}, mapping);
                if (!source) continue;
                *open_at(target, p) = 0;
                store(target, p, source->value);
                if (target.inverse_mm)
                    store_inverse(target, voxel_at(target, p),
                                  {float(source->t.x - d.x), float(source->t.y - d.y),
                                   float(source->t.z - d.z)});
            }
}

}  // namespace pliant
