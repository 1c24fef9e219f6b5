// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Work is divided by the place where it is written: each task owns a slab of the output, visits the
// blocks of cells that may reach into it, in one fixed order, and the first cell to cover a voxel
// writes it. So no two threads write one voxel, and the result doesn't depend on their number.

#include "resample/scatter.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <type_traits>

#include "chainmail/cell_block.h"
#include "chainmail/tetrahedra.h"
#include "resample/touched.h"
#include "resample/trilinear_cell.h"

namespace pliant {
namespace {

constexpr double kOnFace = 1e-9;  ///< tolerance of barycentric coordinates
/// A slab is at least as thick as this; thicker where that leaves each thread several.
constexpr int kLeastSlabLayers = 8;
constexpr int kSlabsPerThread = 4;

/// std::floor is a call on plain x86-64, and most of the work in a cell that holds no voxel.
int floor_to_int(double v) {
    const int truncated = int(v);
    return truncated - (v < truncated);
}
int ceil_to_int(double v) {
    return -floor_to_int(-v);
}

/// A block of cells and the voxels that it can reach along z.
struct BlockReach {
    Vec3i coord;
    int first_z, last_z;
};

std::vector<BlockReach> blocks_with_reach(const Lattice& lattice) {
    const double scale = voxels_per_unit(lattice.grid()).z;
    std::vector<BlockReach> blocks;
    for (const Vec3i& coord : cell_blocks(lattice)) {
        Vec3<Fixed> lowest, highest;
        bound_block(lattice, coord, lowest, highest);
        const int first = coord.z * lattice.brick_size();
        blocks.push_back(
            {coord, int(std::ceil(first + scale * lowest.z - kOnFace)),
             int(std::floor(first + lattice.brick_size() + scale * highest.z + kOnFace))});
    }
    return blocks;
}

template <class T>
T stored(double value) {
    if constexpr (std::is_integral_v<T>) return T(std::lrint(std::clamp(value, -32768.0, 32767.0)));
    return T(value);
}

/// One task: writes the voxels of its slab.
template <class T>
class SlabWriter {
  public:
    SlabWriter(const Lattice& lattice, Mapping mapping, const VoxelMask& changeable,
               const VoxelArray<T>& original, VoxelArray<T>& out, std::vector<Vec3f>& inverse_mm)
        : m_grid(lattice.grid()),
          m_lattice(lattice),
          m_mapping(mapping),
          m_changeable(changeable),
          m_scale(voxels_per_unit(m_grid)),
          m_original(original),
          m_out(out),
          m_inverse_mm(inverse_mm) {}

    /// Layers begin…end of the changeable box. @returns the number of gaps
    std::int64_t write(const std::vector<BlockReach>& blocks, int begin, int end) {
        m_slab = m_changeable.box;
        m_slab.begin.z = begin;
        m_slab.end.z = end;
        m_open.assign(m_changeable.flags.begin() + std::ptrdiff_t(layer_index(begin)),
                      m_changeable.flags.begin() + std::ptrdiff_t(layer_index(end)));
        scatter(blocks, m_mapping);
        // Newton's method can miss in a strongly folded cell; the tetrahedra always settle.
        if (m_mapping == Mapping::Cells && any_open()) scatter(blocks, Mapping::Tetrahedra);
        return fill_gaps();
    }

  private:
    std::size_t layer_index(int z) const {
        const Vec3i n = m_changeable.box.end - m_changeable.box.begin;
        return std::size_t(n.x) * std::size_t(n.y) * std::size_t(z - m_changeable.box.begin.z);
    }
    std::size_t open_index(Vec3i p) const {
        return m_changeable.index(p) - layer_index(m_slab.begin.z);
    }
    bool any_open() const {
        return std::any_of(m_open.begin(), m_open.end(), [](auto flag) { return flag != 0; });
    }

    void scatter(const std::vector<BlockReach>& blocks, Mapping mapping) {
        for (const BlockReach& block : blocks) {
            if (block.last_z < m_slab.begin.z || block.first_z >= m_slab.end.z) continue;
            m_block.load(m_lattice, block.coord);
            for (int z = 0; z < m_block.size(); ++z)
                for (int y = 0; y < m_block.size(); ++y)
                    for (int x = 0; x < m_block.size(); ++x)
                        if (m_block.is_touched(m_block.index(x, y, z)))
                            write_cell({x, y, z}, mapping);
        }
    }

    void write_cell(Vec3i local, Mapping mapping) {
        const std::array<int, 8> corners = m_block.corners(local.x, local.y, local.z);
        const Vec3i cell = m_block.first_element() + local;
        const std::array<Vec3d, 8> points = deformed_corners(m_block, corners, m_scale);
        Box3i candidates;
        for (int a = 0; a < 3; ++a) {
            double low = points[0][a], high = points[0][a];
            for (const Vec3d& p : points) low = std::min(low, p[a]), high = std::max(high, p[a]);
            candidates.begin[a] = std::max(m_slab.begin[a], cell[a] + ceil_to_int(low - kOnFace));
            candidates.end[a] = std::min(m_slab.end[a], cell[a] + floor_to_int(high + kOnFace) + 1);
        }
        if (is_empty(candidates)) return;
        if (mapping == Mapping::Cells)
            write_trilinear(cell, TrilinearCell(points), candidates);
        else
            write_tetrahedra(cell, points, candidates);
    }

    template <class Visit>
    void for_each_open(const Box3i& box, const Visit& visit) {
        for (int z = box.begin.z; z < box.end.z; ++z)
            for (int y = box.begin.y; y < box.end.y; ++y)
                for (int x = box.begin.x; x < box.end.x; ++x)
                    if (m_open[open_index({x, y, z})]) visit(Vec3i{x, y, z});
    }

    void write_trilinear(Vec3i cell, const TrilinearCell& map, const Box3i& candidates) {
        for_each_open(candidates, [&](Vec3i p) {
            const Vec3i local = p - cell;
            const auto t = map.locate({double(local.x), double(local.y), double(local.z)});
            if (t) put(p, interpolate(corner_values(cell), *t), cell, *t);
        });
    }

    void write_tetrahedra(Vec3i cell, const std::array<Vec3d, 8>& points, const Box3i& candidates) {
        for_each_open(candidates, [&](Vec3i p) {
            const Vec3i local = p - cell;
            const auto where = locate_in_tetrahedra(
                points, {double(local.x), double(local.y), double(local.z)}, kOnFace);
            if (!where) return;
            static constexpr std::array<Vec3d, 8> kRest = {{{0, 0, 0},
                                                            {1, 0, 0},
                                                            {0, 1, 0},
                                                            {1, 1, 0},
                                                            {0, 0, 1},
                                                            {1, 0, 1},
                                                            {0, 1, 1},
                                                            {1, 1, 1}}};
            put(p, combine(*where, corner_values(cell)), cell, combine(*where, kRest));
        });
    }

    std::array<double, 8> corner_values(Vec3i cell) const {
        std::array<double, 8> values{};
        for (int c = 0; c < 8; ++c) {
            const Vec3i e = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2};
            values[std::size_t(c)] = contains(voxel_box(m_grid), e)
                                         ? double(m_original[voxel_index(m_grid, e)])
                                         : double(kAirHu);
        }
        return values;
    }

    void put(Vec3i p, double value, Vec3i cell, Vec3d t) {
        m_open[open_index(p)] = 0;
        m_out[voxel_index(m_grid, p)] = stored<T>(value);
        if (m_inverse_mm.empty()) return;
        Vec3d away{};
        for (int a = 0; a < 3; ++a) away[a] = (cell[a] - p[a] + t[a]) * m_grid.spacing_mm[a];
        const Vec3d world = world_from_lattice_vector(m_grid, away);
        m_inverse_mm[m_changeable.index(p)] = {float(world.x), float(world.y), float(world.z)};
    }

    std::int64_t fill_gaps() {
        std::int64_t gaps = 0;
        for_each_open(m_slab, [&](Vec3i p) {
            m_out[voxel_index(m_grid, p)] = T(kAirHu);
            ++gaps;
        });
        return gaps;
    }

    const Grid& m_grid;
    const Lattice& m_lattice;
    Mapping m_mapping;
    const VoxelMask& m_changeable;
    Vec3d m_scale;
    const VoxelArray<T>& m_original;
    VoxelArray<T>& m_out;
    std::vector<Vec3f>& m_inverse_mm;
    Box3i m_slab;
    std::vector<std::uint8_t> m_open;  ///< changeable voxels of the slab that nothing has covered
    CellBlock m_block;
};

/// Writes the changeable voxels of `deformed.volume`, which starts as a copy of the original, and
/// deformed.inverse_mm where that isn't empty.
/// @returns the number of voxels that no cell covers; they become air
template <class T>
std::int64_t scatter_cells(const VoxelArray<T>& original, const Lattice& lattice, Mapping mapping,
                           const VoxelMask& changeable, const TaskArena& arena,
                           Deformed& deformed) {
    auto& out = std::get<VoxelArray<T>>(deformed.volume.voxels);
    const std::vector<BlockReach> blocks = blocks_with_reach(lattice);
    const Box3i& box = changeable.box;
    const int layers = box.end.z - box.begin.z;
    const int slab_layers =
        std::max(kLeastSlabLayers, layers / (kSlabsPerThread * arena.thread_count()));
    const int slabs = (layers + slab_layers - 1) / slab_layers;
    std::atomic<std::int64_t> gaps{0};
    arena.for_each(slabs, 1, [&](std::int64_t first, std::int64_t last) {
        SlabWriter<T> writer(lattice, mapping, changeable, original, out, deformed.inverse_mm);
        for (std::int64_t slab = first; slab < last; ++slab) {
            const int begin = box.begin.z + int(slab) * slab_layers;
            gaps += writer.write(blocks, begin, std::min(begin + slab_layers, box.end.z));
        }
    });
    return gaps;
}

}  // namespace

Deformed deform_by_lattice(const Volume& original, const Lattice& lattice, Mapping mapping,
                           bool with_inverse, const TaskArena& arena) {
    Deformed deformed;
    deformed.volume = original;
    const auto start = std::chrono::steady_clock::now();
    const VoxelMask changeable = changeable_voxels(lattice, arena);
    deformed.dirty_box = changeable.box;
    deformed.written_voxels =
        std::count(changeable.flags.begin(), changeable.flags.end(), std::uint8_t(1));
    if (with_inverse) deformed.inverse_mm.assign(changeable.flags.size(), Vec3f{0, 0, 0});
    deformed.gap_voxels = std::visit(
        [&](const auto& voxels) {
            return scatter_cells(voxels, lattice, mapping, changeable, arena, deformed);
        },
        original.voxels);
    deformed.resample_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return deformed;
}

}  // namespace pliant
