// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Nearest point of the surface, by branch and bound. The extrema of a trilinear field over a box
// inside of a cell are at the box's corners. A box with all corners on one side of the threshold
// contains no surface and is dropped; every other box is halved on each axis. Boxes are processed
// in the order of their distance. The first box below the size limit is the answer, because no
// other box can be nearer.

#include <algorithm>
#include <queue>

#include "render/volume_rays.h"

namespace pliant {
namespace {

// Diagonal of a box that counts as a point, the larger of two limits: finer boxes are too many if
// much of the surface is nearly equidistant.
constexpr double kSmallestMm = 0.02;
constexpr double kSmallestShare = 0.01;  // of the distance

struct Candidate {
    double distance_mm;
    Vec3d low, high;  // voxel space, inside the cell
    Vec3i cell;

    friend bool operator<(const Candidate& a, const Candidate& b) {
        return a.distance_mm > b.distance_mm;  // the nearest first
    }
};

template <class T>
class Search {
  public:
    Search(const render::VolumeRays& rays, const render::VoxelField<T>& field,
           const render::Bricks<T>& bricks, Vec3d point_mm, double iso)
        : m_field(field),
          m_bricks(bricks),
          m_spacing(rays.volume.grid.spacing_mm),
          m_point(rays.to_voxel(point_mm)),
          m_iso(iso) {}

    /// @returns position in voxel space
    std::optional<Vec3d> nearest(double within_mm) {
        m_within = within_mm;
        add_cells();
        while (!m_waiting.empty()) {
            const Candidate box = m_waiting.top();
            m_waiting.pop();
            const Vec3d size = box.high - box.low, s = m_spacing;
            const Vec3d middle = 0.5 * (box.low + box.high);
            const double smallest = std::max(kSmallestMm, kSmallestShare * box.distance_mm);
            if (norm({size.x * s.x, size.y * s.y, size.z * s.z}) <= smallest) return middle;
            for (int part = 0; part < 8; ++part) {
                Candidate half = box;
                for (int a = 0; a < 3; ++a) (part >> a & 1 ? half.low : half.high)[a] = middle[a];
                add(half);
            }
        }
        return std::nullopt;
    }

  private:
    double distance_to(Vec3d low, Vec3d high) const {
        Vec3d away;
        for (int a = 0; a < 3; ++a)
            away[a] = m_spacing[a] * std::max({low[a] - m_point[a], m_point[a] - high[a], 0.0});
        return norm(away);
    }

    void add(Candidate& box) {
        const auto corners = m_field.corners(box.cell);
        const Vec3d origin{double(box.cell.x), double(box.cell.y), double(box.cell.z)};
        int above = 0;
        for (int c = 0; c < 8; ++c) {
            const Vec3d p{c & 1 ? box.high.x : box.low.x, c & 2 ? box.high.y : box.low.y,
                          c & 4 ? box.high.z : box.low.z};
            above += render::interpolate(corners, p - origin) >= m_iso;
        }
        if (above == 0 || above == 8) return;
        box.distance_mm = distance_to(box.low, box.high);
        if (box.distance_mm <= m_within) m_waiting.push(box);
    }

    /// Adds the cells within reach, in bricks with the threshold.
    void add_cells() {
        using render::kFineCells;
        const Vec3i n = m_bricks.cells, bricks = m_bricks.fine.size;
        Vec3i first, end;
        for (int a = 0; a < 3; ++a) {
            const double reach = m_within / m_spacing[a];
            const auto cell = [&](double p) { return int(std::clamp(p, 0.0, n[a] - 1.0)); };
            first[a] = cell(m_point[a] - reach) / kFineCells;
            end[a] = std::min(cell(m_point[a] + reach) / kFineCells + 1, bricks[a]);
        }
        for (int z = first.z; z < end.z; ++z)
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x) {
                    const auto& range = m_bricks.fine.at({x, y, z});
                    if (double(range.min) < m_iso && double(range.max) >= m_iso)
                        add_brick({x, y, z});
                }
    }

    void add_brick(Vec3i brick) {
        using render::kFineCells;
        const Vec3i begin = kFineCells * brick, n = m_bricks.cells;
        for (int z = begin.z; z < std::min(begin.z + kFineCells, n.z); ++z)
            for (int y = begin.y; y < std::min(begin.y + kFineCells, n.y); ++y)
                for (int x = begin.x; x < std::min(begin.x + kFineCells, n.x); ++x) {
                    const Vec3d low{double(x), double(y), double(z)};
                    Candidate cell{0, low, low + Vec3d{1, 1, 1}, {x, y, z}};
                    if (distance_to(cell.low, cell.high) <= m_within) add(cell);
                }
    }

    const render::VoxelField<T>& m_field;
    const render::Bricks<T>& m_bricks;
    Vec3d m_spacing, m_point;
    double m_iso, m_within = 0;
    std::priority_queue<Candidate> m_waiting;
};

}  // namespace

std::optional<RayHit> RayCaster::nearest_surface(Vec3d point_mm, double within_mm, double iso_hu,
                                                 Polarity polarity) const {
    const render::VolumeRays& rays = m_impl->rays;
    if (!is_finite(point_mm) || !(within_mm >= 0) || !std::isfinite(iso_hu)) return std::nullopt;
    const auto position = render::with_field(
        rays.volume, [&]<class T>(const render::VoxelField<T>& field) -> std::optional<Vec3d> {
            const auto& bricks = *std::get_if<render::Bricks<T>>(&rays.bricks);
            if (bricks.cells.x == 0) return std::nullopt;
            return Search<T>(rays, field, bricks, point_mm, iso_hu).nearest(within_mm);
        });
    if (!position) return std::nullopt;
    const Vec3d surface_mm = world_from_voxel(rays.volume.grid, *position);
    const Vec3d to = surface_mm - point_mm;
    const double distance = norm(to);
    const Vec3d normal = rays.normal(surface_mm, {0, 0, 0}, polarity);
    return RayHit{distance, surface_mm, normal};
}

}  // namespace pliant
