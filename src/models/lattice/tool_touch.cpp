// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "lattice/tool_touch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "field/trilinear_cell.h"
#include "lattice/near_cells.h"

namespace pliant {
namespace {

constexpr int kFewestSamples = 3, kMaxSamples = 6;  ///< along each axis of a cell's part
constexpr double kSamplesPerRadius = 4;
constexpr double kBesidePart = 0.05;  ///< added to a part on each side [cell coordinates]

Vec3d as_real(Vec3i v) {
    return {double(v.x), double(v.y), double(v.z)};
}

Vec3d scaled(Vec3d h, Vec3d v) {
    return {h.x * v.x, h.y * v.y, h.z * v.z};
}

void sort_once(std::vector<Vec3i>& elements) {
    std::sort(elements.begin(), elements.end(), comes_before);
    elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
}

/// Part of a cell, in cell coordinates 0…1.
struct Part {
    Vec3d low{0, 0, 0}, high{1, 1, 1};
};

/// Part of a cell that a ball can reach, from the cell's map at its middle; the whole cell if it is
/// too distorted for that.
/// @param centre  of the ball, from the cell's lowest element [voxels]
/// @returns nothing if it reaches none
std::optional<Part> part_in_reach(const NearCell& cell, Vec3d centre, double radius_mm, Vec3d h) {
    std::array<Vec3d, 3> edge{};  // mean over the four edges along each axis [mm]
    Vec3d middle{0, 0, 0};
    for (std::size_t c = 0; c < 8; ++c) {
        const Vec3d corner_mm = scaled(h, cell.corners[c]);
        middle = middle + 0.125 * corner_mm;
        for (std::size_t a = 0; a < 3; ++a)
            edge[a] = edge[a] + (c >> a & 1 ? 0.25 : -0.25) * corner_mm;
    }
    constexpr double kFlat = 1e-3, kBent = 0.25;  // relative to the cell's own size
    const Mat3d map{{edge[0], edge[1], edge[2]}};
    const double size = norm(edge[0]) * norm(edge[1]) * norm(edge[2]);
    if (!(determinant(map) > kFlat * size)) return Part{};
    const Mat3d back = inverse(map);
    double bent = 0;
    for (std::size_t c = 0; c < 8; ++c) {
        const Vec3d straight{c & 1 ? 0.5 : -0.5, c & 2 ? 0.5 : -0.5, c & 4 ? 0.5 : -0.5};
        const Vec3d away = back * (scaled(h, cell.corners[c]) - middle) - straight;
        for (int a = 0; a < 3; ++a) bent = std::max(bent, std::abs(away[a]));
    }
    if (bent > kBent) return Part{};
    const Mat3d rows = transposed(back);
    const Vec3d at = back * (scaled(h, centre) - middle) + Vec3d{0.5, 0.5, 0.5};
    Part part;
    for (int a = 0; a < 3; ++a) {
        const double reach = radius_mm * norm(rows.columns[a]) + bent + kBesidePart;
        part.low[a] = std::max(0.0, at[a] - reach);
        part.high[a] = std::min(1.0, at[a] + reach);
        if (part.low[a] > part.high[a]) return std::nullopt;
    }
    return part;
}

/// Number of samples along one axis of a part.
int sample_count(double length_mm, double radius_mm) {
    const double wanted = std::ceil(kSamplesPerRadius * length_mm / radius_mm) + 1;
    return int(std::clamp(wanted, double(kFewestSamples), double(kMaxSamples)));
}

/// Searches cells one by one for tissue in a ball.
class TouchSearch {
  public:
    TouchSearch(const Lattice& lattice, const Volume& scan, Vec3d centre, double radius_mm,
                const TissueValues& tissue)
        : m_lattice(lattice),
          m_values(scan),
          m_spacing_mm(lattice.grid().spacing_mm),
          m_centre(centre),
          m_radius_mm(radius_mm),
          m_tissue(tissue) {}

    void look_at(const NearCell& cell) {
        const std::array<double, 8> values = m_values.at_corners(cell);
        const auto holds = [&](double value) { return m_tissue.hold(value); };
        if (std::none_of(values.begin(), values.end(), holds)) return;
        const Vec3d centre = m_centre - as_real(cell.lowest);
        const auto part = part_in_reach(cell, centre, m_radius_mm, m_spacing_mm);
        if (!part || !is_whole(m_lattice, cell)) return;
        const TrilinearCell map(cell.corners);
        const std::size_t first = m_points.size();
        sample(map, values, *part, centre);
        if (const auto t = map.locate(centre); t && holds(interpolate(values, *t)))
            m_points.push_back({0, 0, 0});
        if (m_points.size() > first) m_cells.push_back({cell.lowest, first, m_points.size()});
    }

    /// Returns the cells sorted by position, so that the result doesn't depend on the bricks.
    Touch take() {
        std::sort(m_cells.begin(), m_cells.end(), [](const Touched& p, const Touched& q) {
            return comes_before(p.lowest, q.lowest);
        });
        Touch touch;
        for (const Touched& cell : m_cells) {
            for (int c = 0; c < 8; ++c)
                touch.elements.push_back(cell.lowest + Vec3i{c & 1, c >> 1 & 1, c >> 2});
            touch.inside_mm.insert(touch.inside_mm.end(),
                                   m_points.begin() + std::ptrdiff_t(cell.begin),
                                   m_points.begin() + std::ptrdiff_t(cell.end));
        }
        sort_once(touch.elements);
        return touch;
    }

  private:
    struct Touched {
        Vec3i lowest;
        std::size_t begin, end;  ///< range of its points
    };

    void sample(const TrilinearCell& map, const std::array<double, 8>& values, const Part& part,
                Vec3d centre) {
        const Vec3d size = part.high - part.low;
        Vec3i count{};
        for (int a = 0; a < 3; ++a) {
            Vec3d begin = part.low, end = part.low;
            end[a] = part.high[a];
            const Vec3d along = scaled(m_spacing_mm, map.at(end) - map.at(begin));
            count[a] = sample_count(norm(along), m_radius_mm);
        }
        for (int z = 0; z < count.z; ++z)
            for (int y = 0; y < count.y; ++y)
                for (int x = 0; x < count.x; ++x) {
                    const Vec3d t{part.low.x + size.x * x / (count.x - 1),
                                  part.low.y + size.y * y / (count.y - 1),
                                  part.low.z + size.z * z / (count.z - 1)};
                    if (!m_tissue.hold(interpolate(values, t))) continue;
                    const Vec3d away_mm = scaled(m_spacing_mm, map.at(t) - centre);
                    if (dot(away_mm, away_mm) < m_radius_mm * m_radius_mm)
                        m_points.push_back(away_mm);
                }
    }

    const Lattice& m_lattice;
    ScanValues m_values;
    Vec3d m_spacing_mm, m_centre;
    double m_radius_mm;
    TissueValues m_tissue;
    std::vector<Touched> m_cells;
    std::vector<Vec3d> m_points;
};

/// A range of values.
struct Range {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void include(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
};

/// Voxels around a point as shown by the resampler.
class ShownVoxels {
  public:
    ShownVoxels(const Lattice& lattice, const Volume& scan, Vec3d point)
        : m_lattice(lattice), m_values(scan), m_point(point) {
        m_first = {int(std::floor(point.x)), int(std::floor(point.y)), int(std::floor(point.z))};
        for (std::size_t c = 0; c < 8; ++c) {
            m_shown[c] = double(scan.background);
            if (!contains(voxel_box(scan.grid), voxel(c))) continue;
            if (!is_redrawn(voxel(c)))
                show(c, m_values.at(voxel(c)));
            else
                m_open[c] = true;
        }
        if (std::find(m_open.begin(), m_open.end(), true) == m_open.end()) return;
        visit_near_cells(lattice, as_real(m_first), as_real(m_first + Vec3i{1, 1, 1}),
                         [&](const NearCell& cell) { look_at(cell); });
    }

    double value() const { return interpolate(m_shown, m_point - as_real(m_first)); }
    /// Range of all values used.
    const Range& range() const { return m_range; }

  private:
    Vec3i voxel(std::size_t c) const {
        return m_first + Vec3i{int(c & 1), int(c >> 1 & 1), int(c >> 2)};
    }

    /// A voxel is redrawn if all eight cells around it have a moved or void corner.
    bool is_redrawn(Vec3i p) const {
        if (m_lattice.may_have_gaps()) return true;
        for (int c = 0; c < 8; ++c) {
            const Vec3i low = p - Vec3i{c & 1, c >> 1 & 1, c >> 2};
            bool moved = false;
            for (int d = 0; d < 8 && !moved; ++d)
                moved = m_lattice.displacement_at(low + Vec3i{d & 1, d >> 1 & 1, d >> 2}) !=
                        Vec3<Fixed>{0, 0, 0};
            if (!moved) return false;
        }
        return true;
    }

    void look_at(const NearCell& cell) {
        const CellPlanes planes(cell.corners);
        std::optional<TrilinearCell> map;
        for (std::size_t c = 0; c < 8; ++c) {
            if (!m_open[c]) continue;
            if (m_claim[c] && comes_before(*m_claim[c], cell.lowest)) continue;
            const Vec3d position = as_real(voxel(c) - cell.lowest);
            if (!planes.may_hold(position)) continue;
            if (!map) map.emplace(cell.corners);
            const auto t = map->locate(position);
            if (!t || !is_whole(m_lattice, cell)) continue;
            const std::array<double, 8> values = m_values.at_corners(cell);
            for (const double value : values) m_range.include(value);
            show(c, interpolate(values, *t));
            m_claim[c] = cell.lowest;
        }
    }

    void show(std::size_t c, double value) {
        m_shown[c] = value;
        m_range.include(value);
    }

    const Lattice& m_lattice;
    ScanValues m_values;
    Vec3d m_point;
    Vec3i m_first{0, 0, 0};
    std::array<double, 8> m_shown{};
    std::array<bool, 8> m_open{};                   ///< voxels not yet claimed by a cell
    std::array<std::optional<Vec3i>, 8> m_claim{};  ///< the lowest cell over each voxel
    Range m_range;
};

}  // namespace

Touch touch_sphere(const Lattice& lattice, const Volume& scan, Vec3d centre, double radius_mm,
                   const TissueValues& tissue) {
    const Vec3d h = lattice.grid().spacing_mm;
    const Vec3d reach{radius_mm / h.x, radius_mm / h.y, radius_mm / h.z};
    TouchSearch search(lattice, scan, centre, radius_mm, tissue);
    visit_near_cells(lattice, centre - reach, centre + reach,
                     [&](const NearCell& cell) { search.look_at(cell); });
    return search.take();
}

bool shows_tissue(const Lattice& lattice, const Volume& scan, Vec3d point,
                  const TissueValues& tissue) {
    for (int a = 0; a < 3; ++a)
        if (!(point[a] >= 0 && point[a] <= scan.grid.size[a] - 1)) return false;
    const ShownVoxels voxels(lattice, scan, point);
    constexpr double kOfRange = 2e-3;  // the resampler's inverse is exact to some thousandths
    const double rounding = scan.is_16_bit() ? 0.6 : 0;
    const Range& range = voxels.range();
    const double margin = kOfRange * std::max(0.0, range.high - range.low) + rounding;
    return tissue.hold(voxels.value() + (tissue.is_above ? margin : -margin));
}

std::vector<Vec3i> elements_around(const Lattice& lattice, Vec3d point, double radius_mm) {
    const Vec3d h = lattice.grid().spacing_mm;
    Vec3d low, high;
    for (int a = 0; a < 3; ++a) {
        low[a] = std::min(std::floor(point[a]), point[a] - radius_mm / h[a]);
        high[a] = std::max(std::floor(point[a]) + 1, point[a] + radius_mm / h[a]);
    }
    std::vector<Vec3i> elements;
    visit_near_cells(lattice, low, high, [&](const NearCell& cell) {
        for (std::size_t c = 0; c < 8; ++c) elements.push_back(cell.element(c));
    });
    sort_once(elements);
    return elements;
}

}  // namespace pliant
