// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts through a scan with springs. The ribbon is moved to rest with the tissue that it cuts, in
// pieces of half a control cell; springs and elements are then decided there.

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"
#include "base/hash.h"
#include "base/stopwatch.h"
#include "tissue/spring_tissue.h"

namespace pliant {
namespace {

constexpr double kPieceShare = 0.5;  ///< edge of a piece of a ribbon, relative to a cell's
constexpr std::size_t kMaxPieces = 20'000;
constexpr double kFarthest_mm = 1e5;

Status check(const CutSurface& surface) {
    const auto& line = surface.line_mm;
    if (line.size() < 2)
        return about("cut", ErrorCode::InvalidArgument,
                     "expected a line of two or more points, found " + std::to_string(line.size()));
    bool has_area = false;
    for (std::size_t n = 0; n < line.size(); ++n) {
        if (!(norm(line[n]) <= kFarthest_mm && norm(surface.depth_mm) <= kFarthest_mm))
            return about("cut", ErrorCode::InvalidArgument,
                         "expected points and a depth within 100000 mm, found others");
        has_area |= n > 0 && norm(cross(line[n] - line[n - 1], surface.depth_mm)) > 0;
    }
    if (!has_area)
        return about("cut", ErrorCode::InvalidArgument,
                     "expected a depth that leads away from the line, found a surface of no area");
    return Ok{};
}

/// Points along a line, at most a step apart. @returns empty if there are too many
std::vector<Vec3d> refined(std::span<const Vec3d> line, double step) {
    std::vector<Vec3d> points{line[0]};
    for (std::size_t n = 1; n < line.size(); ++n) {
        const Vec3d along = line[n] - line[n - 1];
        const double pieces = std::max(1.0, std::ceil(norm(along) / step));
        if (pieces + double(points.size()) > double(kMaxPieces)) return {};
        for (double p = 1; p <= pieces; ++p) points.push_back(line[n - 1] + (p / pieces) * along);
    }
    return points;
}

}  // namespace

/// Position at rest of a point of the deformed scan. @param shift  used where there is no tissue
Vec3d SpringScanTissue::rest_of(Vec3d point_mm, Vec3d& shift) const {
    if (const auto position = control().find(point_mm)) shift = rest_of(*position) - point_mm;
    return point_mm + shift;
}

Vec3d SpringScanTissue::rest_of(const ControlPosition& position) const {
    const ControlGrid& grid = control().grid();
    const std::int32_t node = position.nodes[0];
    const Vec3i n{node % grid.size.x, node / grid.size.x % grid.size.y,
                  node / (grid.size.x * grid.size.y)};
    Vec3d voxel;
    for (int a = 0; a < 3; ++a)
        voxel[a] = grid.first[a] + grid.cell[a] * (double(n[a]) + position.at[a]);
    return world_from_voxel(control().volume().grid, voxel);
}

/// The ribbon at rest.
Result<std::vector<CutTriangle>> SpringScanTissue::ribbon_at_rest(const CutSurface& surface) const {
    const bool is_moved = std::any_of(m_displacements.begin(), m_displacements.end(), [](Vec3d u) {
        return u != Vec3d{0, 0, 0};
    });
    double cell_mm = kFarthest_mm;
    for (int a = 0; a < 3; ++a)
        cell_mm =
            std::min(cell_mm, control().grid().cell[a] * control().volume().grid.spacing_mm[a]);
    const double step = is_moved ? kPieceShare * cell_mm : 10 * kFarthest_mm;
    const std::array<Vec3d, 2> depth{Vec3d{0, 0, 0}, surface.depth_mm};
    const std::vector<Vec3d> along = refined(surface.line_mm, step), down = refined(depth, step);
    if (along.empty() || down.empty() || along.size() * down.size() > kMaxPieces)
        return about("cut", ErrorCode::LimitExceeded,
                     "expected a smaller blade or larger control cells, found more than " +
                         std::to_string(kMaxPieces) + " pieces");
    std::vector<Vec3d> points;
    Vec3d shift{0, 0, 0};
    for (const Vec3d& p : along)
        for (const Vec3d& d : down) points.push_back(is_moved ? rest_of(p + d, shift) : p + d);
    std::vector<CutTriangle> triangles;
    const std::size_t rows = down.size();
    for (std::size_t i = 0; i + 1 < along.size(); ++i)
        for (std::size_t j = 0; j + 1 < rows; ++j) {
            const std::size_t n = i * rows + j;
            triangles.push_back({points[n], points[n + rows], points[n + rows + 1]});
            triangles.push_back({points[n], points[n + rows + 1], points[n + 1]});
        }
    return triangles;
}

/// Links that the control lattice's cuts cross.
std::vector<std::int32_t> SpringScanTissue::crossed_links() const {
    std::vector<std::int32_t> crossed;
    const SpringNetwork& network = m_tissue.network();
    for (std::size_t l = 0; l < network.links().size(); ++l) {
        const SpringLink& link = network.links()[l];
        if (control().is_cut(network.nodes()[std::size_t(link.a)].rest,
                             network.nodes()[std::size_t(link.b)].rest))
            crossed.push_back(std::int32_t(l));
    }
    return crossed;
}

Result<CutReport> SpringScanTissue::cut(const CutSurface& surface) noexcept {
    return attempt([&] { return cut_along(surface); });
}

Result<CutReport> SpringScanTissue::cut_along(const CutSurface& surface) {
    const Stopwatch watch;
    if (const Status s = check(surface); !s.ok()) return s.error();
    if (const Status s = update_deformation(); !s.ok()) return s.error();
    auto ribbon = ribbon_at_rest(surface);
    if (!ribbon.ok()) return ribbon.error();
    const std::vector<CutTriangle> before(control().cuts_mm().begin(), control().cuts_mm().end());
    ribbon->insert(ribbon->begin(), before.begin(), before.end());
    if (const Status s = control().set_cuts(*ribbon); !s.ok()) return s.error();
    const auto made = attempt([&] { return m_tissue.cut_links(crossed_links()); });
    if (!made.ok() || made->cut_links == 0) {
        (void)control().set_cuts(before);
        if (!made.ok()) return made.error();
    } else {
        // All moved tissue may have lost its hold; at rest nothing pulls.
        for (std::int32_t n = 0; n < control().node_count(); ++n)
            if (m_tissue.displacement(n) != Vec3d{0, 0, 0} && !is_fixed(n)) m_former.push_back(n);
        renew_sources();
        wake();
    }
    return CutReport{made->cut_links, watch.ms(), 0};
}

Status SpringScanTissue::set_shape(std::span<const Vec3d> positions_mm,
                                   std::span<const CutTriangle> cuts_mm) {
    const std::vector<CutTriangle> before(control().cuts_mm().begin(), control().cuts_mm().end());
    if (std::equal(before.begin(), before.end(), cuts_mm.begin(), cuts_mm.end()))
        return set_positions(positions_mm);
    const SpringNetwork& now = m_tissue.network();
    auto whole = SpringNetwork::create({{now.nodes().begin(), now.nodes().end()},
                                        {now.links().begin(), now.links().end()},
                                        {now.cells().begin(), now.cells().end()}});
    if (!whole.ok()) return whole.error();
    auto other = SpringTissue::create(
        std::move(*whole), {.depth = m_settings.depth, .time_step = m_tissue.time_step()});
    if (!other.ok()) return other.error();
    if (const Status s = control().set_cuts(cuts_mm); !s.ok()) return s;
    const Status placed = attempt([&]() -> Status {
        const auto made = other->cut_links(crossed_links());
        if (!made.ok()) return made.error();
        std::swap(m_tissue, *other);
        const Status set = set_positions(positions_mm);
        if (!set.ok()) std::swap(m_tissue, *other);
        return set;
    });
    if (!placed.ok()) (void)control().set_cuts(before);
    return placed;
}

std::uint64_t SpringScanTissue::hash() const {
    if (control().cuts_mm().empty()) return SpringNodes::hash();
    Hash64 of_cuts;
    of_cuts.add(control().cuts_mm());
    return SpringNodes::hash() ^ of_cuts.value();
}

}  // namespace pliant
