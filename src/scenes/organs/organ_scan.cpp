// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "organs/organ_scan.h"

#include <pliant/core/files.h>
#include <pliant/mesh_files.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "resample/filled_scan.h"

namespace pliant {
namespace {

constexpr double kTissueHu = 60, kPatternHu = 25;
constexpr double kNextHu = -20;  ///< from one organ to the next, so that sections tell them apart
constexpr double kMarginShare = 0.15;   ///< of the longest side
constexpr double kVoxelShare = 0.0128;  ///< likewise: some 100 voxels with the margins
constexpr double kPatternShare = 0.06;
constexpr double kRampVoxels = 1;  ///< on each side of a surface, from one value to the other
constexpr int kMaxVoxels = 256;

/// The largest of 1, 2 and 5 times a power of ten up to a length.
double round_down(double mm) {
    const double power = std::pow(10, std::floor(std::log10(mm)));
    return (mm >= 5 * power ? 5 : mm >= 2 * power ? 2 : 1) * power;
}

/// Triangle wave in −1…1; bit-identical on every machine, unlike a cosine.
double wave(double x) {
    return 4 * std::abs(x - std::floor(x) - 0.5) - 1;
}

struct Content {
    SurfaceDistance surface;
    double value_hu;
};

/// Voxels of a scan from signed distances to surfaces, those of organs and then of contents. A
/// surface that is far from a cube of voxels has one distance in all of it, the middle's:
///
///     ┌───────┬───┬───┐
///     │  far  ├───┼─┬─┤╮     8, 4, 2 and 1 voxels: cubes are halved while a surface is near
///     │       │   ├─┼─┤ ╲ surface
///     ├───────┼───┴─┴─┤
class Filler {
  public:
    Filler(const Grid& grid, std::span<const SurfaceDistance> organs,
           std::span<const Content> contents, double pattern_mm)
        : m_grid(grid), m_organs(organs), m_contents(contents), m_pattern(pattern_mm) {
        for (Level& level : m_levels) {
            level.mm.resize(organs.size() + contents.size());
            level.is_known.resize(level.mm.size());
        }
    }
    static constexpr int kCube = 8;

    /// @param first  of kCube voxels along each axis, or as many as the grid has
    void fill(Vec3i first, std::span<std::int16_t> values) {
        std::fill(m_levels.front().is_known.begin(), m_levels.front().is_known.end(), char(0));
        fill(0, first, kCube, values);
    }

  private:
    static constexpr std::size_t kLevels = 4;
    /// Distances at the middle of a cube.
    struct Level {
        std::vector<double> mm;
        std::vector<char> is_known;  ///< for all of the cube
    };

    void fill(std::size_t level, Vec3i first, int size, std::span<std::int16_t> values) {
        Level& here = m_levels[level];
        measure(here, middle_of(first, size));
        const double voxel = m_grid.spacing_mm.x;
        const double reach = (0.5 * std::sqrt(3.0) * (size - 1) + kRampVoxels) * voxel;
        for (std::size_t n = 0; n < here.mm.size(); ++n)
            here.is_known[n] = here.is_known[n] || std::abs(here.mm[n]) > reach;
        keep_clear(here, 0, m_organs.size());
        keep_clear(here, m_organs.size(), here.mm.size());
        const Vec3i size_of_grid = m_grid.size;
        const auto all_known = [&] {
            return std::find(here.is_known.begin(), here.is_known.end(), char(0)) ==
                   here.is_known.end();
        };
        if (size == 1 || all_known()) {
            for (int k = first.z; k < std::min(first.z + size, size_of_grid.z); ++k)
                for (int j = first.y; j < std::min(first.y + size, size_of_grid.y); ++j)
                    for (int i = first.x; i < std::min(first.x + size, size_of_grid.x); ++i)
                        values[voxel_index(m_grid, {i, j, k})] = value_at({i, j, k}, here.mm);
            return;
        }
        const int half = size / 2;
        for (int n = 0; n < 8; ++n) {
            const Vec3i part = first + half * Vec3i{n & 1, n >> 1 & 1, n >> 2};
            if (part.x >= size_of_grid.x || part.y >= size_of_grid.y || part.z >= size_of_grid.z)
                continue;
            m_levels[level + 1] = here;
            fill(level + 1, part, half, values);
        }
    }

    Vec3d middle_of(Vec3i first, int size) const {
        Vec3d ijk;
        for (int a = 0; a < 3; ++a) ijk[a] = first[a] + 0.5 * (size - 1);
        return world_from_voxel(m_grid, ijk);
    }

    void measure(Level& level, Vec3d p) const {
        for (std::size_t n = 0; n < level.mm.size(); ++n)
            if (!level.is_known[n])
                level.mm[n] = n < m_organs.size()
                                  ? m_organs[n].signed_mm(p)
                                  : m_contents[n - m_organs.size()].surface.signed_mm(p);
    }

    /// Where solids may overlap, the deepest one decides, so that all distances are needed.
    static void keep_clear(Level& level, std::size_t begin, std::size_t end) {
        int inside = 0;
        for (std::size_t n = begin; n < end; ++n) inside += !level.is_known[n] || level.mm[n] < 0;
        for (std::size_t n = begin; inside > 1 && n < end; ++n)
            level.is_known[n] = level.is_known[n] && level.mm[n] > 0;
    }

    std::int16_t value_at(Vec3i ijk, std::span<const double> mm) const {
        const Vec3d p = world_from_voxel(m_grid, {double(ijk.x), double(ijk.y), double(ijk.z)});
        const auto organs = mm.first(m_organs.size()), contents = mm.subspan(m_organs.size());
        const auto nearest = std::min_element(organs.begin(), organs.end());
        const double own =
            kTissueHu + kNextHu * double((nearest - organs.begin()) % 4) +
            kPatternHu * wave(p.x / m_pattern) * wave(p.y / m_pattern) * wave(p.z / m_pattern);
        double inside = own;
        if (!contents.empty()) {
            const auto content = std::min_element(contents.begin(), contents.end());
            const double part = share_of(*content);
            inside = part * m_contents[std::size_t(content - contents.begin())].value_hu +
                     (1 - part) * own;
        }
        const double share = share_of(*nearest);
        return std::int16_t(std::round(share * inside + (1 - share) * kAirHu));
    }

    /// Share of a solid in a voxel; its surface is smooth if it is spread over two voxels.
    double share_of(double distance_mm) const {
        return std::clamp(0.5 - distance_mm / (2 * kRampVoxels * m_grid.spacing_mm.x), 0.0, 1.0);
    }

    const Grid& m_grid;
    std::span<const SurfaceDistance> m_organs;
    std::span<const Content> m_contents;
    double m_pattern;
    std::array<Level, kLevels> m_levels;
};

Result<std::vector<Content>> read_contents(std::span<const OrganContents> contents) {
    std::vector<Content> read;
    for (const OrganContents& c : contents) {
        auto surface = read_surface(c.surface);
        if (!surface) return surface.error();
        auto distance = SurfaceDistance::create(joined(*surface));
        if (!distance) return within(c.surface, distance.error());
        read.push_back({std::move(*distance), c.value_hu});
    }
    return read;
}

}  // namespace

Result<Volume> scan_of_organs(std::span<const Organ> organs,
                              std::span<const OrganContents> contents, const TaskArena& arena) {
    std::vector<SurfaceDistance> surfaces;
    std::vector<Vec3d> nodes;
    for (const Organ& organ : organs) {
        auto surface = SurfaceDistance::create(boundary_triangles(organ.mesh));
        if (!surface) return within(organ.name, surface.error());
        surfaces.push_back(std::move(*surface));
        nodes.insert(nodes.end(), organ.mesh.nodes_mm.begin(), organ.mesh.nodes_mm.end());
    }
    const auto inner = read_contents(contents);
    if (!inner) return inner.error();
    Vec3d low = nodes.front(), high = low;
    for (const Vec3d& p : nodes)
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    const Vec3d span = high - low;
    const double longest = std::max({span.x, span.y, span.z});
    Volume volume;
    volume.grid =
        grid_around(nodes, kMarginShare * longest, round_down(kVoxelShare * longest), kMaxVoxels);
    VoxelArray<std::int16_t> values(voxel_count(volume.grid));
    Vec3i cubes;
    for (int a = 0; a < 3; ++a)
        cubes[a] = (volume.grid.size[a] + Filler::kCube - 1) / Filler::kCube;
    const std::span<std::int16_t> voxels(values.data(), voxel_count(volume.grid));
    arena.for_each(
        std::int64_t(cubes.x) * cubes.y * cubes.z, 1, [&](std::int64_t begin, std::int64_t end) {
            Filler filler(volume.grid, surfaces, *inner, round_down(kPatternShare * longest));
            for (std::int64_t c = begin; c < end; ++c)
                filler.fill(Filler::kCube * Vec3i{int(c % cubes.x), int(c / cubes.x % cubes.y),
                                                  int(c / cubes.x / cubes.y)},
                            voxels);
        });
    volume.voxels = std::move(values);
    return volume;
}

}  // namespace pliant
