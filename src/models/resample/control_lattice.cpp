// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Interpolates nodes' displacements at elements: row by row of the scan's bricks, first along y and
// z, where a row has one weight each, then along x.

#include <pliant/resample.h>
#include <pliant/result.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "base/errors.h"
#include "field/trilinear_cell.h"
#include "field/writable_field.h"
#include "resample/control_cuts.h"
#include "resample/scatter_job.h"

namespace pliant {
namespace {

constexpr int kBrickSize = 8;
constexpr std::int64_t kControlBricksPerTask = 16;
constexpr int kBlockNodes = 4;  ///< along an edge of a block that moves at once

double mix(double a, double b, double t) {
    return (1 - t) * a + t * b;
}

/// Cell of an element along one axis, and its position in it.
struct InCell {
    int cell;
    double t;
};
InCell in_cell_of(int element, int first, int cell, int nodes) {
    const int from = element - first;
    const int at = std::min(from / cell, nodes - 2);
    return {at, double(from - at * cell) / cell};
}

}  // namespace

struct ControlLattice::Impl {
    Impl(const Volume& v, const ControlGrid& g, const TaskArena& a)
        : scan(v), arena(a), grid(g), field(v.grid, kBrickSize) {
        region.begin = g.first;
        for (int c = 0; c < 3; ++c) region.end[c] = g.first[c] + g.cell[c] * (g.size[c] - 1) + 1;
        bricks = bricks_of(region, kBrickSize);
        is_listed.assign(dense_count(bricks.end - bricks.begin), 0);
        for (auto& axis : units) axis.assign(dense_count(g.size), 0.0);
    }

    std::size_t node_at(Vec3i n) const { return dense_index(n, grid.size); }
    Vec3d shift_mm(std::size_t n) const {
        return (1 / kUnitsPerMm) * Vec3d{units[0][n], units[1][n], units[2][n]};
    }

    Status place(std::span<const Vec3d> displacements_mm);
    Result<bool> approach(std::span<const Vec3d> displacements_mm, std::int64_t max_elements,
                          double least_mm);
    Status move_to(const std::vector<Vec3d>& along);
    double lag_mm(std::size_t node, Vec3d along) const;
    Result<std::vector<Vec3d>> along_axes(std::span<const Vec3d> displacements_mm) const;
    Status set_cuts(std::span<const CutTriangle> triangles_mm);
    void add_ghosts(const ControlCuts& made, std::vector<Vec3d>& along) const;
    /// Lists bricks and allocates their memory, all or none. @param list  calls list_bricks_at
    template <class List>
    void list_bricks(const List& list);
    void list_bricks_at(Vec3i node);
    void write_listed();
    void write(FieldBrick& brick) const;
    void write_row(FieldBrick& brick, int row, Vec3i from, int width) const;
    void write_cut_cells(FieldBrick& brick, int row, Vec3i from, int width) const;
    std::size_t node_count() const { return dense_count(grid.size); }
    Vec3i node_position(std::int32_t node) const {
        return {node % grid.size.x, node / grid.size.x % grid.size.y,
                node / (grid.size.x * grid.size.y)};
    }
    /// Corners of a cell, moved by shift(node) [mm along the lattice's axes]. In voxels.
    template <class Shift>
    std::array<Vec3d, 8> corners(Vec3i cell, const Shift& shift) const;
    template <class Shift>
    std::optional<ControlPosition> find(Vec3d point_mm, const Shift& shift) const;

    const Volume& scan;
    const TaskArena& arena;
    ControlGrid grid;
    WritableField field;
    Deformation deformation{field};
    Box3i region;  ///< voxels that follow the nodes
    Box3i bricks;  ///< bricks that hold them
    /// Displacements of nodes and ghosts, along i, j, k [2⁻²⁰ mm].
    std::array<std::vector<double>, 3> units;
    ControlCuts cuts;
    std::vector<std::uint8_t> is_listed;  ///< [brick of bricks]; all 0 between calls
    std::vector<int> listed;              ///< indices of bricks to be written
};

ControlLattice::ControlLattice(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
ControlLattice::~ControlLattice() = default;

namespace {

Status check_grid(const Volume& volume, const ControlGrid& grid) {
    if (const Status s = check_volume(volume); !s.ok()) return s.error();
    for (int a = 0; a < 3; ++a) {
        const auto expected = [&](const char* what, int low, int found) {
            return Error{ErrorCode::InvalidArgument,
                         std::string("control lattice ") + what + ": expected at least " +
                             std::to_string(low) + " along axis " + std::to_string(a) + ", found " +
                             std::to_string(found)};
        };
        if (grid.size[a] < 2) return expected("size", 2, grid.size[a]);
        if (grid.cell[a] < 1) return expected("cell", 1, grid.cell[a]);
        if (grid.first[a] < 0) return expected("first voxel", 0, grid.first[a]);
        const std::int64_t last = grid.first[a] + std::int64_t(grid.cell[a]) * (grid.size[a] - 1);
        if (last >= volume.grid.size[a])
            return Error{ErrorCode::InvalidArgument,
                         "control lattice: expected its last nodes at voxel " +
                             std::to_string(volume.grid.size[a] - 1) + " or before along axis " +
                             std::to_string(a) + ", found " + std::to_string(last)};
    }
    return Ok{};
}

}  // namespace

Result<std::unique_ptr<ControlLattice>> ControlLattice::create(const Volume& volume,
                                                               const ControlGrid& grid,
                                                               const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<std::unique_ptr<ControlLattice>> {
        if (const Status s = check_grid(volume, grid); !s.ok()) return s.error();
        auto impl = std::make_unique<Impl>(volume, grid, arena);
        return std::unique_ptr<ControlLattice>(new ControlLattice(std::move(impl)));
    });
}

void ControlLattice::Impl::list_bricks_at(Vec3i node) {
    Box3i voxels;
    for (int a = 0; a < 3; ++a) {
        const int at = grid.first[a] + grid.cell[a] * node[a];
        voxels.begin[a] = at - grid.cell[a] + 1;
        voxels.end[a] = at + grid.cell[a];
    }
    for_each_in(bricks_of(overlap(voxels, region), kBrickSize), [&](Vec3i brick) {
        std::uint8_t& flag =
            is_listed[dense_index(brick - bricks.begin, bricks.end - bricks.begin)];
        if (flag) return;
        flag = 1;
        listed.push_back(-1);  // allocates before the brick is created
        listed.back() = field.ensure_brick(brick);
    });
}

void ControlLattice::Impl::write_row(FieldBrick& brick, int row, Vec3i from, int width) const {
    const InCell y = in_cell_of(from.y, grid.first.y, grid.cell.y, grid.size.y);
    const InCell z = in_cell_of(from.z, grid.first.z, grid.cell.z, grid.size.z);
    std::array<InCell, kBrickSize> along;
    for (int x = 0; x < width; ++x)
        along[std::size_t(x)] = in_cell_of(from.x + x, grid.first.x, grid.cell.x, grid.size.x);
    const int first = along[0].cell, last = along[std::size_t(width - 1)].cell + 1;
    const std::size_t up = std::size_t(grid.size.x), over = up * std::size_t(grid.size.y);
    const std::size_t low = node_at({0, y.cell, z.cell});
    for (std::size_t a = 0; a < 3; ++a) {
        const double* node = units[a].data() + low;
        std::array<double, kBrickSize + 1> line;
        for (int n = first; n <= last; ++n) {
            const double* at = node + n;
            line[std::size_t(n - first)] =
                mix(mix(at[0], at[up], y.t), mix(at[over], at[over + up], y.t), z.t);
        }
        Fixed* to = brick.u[a] + row;
        for (int x = 0; x < width; ++x) {
            const InCell p = along[std::size_t(x)];
            const auto n = std::size_t(p.cell - first);
            to[x] = Fixed(std::lrint(mix(line[n], line[n + 1], p.t)));
        }
    }
    if (!cuts.ghosts().empty()) write_cut_cells(brick, row, from, width);
}

/// Elements of a row that follow ghosts.
void ControlLattice::Impl::write_cut_cells(FieldBrick& brick, int row, Vec3i from,
                                           int width) const {
    const InCell y = in_cell_of(from.y, grid.first.y, grid.cell.y, grid.size.y);
    const InCell z = in_cell_of(from.z, grid.first.z, grid.cell.z, grid.size.z);
    for (int i = 0; i < width; ++i) {
        const InCell x = in_cell_of(from.x + i, grid.first.x, grid.cell.x, grid.size.x);
        const Vec3i cell{x.cell, y.cell, z.cell};
        Vec3i at = from + Vec3i{i, 0, 0} - grid.first;
        for (int a = 0; a < 3; ++a) at[a] -= cell[a] * grid.cell[a];
        const std::int32_t* corner = cuts.corners(cell, at);
        if (!corner) continue;
        for (std::size_t a = 0; a < 3; ++a) {
            const auto along_x = [&](int c) {
                return mix(units[a][std::size_t(corner[c])], units[a][std::size_t(corner[c + 1])],
                           x.t);
            };
            brick.u[a][row + i] = Fixed(std::lrint(
                mix(mix(along_x(0), along_x(2), y.t), mix(along_x(4), along_x(6), y.t), z.t)));
        }
    }
}

void ControlLattice::Impl::write(FieldBrick& brick) const {
    const Vec3i first = kBrickSize * brick.coord;
    const Box3i inside =
        overlap({first, first + Vec3i{kBrickSize, kBrickSize, kBrickSize}}, region);
    const int count = kBrickSize * kBrickSize * kBrickSize;
    const Vec3i n = inside.end - inside.begin;
    if (n.x * n.y * n.z < count)
        for (Fixed* u : brick.u) std::fill_n(u, count, 0);
    for_each_row(inside, [&](Vec3i p) {
        const Vec3i local = p - first;
        write_row(brick, local.x + kBrickSize * (local.y + kBrickSize * local.z), p, n.x);
    });
}

/// Displacements along the lattice's axes [mm], after a check.
Result<std::vector<Vec3d>> ControlLattice::Impl::along_axes(
    std::span<const Vec3d> displacements_mm) const {
    if (displacements_mm.size() != node_count())
        return Error{ErrorCode::InvalidArgument,
                     "control lattice: expected displacements of " + std::to_string(node_count()) +
                         " nodes, found " + std::to_string(displacements_mm.size())};
    const Mat3d axes = inverse(scan.grid.direction);
    std::vector<Vec3d> along(displacements_mm.size());
    for (std::size_t n = 0; n < along.size(); ++n) {
        along[n] = axes * displacements_mm[n];
        for (int a = 0; a < 3; ++a)
            if (!(std::abs(along[n][a]) <= kMaxMovementMm))
                return Error{ErrorCode::InvalidArgument,
                             "control lattice: expected displacements of up to " +
                                 std::to_string(int(kMaxMovementMm)) + " mm, found " +
                                 std::to_string(along[n][a]) + " at node " + std::to_string(n)};
    }
    return along;
}

/// Appends the displacements of ghosts.
void ControlLattice::Impl::add_ghosts(const ControlCuts& made, std::vector<Vec3d>& along) const {
    for (const ControlCuts::Ghost& ghost : made.ghosts()) {
        Vec3d sum{0, 0, 0};
        for (const std::int32_t node : ghost.like) sum = sum + along[std::size_t(node)];
        along.push_back((1.0 / double(ghost.like.size())) * sum);
    }
}

template <class List>
void ControlLattice::Impl::list_bricks(const List& list) {
    const auto unlist = [&] { std::fill(is_listed.begin(), is_listed.end(), std::uint8_t(0)); };
    listed.clear();
    try {
        list();
    } catch (...) {
        unlist();
        if (!listed.empty() && listed.back() < 0) listed.pop_back();
        field.drop_still_bricks(listed);
        throw;
    }
    unlist();
}

void ControlLattice::Impl::write_listed() {
    const std::uint64_t now = field.tick();
    const auto task = [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t b = begin; b < end; ++b) {
            FieldBrick& brick = field.brick(listed[std::size_t(b)]);
            write(brick);
            field.written(brick, now);
        }
    };
    arena.for_each(std::int64_t(listed.size()), kControlBricksPerTask, std::ref(task));
    field.drop_still_bricks(listed);
}

Status ControlLattice::Impl::place(std::span<const Vec3d> displacements_mm) {
    Result<std::vector<Vec3d>> along = along_axes(displacements_mm);
    if (!along) return along.error();
    return move_to(*along);
}

/// @param of_nodes  their displacements along the lattice's axes [mm]
Status ControlLattice::Impl::move_to(const std::vector<Vec3d>& of_nodes) {
    std::vector<Vec3d> along = of_nodes;
    add_ghosts(cuts, along);
    const auto has_moved = [&](std::size_t n) { return lag_mm(n, along[n]) > 0; };
    list_bricks([&] {
        for_each_in({{0, 0, 0}, grid.size}, [&](Vec3i ijk) {
            if (has_moved(node_at(ijk))) list_bricks_at(ijk);
        });
        for (std::size_t n = 0; n < cuts.ghosts().size(); ++n)
            if (has_moved(node_count() + n)) list_bricks_at(node_position(cuts.ghosts()[n].node));
    });
    for (std::size_t n = 0; n < along.size(); ++n)
        for (int a = 0; a < 3; ++a) units[std::size_t(a)][n] = kUnitsPerMm * along[n][a];
    write_listed();
    return Ok{};
}

/// Largest difference between a node's displacement and its written one, along an axis [mm].
double ControlLattice::Impl::lag_mm(std::size_t node, Vec3d along) const {
    double lag = 0;
    for (int a = 0; a < 3; ++a)
        lag = std::max(lag, std::abs(kUnitsPerMm * along[a] - units[std::size_t(a)][node]));
    return lag / kUnitsPerMm;
}

Result<bool> ControlLattice::Impl::approach(std::span<const Vec3d> displacements_mm,
                                            std::int64_t max_elements, double least_mm) {
    const Result<std::vector<Vec3d>> wanted = along_axes(displacements_mm);
    if (!wanted) return wanted.error();
    if (!cuts.ghosts().empty()) {
        if (const Status s = move_to(*wanted); !s.ok()) return s.error();
        return true;
    }
    struct Block {
        Box3i nodes;
        double lag_mm = 0;
    };
    std::vector<Block> blocks;
    const Vec3i block{kBlockNodes, kBlockNodes, kBlockNodes};
    bool lags = false;
    for_each_in(bricks_of({{0, 0, 0}, grid.size}, kBlockNodes), [&](Vec3i coord) {
        const Vec3i first = kBlockNodes * coord;
        Block made{overlap({first, first + block}, {{0, 0, 0}, grid.size})};
        for_each_in(made.nodes, [&](Vec3i node) {
            const std::size_t n = node_at(node);
            made.lag_mm = std::max(made.lag_mm, lag_mm(n, (*wanted)[n]));
        });
        lags |= made.lag_mm > 0;
        if (made.lag_mm > least_mm) blocks.push_back(made);
    });
    std::stable_sort(blocks.begin(), blocks.end(),
                     [](const Block& p, const Block& q) { return p.lag_mm > q.lag_mm; });
    std::vector<Vec3d> along(node_count());
    for (std::size_t n = 0; n < along.size(); ++n) along[n] = shift_mm(n);
    const std::int64_t cell = std::int64_t(grid.cell.x) * grid.cell.y * grid.cell.z;
    std::int64_t elements = 0;
    std::size_t moved = 0;
    for (; moved < blocks.size() && elements < max_elements; ++moved) {
        const Box3i& nodes = blocks[moved].nodes;
        const Vec3i cells = nodes.end - nodes.begin + Vec3i{1, 1, 1};
        elements += cell * cells.x * cells.y * cells.z;
        for_each_in(nodes, [&](Vec3i node) { along[node_at(node)] = (*wanted)[node_at(node)]; });
    }
    if (const Status s = move_to(along); !s.ok()) return s.error();
    return !lags || (least_mm == 0 && moved == blocks.size());
}

Result<bool> ControlLattice::approach(std::span<const Vec3d> displacements_mm,
                                      std::int64_t max_elements, double least_mm) noexcept {
    return attempt([&] { return m_impl->approach(displacements_mm, max_elements, least_mm); });
}

Status ControlLattice::place(std::span<const Vec3d> displacements_mm) noexcept {
    return attempt([&] { return m_impl->place(displacements_mm); });
}

Status ControlLattice::Impl::set_cuts(std::span<const CutTriangle> triangles_mm) {
    Result<ControlCuts> made =
        ControlCuts::create(scan.grid, grid, triangles_mm, kBrickSize, arena);
    if (!made) return made.error();
    std::vector<Vec3d> along(node_count());
    for (std::size_t n = 0; n < along.size(); ++n) along[n] = shift_mm(n);
    add_ghosts(*made, along);
    for (auto& axis : units) axis.reserve(along.size());
    EditMap edits = made->edits();
    for (const auto& [brick, flags] : cuts.edits()) edits.try_emplace(brick);
    field.prepare_edits(edits);
    try {
        list_bricks([&] {
            for (const ControlCuts* own : {&cuts, &*made})
                for (const ControlCuts::Ghost& ghost : own->ghosts())
                    list_bricks_at(node_position(ghost.node));
        });
    } catch (...) {
        field.finish_edits(edits);
        throw;
    }
    cuts = std::move(*made);
    for (std::size_t a = 0; a < 3; ++a) {
        units[a].resize(along.size());
        for (std::size_t n = node_count(); n < along.size(); ++n)
            units[a][n] = kUnitsPerMm * along[n][int(a)];
    }
    field.exchange_edits(edits);
    field.finish_edits(edits);
    write_listed();
    return Ok{};
}

Status ControlLattice::set_cuts(std::span<const CutTriangle> triangles_mm) noexcept {
    return attempt([&] { return m_impl->set_cuts(triangles_mm); });
}

std::span<const CutTriangle> ControlLattice::cuts_mm() const {
    return m_impl->cuts.triangles_mm();
}

bool ControlLattice::is_cut(Vec3d from_mm, Vec3d to_mm) const {
    const Grid& grid = m_impl->scan.grid;
    return m_impl->cuts.is_between(voxel_from_world(grid, from_mm), voxel_from_world(grid, to_mm));
}

template <class Shift>
std::array<Vec3d, 8> ControlLattice::Impl::corners(Vec3i cell, const Shift& shift) const {
    std::array<Vec3d, 8> positions;
    for (int c = 0; c < 8; ++c) {
        const Vec3i node = cell + Vec3i{c & 1, c >> 1 & 1, c >> 2};
        const Vec3d u = shift(node_at(node));
        for (int a = 0; a < 3; ++a)
            positions[std::size_t(c)][a] =
                grid.first[a] + grid.cell[a] * node[a] + u[a] / scan.grid.spacing_mm[a];
    }
    return positions;
}

/// @param shift  displacement of a node along the lattice's axes [mm]
template <class Shift>
std::optional<ControlPosition> ControlLattice::Impl::find(Vec3d point_mm,
                                                          const Shift& shift) const {
    const Impl& m = *this;
    const Vec3d point = voxel_from_world(m.scan.grid, point_mm);
    std::optional<ControlPosition> found;
    for_each_in({{0, 0, 0}, m.grid.size - Vec3i{1, 1, 1}}, [&](Vec3i cell) {
        if (found) return;
        const std::array<Vec3d, 8> positions = m.corners(cell, shift);
        for (int a = 0; a < 3; ++a) {
            const auto [low, high] = std::minmax_element(
                positions.begin(), positions.end(), [a](Vec3d p, Vec3d q) { return p[a] < q[a]; });
            if (point[a] < (*low)[a] - 1e-6 || point[a] > (*high)[a] + 1e-6) return;
        }
        const auto at = TrilinearCell(positions).locate(point);
        if (!at) return;
        found = ControlPosition{{}, *at};
        for (int c = 0; c < 8; ++c)
            found->nodes[std::size_t(c)] =
                std::int32_t(m.node_at(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2}));
    });
    return found;
}

std::optional<ControlPosition> ControlLattice::find(Vec3d point_mm) const {
    return m_impl->find(point_mm, [&](std::size_t n) { return m_impl->shift_mm(n); });
}

std::optional<ControlPosition> ControlLattice::find(Vec3d point_mm,
                                                    std::span<const Vec3d> displacements_mm) const {
    PLIANT_ASSERT(displacements_mm.size() == m_impl->node_count());
    const Mat3d axes = inverse(m_impl->scan.grid.direction);
    return m_impl->find(point_mm, [&](std::size_t n) { return axes * displacements_mm[n]; });
}

bool ControlLattice::folds(std::span<const Vec3d> displacements_mm, double share) const {
    const Impl& m = *m_impl;
    PLIANT_ASSERT(displacements_mm.size() == m.node_count());
    const Mat3d axes = inverse(m.scan.grid.direction);
    const double least =
        share * double(m.grid.cell.x) * double(m.grid.cell.y) * double(m.grid.cell.z);
    bool any = false;
    for_each_in({{0, 0, 0}, m.grid.size - Vec3i{1, 1, 1}}, [&](Vec3i cell) {
        bool moved = false;
        const auto shift = [&](std::size_t n) {
            moved |= displacements_mm[n] != Vec3d{0, 0, 0};
            return axes * displacements_mm[n];
        };
        if (any) return;
        const std::array<Vec3d, 8> p = m.corners(cell, shift);
        if (!moved) return;
        for (std::size_t c = 0; c < 8; ++c) {
            const auto edge = [&](std::size_t step) {
                return c & step ? p[c] - p[c ^ step] : p[c ^ step] - p[c];
            };
            any |= dot(edge(1), cross(edge(2), edge(4))) <= least;
        }
    });
    return any;
}

const ControlGrid& ControlLattice::grid() const {
    return m_impl->grid;
}
std::int32_t ControlLattice::node_count() const {
    return std::int32_t(m_impl->node_count());
}
Vec3d ControlLattice::node_mm(std::int32_t node) const {
    const ControlGrid& g = m_impl->grid;
    const Vec3i n = m_impl->node_position(node);
    Vec3d ijk;
    for (int a = 0; a < 3; ++a) ijk[a] = g.first[a] + double(g.cell[a]) * n[a];
    return world_from_voxel(m_impl->scan.grid, ijk);
}

const Volume& ControlLattice::volume() const {
    return m_impl->scan;
}
const Deformation& ControlLattice::deformation() const {
    return m_impl->deformation;
}
const TaskArena& ControlLattice::arena() const {
    return m_impl->arena;
}

}  // namespace pliant
