// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Input → constraints → spline → lattice of nodes. A lattice that folds sends the spline back to be
// softened.

#include <pliant/data/morph.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "morph/elastic_part.h"
#include "morph/node_map.h"
#include "morph/parts.h"
#include "morph/plate.h"
#include "morph/slide.h"

namespace pliant {

struct Morph::Impl {
    morph::NodeMap map;
    MorphReport report;
};

namespace {

using morph::BodyField;
using morph::ElasticSettings;
using morph::Moved;
using morph::NodeMap;
using morph::Part;
using morph::Parts;
using morph::Plate;
using morph::PlatePoint;
using morph::PlateRow;
using morph::Slide;

constexpr std::size_t kMaxPoints = 2000;
constexpr double kFarMm = 1e6;  ///< farther points are an error of units
// Nodes along the longest axis of the data; with shapes they take most of the time.
constexpr int kNodesOfPoints = 64, kNodesOfShapes = 48;
constexpr double kMargin = 0.1;    ///< of the lattice around the data, over the longest axis
constexpr int kSoftenings = 8;     ///< rounds of softening before the field is flattened
constexpr double kSoftening = 10;  ///< factor of λ at a fold
constexpr double kFlattening = 0.1;
// Of a body, beside its surface: chosen ones, of so many voxels.
constexpr std::size_t kInnerPoints = 160, kInnerVoxels = 5000;
constexpr double kBodySoftnessMm = 1;                       ///< λ of a body's samples
const std::vector<double> kBodyWeights{0.003, 0.01, 0.03};  ///< of a body alone, by round
const std::vector<double> kTrendWeights{0.003, 0.01};       ///< before points [1/mm²]
const double kSlideStarts[] = {10, 10.0 / 3, 1, 1};  ///< λ of surfaces by round, over the last

Status check_points(const MorphInput& in) {
    if (in.from_mm.size() != in.to_mm.size())
        return expected_error("to_mm", std::to_string(in.from_mm.size()) + " points, as of from_mm",
                              std::to_string(in.to_mm.size()));
    if (in.from_mm.size() > kMaxPoints)
        return expected_error("from_mm", "at most " + std::to_string(kMaxPoints) + " points",
                              std::to_string(in.from_mm.size()), ErrorCode::LimitExceeded);
    for (std::size_t n = 0; n < in.from_mm.size(); ++n)
        for (const bool is_from : {true, false}) {
            const Vec3d p = (is_from ? in.from_mm : in.to_mm)[n];
            if (!(norm(p) < kFarMm))
                return expected_error(is_from ? "from_mm" : "to_mm",
                                      "points within 1 km of the origin",
                                      "another one at " + std::to_string(n));
        }
    return Ok{};
}

Status check_input(const MorphInput& in) {
    if (const Status s = check_points(in); !s.ok()) return s;
    if (!in.from != !in.to)
        return expected_error(in.from ? "to" : "from", "label maps of both phases", "one");
    if (!in.from && !in.moduli.empty())
        return expected_error("moduli", "label maps that have the labels", "none");
    if (in.from_mm.empty() && !in.from)
        return expected_error("from_mm", "a known point or label maps", "neither");
    if (in.grid)
        if (const Status s = check_grid(*in.grid, "grid"); !s.ok()) return s;
    return Ok{};
}

struct Bounds {
    Vec3d low{0, 0, 0}, high{0, 0, 0};
    bool is_empty = true;

    void add(Vec3d p) {
        if (is_empty) low = high = p;
        is_empty = false;
        for (int a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], p[a]);
            high[a] = std::max(high[a], p[a]);
        }
    }
    double longest() const {
        const Vec3d d = high - low;
        return std::max({d.x, d.y, d.z});
    }
};

template <class Add>
void for_data(const MorphInput& in, const Parts& parts, const Add& add) {
    for (const Vec3d& p : in.from_mm) add(p);
    for (const Part& part : parts.list)
        for (const Vec3d& p : part.voxels_from) add(p);
}

/// The grid of the nodes: some voxels of a grid apart, around all data.
Grid node_grid(const MorphInput& in, const Parts& parts) {
    Bounds world;
    for_data(in, parts, [&](Vec3d p) { world.add(p); });
    const int count = parts.list.empty() ? kNodesOfPoints : kNodesOfShapes;
    const double longest = world.longest() > 0 ? world.longest() : count;
    const double h = longest / count;
    Grid base{{1, 1, 1}, {h, h, h}, world.low, kIdentity3};
    if (in.grid || in.from) base = in.grid ? *in.grid : in.from->grid;
    Bounds voxels;
    for_data(in, parts, [&](Vec3d p) { voxels.add(voxel_from_world(base, p)); });
    Grid nodes = base;
    Vec3d first{0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        const double step = std::max(1.0, std::round(h / base.spacing_mm[a]));
        const double margin = kMargin * longest / base.spacing_mm[a];
        first[a] = std::floor(voxels.low[a] - margin);
        nodes.size[a] = int(std::ceil((voxels.high[a] + margin - first[a]) / step)) + 1;
        nodes.spacing_mm[a] = step * base.spacing_mm[a];
    }
    nodes.origin_mm = world_from_voxel(base, first);
    return nodes;
}

/// Displacements of all nodes [mm, LPS].
/// @param[out] trend  the affine part alone
std::vector<Vec3d> sampled(const Plate& plate, const Grid& nodes, std::vector<Vec3d>& trend,
                           const TaskArena& arena) {
    std::vector<Vec3d> all(voxel_count(nodes));
    trend.resize(all.size());
    const auto size = std::size_t(nodes.size.x);
    const Vec3d step = nodes.spacing_mm.x * nodes.direction.columns[0];
    arena.for_each(
        std::int64_t(nodes.size.y) * nodes.size.z, 8, [&](std::int64_t begin, std::int64_t end) {
            std::vector<double> u[3];
            for (; begin < end; ++begin) {
                for (auto& component : u) component.assign(size, 0);
                const auto j = double(begin % nodes.size.y), k = double(begin / nodes.size.y);
                const Vec3d first = world_from_voxel(nodes, {0, j, k});
                plate.add_row(first, step, u[0], u[1], u[2]);
                for (std::size_t i = 0; i < size; ++i) {
                    const std::size_t n = std::size_t(begin) * size + i;
                    trend[n] = plate.trend(first + double(i) * step);
                    all[n] = trend[n] + Vec3d{u[0][i], u[1][i], u[2][i]};
                }
            }
        });
    return all;
}

/// Makes constraints near folded cells softer: those within two cells, or the nearest one.
/// @param position, softness  of constraint n
template <class Position, class Softness>
void soften(const std::vector<NodeMap::Cell>& cells, const Grid& nodes, std::size_t count,
            const Position& position, const Softness& softness) {
    const double reach = 2 * norm(nodes.spacing_mm);
    std::vector<char> is_near(count, 0);
    for (const NodeMap::Cell& cell : cells) {
        const Vec3d middle = world_from_voxel(
            nodes, {cell.lowest.x + 0.5, cell.lowest.y + 0.5, cell.lowest.z + 0.5});
        std::size_t best = 0;
        for (std::size_t n = 0; n < count; ++n) {
            const double distance = norm(position(n) - middle);
            if (distance < reach) is_near[n] = 1;
            if (distance < norm(position(best) - middle)) best = n;
        }
        is_near[best] = 1;
    }
    for (std::size_t n = 0; n < count; ++n)
        if (is_near[n]) softness(n) *= kSoftening;
}

/// The map of a spline, which is softened until no cell folds.
/// @param fit()  the spline; @param make_softer(cells)
template <class Fit, class Soften>
Result<NodeMap> unfolded(const Grid& nodes, const MorphSettings& settings, const TaskArena& arena,
                         const Fit& fit, const Soften& make_softer, MorphReport& report) {
    std::vector<Vec3d> u, trend;
    for (int round = 0; round <= kSoftenings; ++round) {
        u = sampled(fit(), nodes, trend, arena);
        NodeMap map(nodes, u);
        const auto cells = map.cells_below(settings.least_volume, report.least_volume, arena);
        if (cells.empty()) return map;
        if (2 * cells.size() > u.size()) break;  // nothing that is local
        if (round < kSoftenings) {
            make_softer(cells);
            ++report.softened;
        }
    }
    for (int n = 1; n <= int(1 / kFlattening + 0.5); ++n) {
        report.affine_share = n * kFlattening;
        std::vector<Vec3d> flatter = u;
        for (std::size_t m = 0; m < u.size(); ++m)
            flatter[m] = u[m] + report.affine_share * (trend[m] - u[m]);
        NodeMap map(nodes, flatter);
        if (map.cells_below(settings.least_volume, report.least_volume, arena).empty()) return map;
    }
    return expected_error("to_mm", "a motion without a fold",
                          "one that turns the inside out: its affine part has a determinant "
                          "below " +
                              toml_text(settings.least_volume));
}

/// The bodies as one spline through samples of them.
std::vector<PlatePoint> samples_of(const Parts& parts, const std::vector<BodyField>& bodies) {
    std::vector<PlatePoint> samples;
    for (std::size_t p = 0; p < bodies.size(); ++p) {
        const Part& part = parts.list[p];
        const auto add = [&](Vec3d x) { samples.push_back({x, bodies[p].at(x), kBodySoftnessMm}); };
        for (const Vec3d& x : part.from.points) add(x);
        std::vector<Vec3d> some;  // sorting all would take longer than the body
        const std::size_t step = part.voxels_from.size() / kInnerVoxels + 1;
        for (std::size_t n = step / 2; n < part.voxels_from.size(); n += step)
            some.push_back(part.voxels_from[n]);
        for (const std::size_t n : morph::thinned(some, kInnerPoints)) add(some[n]);
    }
    return samples;
}

std::vector<BodyField> move_bodies(const Parts& parts, const ElasticSettings& settings,
                                   const TaskArena& arena) {
    std::vector<BodyField> bodies(parts.list.size());
    arena.for_each(std::int64_t(bodies.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (; begin < end; ++begin)
            bodies[std::size_t(begin)] = move_body(parts.list[std::size_t(begin)], settings);
    });
    return bodies;
}

/// Rows of known points.
std::vector<PlateRow> rows_of(const MorphInput& in, double softness) {
    std::vector<PlateRow> rows;
    for (std::size_t n = 0; n < in.from_mm.size(); ++n)
        for (int a = 0; a < 3; ++a) {
            Vec3d axis{0, 0, 0};
            axis[a] = 1;
            rows.push_back({in.from_mm[n], axis, in.to_mm[n][a] - in.from_mm[n][a], softness});
        }
    return rows;
}

/// A trend and the spline of what it leaves.
Plate fit_beside(const Plate& trend, std::vector<PlateRow> rows) {
    for (PlateRow& row : rows) row.gap -= dot(row.n, trend.at(row.x));
    return sum_of(trend, fit_rows(rows));
}

/// Rows of points and of surfaces that slide, matched in rounds.
std::vector<PlateRow> sliding_rows(const MorphInput& in, const Parts& parts, const Plate& trend,
                                   const MorphSettings& settings, const TaskArena& arena) {
    const std::vector<PlateRow> known = rows_of(in, settings.point_softness_mm);
    std::vector<PlateRow> rows = known;
    bool is_first = true;
    for (const double start : kSlideStarts) {
        const Plate so_far =
            is_first && !morph::span_space(in.from_mm) ? trend : fit_beside(trend, rows);
        is_first = false;
        std::vector<std::vector<PlateRow>> slides(parts.list.size());
        arena.for_each(std::int64_t(slides.size()), 1, [&](std::int64_t begin, std::int64_t end) {
            for (; begin < end; ++begin) {
                const Part& part = parts.list[std::size_t(begin)];
                Moved moved;
                for (const Vec3d& x : part.from.points) moved.points.push_back(x + so_far.at(x));
                for (std::size_t n = 0; n < part.from.points.size(); ++n)
                    moved.normals.push_back(morph::moved_normal(
                        so_far.gradient(part.from.points[n]), part.from.normals[n]));
                for (const Slide& slide : slides_of(part, moved))
                    slides[std::size_t(begin)].push_back({part.from.points[slide.point],
                                                          slide.normal, slide.gap,
                                                          start * settings.slide_softness_mm});
            }
        });
        rows = known;
        for (const auto& part : slides) rows.insert(rows.end(), part.begin(), part.end());
    }
    return rows;
}

void complete(const MorphInput& in, const Parts& parts, const NodeMap& map, MorphReport& report) {
    report.points = int(in.from_mm.size());
    report.parts = int(parts.list.size());
    for (std::size_t n = 0; n < in.from_mm.size(); ++n)
        report.point_residual_mm +=
            norm(in.from_mm[n] + map.displacement_mm(in.from_mm[n]) - in.to_mm[n]) /
            double(in.from_mm.size());
    for (const Part& part : parts.list) {
        Moved moved;
        for (std::size_t n = 0; n < part.from.points.size(); ++n) {
            const Vec3d x = part.from.points[n];
            moved.points.push_back(x + map.displacement_mm(x));
            moved.normals.push_back(part.from.normals[n]);
        }
        report.surface_residual_mm +=
            morph::surface_residual_mm(part, moved) / double(parts.list.size());
    }
    for_data(in, parts, [&](Vec3d p) {
        report.max_displacement_mm =
            std::max(report.max_displacement_mm, norm(map.displacement_mm(p)));
    });
}

Result<NodeMap> solve(const MorphInput& in, const Parts& parts, const MorphSettings& settings,
                      const TaskArena& arena, MorphReport& report) {
    const Grid nodes = node_grid(in, parts);
    std::vector<PlatePoint> points;
    if (parts.list.empty()) {
        for (std::size_t n = 0; n < in.from_mm.size(); ++n)
            points.push_back(
                {in.from_mm[n], in.to_mm[n] - in.from_mm[n], settings.point_softness_mm});
    } else {
        report.has_prior = settings.prior == MorphPrior::Supine ||
                           (settings.prior == MorphPrior::Auto && parts.are_lungs);
        const ElasticSettings elastic{settings.poisson_ratio, settings.bending_mm2,
                                      !report.has_prior ? 0
                                      : parts.back != 0 ? parts.back
                                                        : 1,
                                      in.from_mm.empty() ? kBodyWeights : kTrendWeights};
        points = samples_of(parts, move_bodies(parts, elastic, arena));
    }
    std::vector<PlateRow> rows;
    if (!parts.list.empty() && !in.from_mm.empty())
        rows = sliding_rows(in, parts, fit_points(points), settings, arena);
    return unfolded(
        nodes, settings, arena,
        [&] {
            const Plate plate = fit_points(points);
            return rows.empty() ? plate : fit_beside(plate, rows);
        },
        [&](const std::vector<NodeMap::Cell>& cells) {
            soften(
                cells, nodes, points.size(), [&](std::size_t n) { return points[n].x; },
                [&](std::size_t n) -> double& { return points[n].softness; });
            if (!rows.empty())
                soften(
                    cells, nodes, rows.size(), [&](std::size_t n) { return rows[n].x; },
                    [&](std::size_t n) -> double& { return rows[n].softness; });
        },
        report);
}

}  // namespace

Result<Morph> Morph::create(const MorphInput& input, const MorphSettings& settings,
                            const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<Morph> {
        const Stopwatch watch;
        for (const auto& row : morph_rows())
            if (const auto value = checked_value(row, shown_value(row, row.get(settings)));
                !value.ok())
                return value.error();
        if (const Status s = check_input(input); !s.ok()) return s.error();
        Parts parts;
        if (input.from) {
            auto found = morph::find_parts(*input.from, *input.to, input.moduli, arena);
            if (!found.ok()) return found.error();
            parts = std::move(*found);
        }
        MorphReport report;
        auto map = solve(input, parts, settings, arena, report);
        if (!map.ok()) return map.error();
        complete(input, parts, *map, report);
        report.solve_ms = watch.ms();
        return Morph(std::make_unique<Impl>(Impl{std::move(*map), report}));
    });
}

Morph::Morph(std::unique_ptr<Impl> impl) noexcept : m_impl(std::move(impl)) {}
Morph::~Morph() = default;
Morph::Morph(Morph&&) noexcept = default;
Morph& Morph::operator=(Morph&&) noexcept = default;

Vec3d Morph::forward(Vec3d from_mm) const noexcept {
    if (!(norm(from_mm) < kFarMm)) return from_mm;
    return from_mm + m_impl->map.displacement_mm(from_mm);
}

Vec3d Morph::inverse(Vec3d to_mm) const noexcept {
    if (!(norm(to_mm) < kFarMm)) return to_mm;
    return m_impl->map.inverse_mm(to_mm, -m_impl->map.displacement_mm(to_mm));
}

const Grid& Morph::nodes() const noexcept {
    return m_impl->map.grid();
}
const MorphReport& Morph::report() const noexcept {
    return m_impl->report;
}

namespace {

/// Fills a field row by row. @param vector(point, last)  at a voxel; last: of the voxel before
template <class Of>
Result<VectorField> filled(const Grid& grid, FieldKind kind, const TaskArena& arena,
                           const Of& vector) {
    return attempt([&]() -> Result<VectorField> {
        if (const Status s = check_grid(grid, "grid"); !s.ok()) return s.error();
        VectorField field{grid, kind, std::vector<Vec3f>(voxel_count(grid))};
        arena.for_each(
            std::int64_t(grid.size.y) * grid.size.z, 16, [&](std::int64_t begin, std::int64_t end) {
                for (; begin < end; ++begin) {
                    const auto j = double(begin % grid.size.y), k = double(begin / grid.size.y);
                    std::optional<Vec3d> last;
                    Vec3f* to = field.vectors_mm.data() + begin * grid.size.x;
                    for (int i = 0; i < grid.size.x; ++i) {
                        last = vector(world_from_voxel(grid, {double(i), j, k}), last);
                        *to++ = {float(last->x), float(last->y), float(last->z)};
                    }
                }
            });
        return field;
    });
}

}  // namespace

Result<VectorField> Morph::forward_field(const Grid& grid, const TaskArena& arena) const noexcept {
    return filled(grid, FieldKind::Modeling, arena, [&](Vec3d p, const std::optional<Vec3d>&) {
        return m_impl->map.displacement_mm(p);
    });
}

Result<VectorField> Morph::inverse_field(const Grid& grid, const TaskArena& arena) const noexcept {
    const NodeMap& map = m_impl->map;
    return filled(grid, FieldKind::Resampling, arena,
                  [&](Vec3d p, const std::optional<Vec3d>& last) {
                      return map.inverse_mm(p, last ? *last : -map.displacement_mm(p)) - p;
                  });
}

}  // namespace pliant
