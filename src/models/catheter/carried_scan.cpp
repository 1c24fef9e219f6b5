// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The displacement of a control node is fade(d) · Σ w u / Σ w over the wall's nearest nodes, with
//
//   w = 1/(distance² + ε²)²,  fade(d) = (1 − (d/reach)²)², d to the nearest node
//
// The weights are computed once; an update only evaluates the sums.

#include <pliant/models/catheter.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/errors.h"
#include "resample/filled_scan.h"
#include "vessel/wall.h"

namespace pliant {
namespace {

constexpr std::size_t kNearest = 8;
constexpr double kSoft = 1;  ///< ε [mm]

struct Nearest {
    std::int32_t node;
    double distance2;
};

constexpr double kMargin_mm = 25, kVoxel_mm = 1;
constexpr int kMaxVoxels = 256;
constexpr double kLumenHu = 300, kWallHu = 90, kTissueHu = 40, kPatternHu = 20;
constexpr double kPattern_mm = 12;

/// Triangle wave in −1…1; bit-identical on every machine, unlike a cosine.
double wave(double x) {
    const double part = x / kPattern_mm - std::floor(x / kPattern_mm);
    return 4 * std::abs(part - 0.5) - 1;
}

/// Distances to the wall and to the lumen.
class Around {
  public:
    static Result<Around> create(const VesselWall& wall) {
        auto boundary = SurfaceDistance::create(boundary_triangles(wall.mesh));
        if (!boundary) return boundary.error();
        auto closed = vessel::with_lids(wall.ghost);
        if (!closed) return closed.error();
        for (auto& t : closed->cells) std::swap(t[1], t[2]);  // the ghost surface faces the lumen
        auto lumen = SurfaceDistance::create(std::move(*closed));
        if (!lumen) return lumen.error();
        return Around(std::move(*boundary), std::move(*lumen));
    }

    struct Position {
        double wall_mm, lumen_mm;  ///< negative inside
        bool is_far(double reach_mm) const {
            return std::abs(wall_mm) > reach_mm && std::abs(lumen_mm) > reach_mm;
        }
    };
    Position at(Vec3d p) const { return {m_boundary.signed_mm(p), m_lumen.signed_mm(p)}; }

  private:
    Around(SurfaceDistance boundary, SurfaceDistance lumen)
        : m_boundary(std::move(boundary)), m_lumen(std::move(lumen)) {}
    SurfaceDistance m_boundary, m_lumen;
};

/// The value of a voxel depends on its distance to the wall's boundary, and outside of the wall on
/// its side of the ghost surface, closed with lids.
double value_at(Vec3d p, const Around::Position& position, double voxel) {
    const double around = position.lumen_mm < 0
                              ? kLumenHu
                              : kTissueHu + kPatternHu * wave(p.x) * wave(p.y) * wave(p.z);
    const double share = std::clamp(0.5 - position.wall_mm / voxel, 0.0, 1.0);
    return std::round(share * kWallHu + (1 - share) * around);
}

Result<Volume> fill_scan(const VesselWall& wall, const TaskArena& arena) {
    const auto around = Around::create(wall);
    if (!around) return around.error();
    Volume volume;
    volume.grid = grid_around(wall.mesh.nodes_mm, kMargin_mm, kVoxel_mm, kMaxVoxels);
    volume.key_values = {{"iso_hu", "200"}, {"polarity", "falling"}};
    const double voxel = volume.grid.spacing_mm.x;
    volume.voxels = filled(
        volume.grid, arena, [&](Vec3d p) { return around->at(p); },
        [&](Vec3d p, const Around::Position& position) { return value_at(p, position, voxel); });
    return volume;
}

}  // namespace

struct CarriedScan::Impl {
    struct Weight {
        std::int32_t node;
        double weight;
    };
    std::unique_ptr<ControlLattice> lattice;
    std::vector<Vec3d> rest;
    std::vector<std::int32_t> starts;  ///< [control node], and the total
    std::vector<Weight> weights;
    std::vector<Vec3d> moved;  ///< displacements of the last update

    void weigh(double reach);
    Status update(std::span<const Vec3d> wall_positions);
};

void CarriedScan::Impl::weigh(double reach) {
    const auto count = std::size_t(lattice->node_count());
    const ControlGrid& grid = lattice->grid();
    std::vector<std::vector<Nearest>> near(count);
    const Grid& voxels = lattice->volume().grid;
    // Visits the control nodes around each wall node.
    for (std::size_t n = 0; n < rest.size(); ++n) {
        const Vec3d ijk = voxel_from_world(voxels, rest[n]);
        Vec3i low{}, high{};
        for (int c = 0; c < 3; ++c) {
            const double at = (ijk[c] - grid.first[c]) / grid.cell[c],
                         by = reach / (voxels.spacing_mm[c] * grid.cell[c]);
            low[c] = int(std::clamp(std::ceil(at - by), 0.0, double(grid.size[c])));
            high[c] = int(std::clamp(std::floor(at + by) + 1, 0.0, double(grid.size[c])));
        }
        for (int k = low.z; k < high.z; ++k)
            for (int j = low.y; j < high.y; ++j)
                for (int i = low.x; i < high.x; ++i) {
                    const std::int32_t at = i + grid.size.x * (j + grid.size.y * k);
                    const Vec3d d = lattice->node_mm(at) - rest[n];
                    const double distance2 = dot(d, d);
                    if (!(distance2 < reach * reach)) continue;
                    auto& list = near[std::size_t(at)];
                    if (list.size() == kNearest && list.back().distance2 <= distance2) continue;
                    const auto before = std::upper_bound(
                        list.begin(), list.end(), distance2,
                        [](double value, const Nearest& x) { return value < x.distance2; });
                    list.insert(before, {std::int32_t(n), distance2});
                    if (list.size() > kNearest) list.pop_back();
                }
    }
    starts.push_back(0);
    for (const auto& list : near) {
        double sum = 0;
        const auto weight = [](const Nearest& x) {
            const double d = x.distance2 + kSoft * kSoft;
            return 1 / (d * d);
        };
        for (const Nearest& x : list) sum += weight(x);
        for (const Nearest& x : list) {
            const double share = 1 - list.front().distance2 / (reach * reach);
            weights.push_back({x.node, share * share * weight(x) / sum});
        }
        starts.push_back(std::int32_t(weights.size()));
    }
    moved.assign(count, {0, 0, 0});
}

namespace {

Result<ControlGrid> grid_around_wall(const Volume& volume, const TetMesh& wall,
                                     const CarriedScanSettings& settings) {
    if (const Status s = check_volume(volume); !s.ok()) return s.error();
    if (!(settings.reach_mm > 0 && settings.reach_mm <= 1000))
        return invalid("reach_mm: expected above 0, up to 1000, found " +
                       std::to_string(settings.reach_mm));
    if (!(settings.cell_mm > 0 && settings.cell_mm <= 1000))
        return invalid("cell_mm: expected above 0, up to 1000, found " +
                       std::to_string(settings.cell_mm));
    if (wall.nodes_mm.empty()) return invalid("wall: expected nodes, found none");
    const Grid& g = volume.grid;
    Vec3d low{1e300, 1e300, 1e300}, high = -low;
    for (const Vec3d& p : wall.nodes_mm) {
        const Vec3d ijk = voxel_from_world(g, p);
        for (int c = 0; c < 3; ++c) {
            low[c] = std::min(low[c], ijk[c] - settings.reach_mm / g.spacing_mm[c]);
            high[c] = std::max(high[c], ijk[c] + settings.reach_mm / g.spacing_mm[c]);
        }
    }
    ControlGrid grid;
    for (int c = 0; c < 3; ++c) {
        grid.cell[c] = std::max(1, int(std::lround(settings.cell_mm / g.spacing_mm[c])));
        grid.cell[c] = std::min(grid.cell[c], g.size[c] - 1);
        if (!(grid.cell[c] > 0) || !(high[c] > 0) || !(low[c] < g.size[c] - 1))
            return invalid("wall: expected inside of the scan, found beside it");
        grid.first[c] = std::clamp(int(std::floor(low[c])), 0, g.size[c] - 1 - grid.cell[c]);
        const int last = std::clamp(int(std::ceil(high[c])), grid.first[c], g.size[c] - 1);
        grid.size[c] = std::max(1, (last - grid.first[c]) / grid.cell[c]) + 1;
    }
    return grid;
}

}  // namespace

CarriedScan::CarriedScan(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
CarriedScan::~CarriedScan() = default;
CarriedScan::CarriedScan(CarriedScan&&) noexcept = default;
CarriedScan& CarriedScan::operator=(CarriedScan&&) noexcept = default;

Result<CarriedScan> CarriedScan::create(const Volume& volume, const TetMesh& wall,
                                        const CarriedScanSettings& settings,
                                        const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<CarriedScan> {
        const auto grid = grid_around_wall(volume, wall, settings);
        if (!grid) return grid.error();
        auto lattice = ControlLattice::create(volume, *grid, arena);
        if (!lattice) return lattice.error();
        auto impl = std::make_unique<Impl>();
        impl->lattice = std::move(*lattice);
        impl->rest = wall.nodes_mm;
        impl->weigh(settings.reach_mm);
        return CarriedScan(std::move(impl));
    });
}

Status CarriedScan::update(std::span<const Vec3d> wall_positions) noexcept {
    return attempt([&] { return m_impl->update(wall_positions); });
}

Status CarriedScan::Impl::update(std::span<const Vec3d> wall_positions) {
    if (wall_positions.size() != rest.size())
        return invalid("update: expected " + std::to_string(rest.size()) + " positions, found " +
                       std::to_string(wall_positions.size()));
    for (std::size_t c = 0; c < moved.size(); ++c) {
        Vec3d sum{0, 0, 0};
        for (auto n = std::size_t(starts[c]); n < std::size_t(starts[c + 1]); ++n) {
            const auto node = std::size_t(weights[n].node);
            sum = sum + weights[n].weight * (wall_positions[node] - rest[node]);
        }
        moved[c] = sum;
    }
    return lattice->place(moved);
}

const ControlLattice& CarriedScan::scan() const {
    return *m_impl->lattice;
}

Result<Volume> scan_of_vessel(const VesselWall& wall, const TaskArena& arena) noexcept {
    return attempt([&] { return fill_scan(wall, arena); });
}

}  // namespace pliant
