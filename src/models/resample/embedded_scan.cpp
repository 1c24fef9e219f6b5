// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "resample/embedded_scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "base/errors.h"
#include "mesh/box_tree.h"
#include "mesh/triangle_distance.h"
#include "resample/scatter_job.h"

namespace pliant {
namespace {

constexpr std::int64_t kCarriedBricks = 8;
/// Tolerance of weights for voxels on a face, which rounding may place outside of both neighbours.
constexpr double kTolerance = 1e-9;
constexpr std::int32_t kAnySolid = -1;

int index_in_brick(Vec3i local) {
    return local.x + kCarriedBrickSize * (local.y + kCarriedBrickSize * local.z);
}

/// Voxels within reach of the mesh.
Box3i voxels_around(const Volume& scan, std::span<const Vec3d> nodes, double reach_mm) {
    Box3i box{{0, 0, 0}, {0, 0, 0}};
    for (int a = 0; a < 3; ++a) {
        double low = 1e300, high = -1e300;
        for (const Vec3d& p : nodes) {
            low = std::min(low, p[a]);
            high = std::max(high, p[a]);
        }
        const double reach = reach_mm / scan.grid.spacing_mm[a];
        box.begin[a] = int(std::clamp(std::ceil(low - reach), 0.0, double(scan.grid.size[a])));
        box.end[a] = int(std::clamp(std::floor(high + reach) + 1, 0.0, double(scan.grid.size[a])));
    }
    return box;
}

/// Surfaces of the solids, searchable by distance.
class Surfaces {
  public:
    Surfaces(const TetMesh& mesh, std::span<const std::int32_t> solids) : m_mesh(mesh) {
        std::vector<std::int32_t> cells;
        // Solids that share nodes have faces of their own all the same.
        std::int32_t count = 1;
        for (const std::int32_t s : solids) count = std::max(count, s + 1);
        for (std::int32_t s = 0; s < count; ++s) {
            TetMesh part{mesh.nodes_mm, {}};
            std::vector<std::int32_t> numbers;
            for (std::size_t c = 0; c < mesh.cells.size(); ++c)
                if (solids.empty() || solids[c] == s) {
                    part.cells.push_back(mesh.cells[c]);
                    numbers.push_back(std::int32_t(c));
                }
            const auto faces = boundary_faces(part, &cells);
            std::vector<mesh::Bounds> boxes(faces.size());
            for (std::size_t f = 0; f < faces.size(); ++f) {
                for (const std::int32_t n : faces[f]) boxes[f].add(mesh.nodes_mm[std::size_t(n)]);
                m_faces.push_back(faces[f]);
                m_cells.push_back(numbers[std::size_t(cells[f])]);
            }
            m_trees.push_back({mesh::BoxTree(boxes), std::int64_t(m_faces.size() - faces.size())});
        }
    }

    struct Nearest {
        std::int64_t face = -1;
        Vec3d position{0, 0, 0};
        double squared = 0;
    };
    /// @param candidates  faces, in their order; the first of several wins
    Nearest nearest(Vec3d x, std::span<const std::int64_t> candidates, double reach) const {
        Nearest found{-1, {}, reach * reach};
        for (const std::int64_t face : candidates)
            if (const Nearest near = at(x, face); near.squared < found.squared) found = near;
        return found;
    }
    /// Lists all faces that may be the nearest one, and within reach, of a point of a ball.
    void find_near(Vec3d centre, double radius, double reach, std::int32_t solid,
                   std::vector<std::int64_t>& faces) const {
        faces.clear();
        double best = (reach + radius) * (reach + radius);
        for_near(centre, solid, best, [&](std::int64_t face, double& limit) {
            best = limit = std::min(limit, at(centre, face).squared);
        });
        const double most = std::min(std::sqrt(best) + 2 * radius, reach + radius);
        for_near(centre, solid, most * most, [&](std::int64_t face, double& limit) {
            if (at(centre, face).squared <= limit) faces.push_back(face);
        });
        std::sort(faces.begin(), faces.end());
    }
    std::int32_t tetrahedron(std::int64_t face) const { return m_cells[std::size_t(face)]; }

  private:
    struct Tree {
        mesh::BoxTree tree;
        std::int64_t first;
    };
    template <class Visit>
    void for_near(Vec3d x, std::int32_t solid, double squared, const Visit& visit) const {
        for (std::size_t s = 0; s < m_trees.size(); ++s)
            if (solid == kAnySolid || std::size_t(solid) == s)
                m_trees[s].tree.nearest(x, squared, [&](std::int32_t f, double& limit) {
                    visit(m_trees[s].first + f, limit);
                });
    }
    Nearest at(Vec3d x, std::int64_t face) const {
        const auto& t = m_faces[std::size_t(face)];
        const auto near = mesh::nearest_on_triangle(x, m_mesh.nodes_mm[std::size_t(t[0])],
                                                    m_mesh.nodes_mm[std::size_t(t[1])],
                                                    m_mesh.nodes_mm[std::size_t(t[2])]);
        return {face, near.position, dot(x - near.position, x - near.position)};
    }

    const TetMesh& m_mesh;
    std::vector<std::array<std::int32_t, 3>> m_faces;
    std::vector<std::int32_t> m_cells;  ///< [face]
    std::vector<Tree> m_trees;
};

/// Finds the tetrahedra that voxels outside of their solids follow. Voxels of a small block share
/// the search for near faces.
class Followed {
  public:
    Followed(const Surfaces& surfaces, const Grid& grid, double reach_mm)
        : m_surfaces(surfaces), m_grid(grid), m_reach(reach_mm) {
        const Vec3d half = 0.5 * (kBlock - 1) * grid.spacing_mm;
        m_radius = norm(half) * (1 + kTolerance);
    }
    struct Found {
        std::int32_t tetrahedron;
        float fade;
        Vec3f nearest;
    };
    std::optional<Found> find(Vec3i p, std::int32_t solid) {
        const Vec3i block{p.x / kBlock, p.y / kBlock, p.z / kBlock};
        Near* near = nullptr;
        for (Near& n : m_near)
            if (n.block == block && n.solid == solid) near = &n;
        if (!near) {
            near = &m_near[m_next++ % m_near.size()];
            near->block = block;
            near->solid = solid;
            const double half = 0.5 * (kBlock - 1);
            m_surfaces.find_near(
                world_from_voxel(m_grid, {kBlock * block.x + half, kBlock * block.y + half,
                                          kBlock * block.z + half}),
                m_radius, m_reach, solid, near->faces);
        }
        const Vec3d x = world_from_voxel(m_grid, {double(p.x), double(p.y), double(p.z)});
        const auto nearest = m_surfaces.nearest(x, near->faces, m_reach);
        if (nearest.face < 0) return {};
        const double share = std::sqrt(nearest.squared) / m_reach;
        const Vec3d q = voxel_from_world(m_grid, nearest.position);
        return Found{m_surfaces.tetrahedron(nearest.face),
                     float((1 - share * share) * (1 - share * share)),
                     {float(q.x), float(q.y), float(q.z)}};
    }

  private:
    static constexpr int kBlock = 4;
    struct Near {
        Vec3i block{-1, -1, -1};
        std::int32_t solid = 0;
        std::vector<std::int64_t> faces;
    };
    const Surfaces& m_surfaces;
    const Grid& m_grid;
    double m_reach, m_radius;
    std::array<Near, 32> m_near;  ///< blocks of a brick, of some solids
    std::size_t m_next = 0;
};

}  // namespace

EmbeddedScan::EmbeddedScan(const Volume& volume, const TetMesh& mesh, const TaskArena& arena)
    : m_scan(volume),
      m_arena(arena),
      m_field(volume.grid, kCarriedBrickSize),
      m_cells(mesh.cells),
      m_rest_mm(mesh.nodes_mm) {
    for (const auto& cell : m_cells) {
        Vec3d x[4];
        for (std::size_t n = 0; n < 4; ++n)
            x[n] = voxel_from_world(volume.grid, mesh.nodes_mm[std::size_t(cell[n])]);
        const Vec3d b = x[1] - x[0], c = x[2] - x[0], d = x[3] - x[0];
        const double scale = 1 / dot(b, cross(c, d));
        m_rests.push_back({x[0], {scale * cross(c, d), scale * cross(d, b), scale * cross(b, c)}});
    }
    m_maps.resize(m_cells.size(), Map{});
    m_units.resize(m_rest_mm.size(), {0, 0, 0});
    m_next.resize(m_rest_mm.size(), {0, 0, 0});
}

Result<std::unique_ptr<EmbeddedScan>> EmbeddedScan::create(const Volume& volume,
                                                           const TetMesh& mesh,
                                                           const EmbeddedScanSettings& settings,
                                                           const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<EmbeddedScan>> {
        std::vector<Vec3d> ijk;
        for (const Vec3d& p : mesh.nodes_mm) ijk.push_back(voxel_from_world(volume.grid, p));
        const Box3i voxels = voxels_around(volume, ijk, settings.reach_mm);
        if (is_empty(voxels))
            return about("mesh", ErrorCode::InvalidArgument,
                         "expected a body inside of the scan, found one beside it");
        std::unique_ptr<EmbeddedScan> made(new EmbeddedScan(volume, mesh, arena));
        made->fill(settings, voxels);
        made->list_bricks_of_tetrahedra();
        return made;
    });
}

/// The tetrahedron that contains each voxel of a box, or −1; the first of several.
std::vector<std::int32_t> EmbeddedScan::find_inside(const EmbeddedScanSettings& settings,
                                                    const Box3i& voxels) const {
    std::vector<std::int32_t> inside(dense_count(voxels.end - voxels.begin), -1);
    for (std::size_t c = 0; c < m_cells.size(); ++c) {
        const Rest& rest = m_rests[c];
        mesh::Bounds bounds;
        for (const std::int32_t n : m_cells[c])
            bounds.add(voxel_from_world(m_scan.grid, m_rest_mm[std::size_t(n)]));
        Box3i box;
        for (int a = 0; a < 3; ++a) {
            box.begin[a] = int(std::ceil(bounds.low[a] - kTolerance));
            box.end[a] = int(std::floor(bounds.high[a] + kTolerance)) + 1;
        }
        const std::int32_t solid = settings.solids.empty() ? 0 : settings.solids[c];
        for_each_in(overlap(box, voxels), [&](Vec3i p) {
            std::int32_t& at = inside[dense_index(p - voxels.begin, voxels.end - voxels.begin)];
            if (at >= 0) return;
            const Vec3d x = Vec3d{double(p.x), double(p.y), double(p.z)} - rest.origin;
            double sum = 0;
            for (const Vec3d& slope : rest.slopes) {
                const double weight = dot(slope, x);
                if (weight < -kTolerance) return;
                sum += weight;
            }
            if (sum > 1 + kTolerance) return;
            if (settings.solid_at) {
                const std::int32_t own = settings.solid_at(p);
                if (own != kAnySolid && own != solid) return;
            }
            at = std::int32_t(c);
        });
    }
    return inside;
}

void EmbeddedScan::add_inside(Brick& brick, std::uint16_t index, std::int32_t cell) {
    if (!brick.runs.empty() && index % kCarriedBrickSize > 0) {
        Run& last = brick.runs.back();
        if (last.tetrahedron == cell && last.first + last.count == index) {
            ++last.count;
            return;
        }
    }
    brick.runs.push_back({cell, index, 1});
}

void EmbeddedScan::fill(const EmbeddedScanSettings& settings, const Box3i& voxels) {
    const std::vector<std::int32_t> inside = find_inside(settings, voxels);
    const TetMesh mesh{m_rest_mm, m_cells};
    const Surfaces surfaces(mesh, settings.solids);
    const Box3i coords = bricks_of(voxels, kCarriedBrickSize);
    const Vec3i counts = coords.end - coords.begin;
    std::vector<Brick> bricks(dense_count(counts));
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        Followed followed(surfaces, m_scan.grid, settings.reach_mm);
        for (auto b = std::size_t(begin); b < std::size_t(end); ++b) {
            Brick& brick = bricks[b];
            const auto n = int(b);
            brick.coord = coords.begin +
                          Vec3i{n % counts.x, n / counts.x % counts.y, n / (counts.x * counts.y)};
            for_each_in(overlap(box_of_brick(m_scan.grid, brick.coord, kCarriedBrickSize), voxels),
                        [&](Vec3i p) {
                            const auto index =
                                std::uint16_t(index_in_brick(p - kCarriedBrickSize * brick.coord));
                            const std::int32_t cell =
                                inside[dense_index(p - voxels.begin, voxels.end - voxels.begin)];
                            if (cell >= 0) return add_inside(brick, index, cell);
                            const std::int32_t solid =
                                settings.solid_at ? settings.solid_at(p) : kAnySolid;
                            if (solid < kAnySolid) return;
                            if (const auto found = followed.find(p, solid))
                                brick.followers.push_back(
                                    {found->tetrahedron, index, found->fade, found->nearest});
                        });
            brick.runs.shrink_to_fit();
            brick.followers.shrink_to_fit();
        }
    };
    m_arena.for_each(std::int64_t(bricks.size()), kCarriedBricks, std::ref(task));
    for (Brick& brick : bricks) {
        if (brick.runs.empty() && brick.followers.empty()) continue;
        for (const Run& run : brick.runs) m_voxels += run.count;
        m_voxels += std::int64_t(brick.followers.size());
        m_bricks.push_back(std::move(brick));
    }
    m_is_listed.assign(m_bricks.size(), 0);
}

void EmbeddedScan::list_bricks_of_tetrahedra() {
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;  // tetrahedron, brick
    for (std::size_t b = 0; b < m_bricks.size(); ++b) {
        const std::size_t first = pairs.size();
        for (const Run& run : m_bricks[b].runs) pairs.emplace_back(run.tetrahedron, b);
        for (const Follower& f : m_bricks[b].followers) pairs.emplace_back(f.tetrahedron, b);
        const auto from = pairs.begin() + std::ptrdiff_t(first);
        std::sort(from, pairs.end());
        pairs.erase(std::unique(from, pairs.end()), pairs.end());
    }
    std::sort(pairs.begin(), pairs.end());
    m_brick_starts.assign(m_cells.size() + 1, 0);
    for (const auto& [cell, brick] : pairs) {
        ++m_brick_starts[std::size_t(cell) + 1];
        m_bricks_of.push_back(brick);
    }
    for (std::size_t c = 0; c < m_cells.size(); ++c) m_brick_starts[c + 1] += m_brick_starts[c];
    m_moved.reserve(m_cells.size());
    m_listed.reserve(m_bricks.size());
    m_field_bricks.reserve(m_bricks.size());
}

// Cuts.

std::span<const std::array<std::int32_t, 4>> EmbeddedScan::cells() const {
    return m_cuts ? m_cuts->cells : m_cells;
}

std::span<const Vec3d> EmbeddedScan::rest_mm() const {
    return m_cuts ? m_cuts->rest_mm : m_rest_mm;
}

std::size_t EmbeddedScan::uncut_cell(std::size_t tetrahedron) const {
    return m_cuts ? std::size_t(m_cuts->uncut_cell_of[tetrahedron]) : tetrahedron;
}

std::int64_t EmbeddedScan::cut_links() const {
    return m_cuts ? m_cuts->links : 0;
}

/// A brick with the present cuts.
const EmbeddedScan::Brick& EmbeddedScan::shown(std::size_t brick) const {
    if (m_cuts) {
        const auto& numbers = m_cuts->numbers;
        const auto at = std::lower_bound(numbers.begin(), numbers.end(), std::int32_t(brick));
        if (at != numbers.end() && std::size_t(*at) == brick)
            return m_cuts->bricks[std::size_t(at - numbers.begin())];
    }
    return m_bricks[brick];
}

// Motion.

EmbeddedScan::Map EmbeddedScan::map_of(std::size_t tetrahedron) const {
    const auto& cell = cells()[tetrahedron];
    const Rest& rest = m_rests[uncut_cell(tetrahedron)];
    const Vec3d u = m_units[std::size_t(cell[0])];
    Map map{u, {}};
    for (std::size_t n = 0; n < 3; ++n) {
        const Vec3d by = m_units[std::size_t(cell[n + 1])] - u;
        for (int a = 0; a < 3; ++a) map.along[a] = map.along[a] + rest.slopes[n][a] * by;
    }
    map.shift = u - (rest.origin.x * map.along[0] + rest.origin.y * map.along[1] +
                     rest.origin.z * map.along[2]);
    return map;
}

void EmbeddedScan::write(const Brick& from, FieldBrick& to) const {
    for (Fixed* u : to.u)
        std::fill_n(u, kCarriedBrickSize * kCarriedBrickSize * kCarriedBrickSize, 0);
    const Vec3i first = kCarriedBrickSize * from.coord;
    for (const Run& run : from.runs) {
        const Map& map = m_maps[std::size_t(run.tetrahedron)];
        const int x = run.first % kCarriedBrickSize,
                  y = run.first / kCarriedBrickSize % kCarriedBrickSize,
                  z = run.first / (kCarriedBrickSize * kCarriedBrickSize);
        const Vec3d start = map.at({double(first.x + x), double(first.y + y), double(first.z + z)});
        for (int a = 0; a < 3; ++a)
            for (int n = 0; n < run.count; ++n)
                to.u[std::size_t(a)][run.first + n] =
                    Fixed(std::lrint(start[a] + n * map.along[0][a]));
    }
    for (const Follower& f : from.followers) {
        const Vec3d u =
            double(f.fade) * m_maps[std::size_t(f.tetrahedron)].at(
                                 {double(f.nearest.x), double(f.nearest.y), double(f.nearest.z)});
        for (int a = 0; a < 3; ++a) to.u[std::size_t(a)][f.index] = Fixed(std::lrint(u[a]));
    }
}

void EmbeddedScan::list_brick(std::int32_t brick) {
    std::uint8_t& flag = m_is_listed[std::size_t(brick)];
    if (!flag) m_listed.push_back(brick);
    flag = 1;
}

/// @param tetrahedron  without cuts
void EmbeddedScan::list_bricks_of(std::size_t tetrahedron) {
    for (auto b = std::size_t(m_brick_starts[tetrahedron]);
         b < std::size_t(m_brick_starts[tetrahedron + 1]); ++b)
        list_brick(m_bricks_of[b]);
}

void EmbeddedScan::end_list() {
    for (const std::int32_t b : m_listed) m_is_listed[std::size_t(b)] = 0;
    std::sort(m_listed.begin(), m_listed.end());
}

/// Allocates the memory of the listed bricks.
void EmbeddedScan::make_field_bricks() {
    m_field_bricks.clear();
    try {
        for (const std::int32_t b : m_listed)
            m_field_bricks.push_back(m_field.ensure_brick(m_bricks[std::size_t(b)].coord));
    } catch (...) {
        m_field.drop_still_bricks(m_field_bricks);
        throw;
    }
}

/// Lists the bricks of moved tetrahedra, and allocates their memory.
void EmbeddedScan::list_bricks(std::span<const Vec3d> units) {
    m_moved.clear();
    m_listed.clear();
    const auto now = cells();
    for (std::size_t c = 0; c < now.size(); ++c) {
        bool moved = false;
        for (const std::int32_t n : now[c])
            moved |= units[std::size_t(n)] != m_units[std::size_t(n)];
        if (!moved) continue;
        m_moved.push_back(std::int32_t(c));
        list_bricks_of(uncut_cell(c));
    }
    end_list();
    make_field_bricks();
}

void EmbeddedScan::write_listed() {
    const std::uint64_t now = m_field.tick();
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        for (auto b = std::size_t(begin); b < std::size_t(end); ++b) {
            FieldBrick& brick = m_field.brick(m_field_bricks[b]);
            write(shown(std::size_t(m_listed[b])), brick);
            m_field.written(brick, now);
        }
    };
    m_arena.for_each(std::int64_t(m_listed.size()), kCarriedBricks, std::ref(task));
    m_field.drop_still_bricks(m_field_bricks);
}

/// Displacements along the field's axes, in its units. @param[out] units  [node]
Status EmbeddedScan::find_units(std::span<const Vec3d> nodes_mm, std::span<const Vec3d> rest_mm,
                                std::vector<Vec3d>& units) const {
    if (nodes_mm.size() != rest_mm.size())
        return invalid("embedded scan: expected positions of " + std::to_string(rest_mm.size()) +
                       " nodes, found " + std::to_string(nodes_mm.size()));
    const Mat3d axes = inverse(m_scan.grid.direction);
    for (std::size_t n = 0; n < nodes_mm.size(); ++n) {
        const Vec3d along = axes * (nodes_mm[n] - rest_mm[n]);
        for (int a = 0; a < 3; ++a)
            if (!(std::abs(along[a]) <= kMaxMovementMm))
                return invalid("embedded scan: expected displacements of up to " +
                               std::to_string(int(kMaxMovementMm)) + " mm, found " +
                               std::to_string(along[a]) + " at node " + std::to_string(n));
        units[n] = kUnitsPerMm * along;
    }
    return Ok{};
}

Status EmbeddedScan::move(std::span<const Vec3d> nodes_mm) {
    if (const Status s = find_units(nodes_mm, rest_mm(), m_next); !s.ok()) return s;
    list_bricks(m_next);
    m_units.swap(m_next);
    for (const std::int32_t c : m_moved) m_maps[std::size_t(c)] = map_of(std::size_t(c));
    write_listed();
    return Ok{};
}

Status EmbeddedScan::move(std::shared_ptr<const Cuts> cuts, std::span<const Vec3d> nodes_mm) {
    const auto before = cells();
    const std::span<const std::array<std::int32_t, 4>> after = cuts ? cuts->cells : m_cells;
    const std::span<const Vec3d> rest = cuts ? cuts->rest_mm : m_rest_mm;
    std::vector<Vec3d> units(rest.size()), next(rest.size());
    if (const Status s = find_units(nodes_mm, rest, units); !s.ok()) return s;
    std::vector<Map> maps(after.size());
    m_moved.reserve(after.size());
    EditMap edits = cuts ? cuts->edits : EditMap{};
    if (m_cuts)
        for (const auto& [brick, flags] : m_cuts->edits) edits.try_emplace(brick);
    m_listed.clear();
    for (std::size_t c = 0; c < m_cells.size(); ++c) {
        bool moved = false;
        for (std::size_t k = 0; k < 4; ++k)
            moved |= m_units[std::size_t(before[c][k])] != units[std::size_t(after[c][k])];
        if (moved) list_bricks_of(c);
    }
    for (const Cuts* some : {m_cuts.get(), cuts.get()})
        if (some)
            for (const std::int32_t b : some->numbers) list_brick(b);
    end_list();
    m_field.prepare_edits(edits);
    try {
        make_field_bricks();
    } catch (...) {
        m_field.finish_edits(edits);
        throw;
    }
    m_cuts = std::move(cuts);
    m_units.swap(units);
    m_next.swap(next);
    m_maps.swap(maps);
    for (std::size_t c = 0; c < m_maps.size(); ++c) m_maps[c] = map_of(c);
    m_field.exchange_edits(edits);
    m_field.finish_edits(edits);
    write_listed();
    return Ok{};
}

Status EmbeddedScan::place(std::span<const Vec3d> nodes_mm) noexcept {
    return attempt([&] { return move(nodes_mm); });
}

Status EmbeddedScan::place(std::shared_ptr<const Cuts> cuts,
                           std::span<const Vec3d> nodes_mm) noexcept {
    return attempt([&] { return move(std::move(cuts), nodes_mm); });
}

}  // namespace pliant
