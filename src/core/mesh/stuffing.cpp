// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Isosurface stuffing in five passes over the lattice: signs, cuts, warping, stencils, numbering.
// As published, warping is decided node by node: a node that moves removes the cuts of its edges
// from its neighbours. Here the order is that of four colours (corners and centres, even and odd).
// Nodes of one colour share no edge, so the result is independent of threads.

#include <pliant/mesh.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include "base/errors.h"
#include "mesh/bcc_lattice.h"
#include "mesh/box_tree.h"
#include "mesh/stuffing_stencils.h"

namespace pliant {
namespace {

using mesh::BccLattice;
using mesh::BccNode;

class Stuffing {
  public:
    Stuffing(const LevelFunction& level, const StuffingSettings& settings, const TaskArena& arena)
        : m_level(level), m_settings(settings), m_arena(arena) {}

    Status lay_lattice();
    Status find_signs();
    void find_cuts();
    void warp();
    TetMesh stuff() const;

  private:
    template <class Body>
    void for_each_layer(const Body& body) const {
        m_arena.for_each(m_lattice.size.z, 1, [&](std::int64_t begin, std::int64_t end) {
            for (std::int64_t k = begin; k < end; ++k) body(std::int32_t(k));
        });
    }
    /// Calls body(node, its number) for a layer's nodes in order.
    template <class Body>
    void for_nodes_of(std::int32_t k, const Body& body) const {
        std::int32_t v = m_lattice.index({0, {0, 0, k}});
        for (std::int32_t j = 0; j < m_lattice.size.y; ++j)
            for (std::int32_t i = 0; i < m_lattice.size.x; ++i)
                for (int g = 0; g < 2; ++g) body(BccNode{g, {i, j, k}}, v++);
    }
    void fill_block(Vec3i first, std::atomic<std::int32_t>& wrong);
    bool at_border(BccNode n) const {
        for (int a = 0; a < 3; ++a)
            if (n.cell[a] == 0 || n.cell[a] + 1 >= m_lattice.size[a] - n.grid) return true;
        return false;
    }
    std::int8_t sign(BccNode n) const { return m_sign[std::size_t(m_lattice.index(n))]; }
    double cut_of(BccNode a, BccNode b) const;
    /// Index of the cut on a crossing edge.
    std::int32_t cut_index(BccNode n, int slot) const {
        if (!BccLattice::owns(n.grid, slot)) {
            n = BccLattice::neighbour(n, slot);
            slot = BccLattice::opposite(slot);
        }
        const auto v = std::size_t(m_lattice.index(n));
        return m_first_cut[v] + std::popcount(m_crossed[v] & ((1u << slot) - 1));
    }
    Vec3d cut_position(BccNode n, int slot) const {
        if (!BccLattice::owns(n.grid, slot)) {
            n = BccLattice::neighbour(n, slot);
            slot = BccLattice::opposite(slot);
        }
        const double t = m_cuts[std::size_t(cut_index(n, slot))];
        const Vec3d a = m_lattice.position(n),
                    b = m_lattice.position(BccLattice::neighbour(n, slot));
        return a + t * (b - a);
    }
    Vec3d warped_position(std::int32_t v) const {
        const BccNode n = m_lattice.node(v);
        const int slot = m_warp[std::size_t(v)];
        return slot < 0 ? m_lattice.position(n) : cut_position(n, slot);
    }
    void warp_node(BccNode n, std::int32_t v);
    void stuff_tetrahedron(const BccNode (&corners)[4],
                           std::vector<std::array<std::int32_t, 4>>& cells) const;
    std::int32_t key(const BccNode (&corners)[4], mesh::StencilCorner c) const {
        const BccNode n = corners[c.first];
        if (c.first == c.second) return m_lattice.index(n);
        const int slot = BccLattice::slot_between(n, corners[c.second]);
        return std::int32_t(m_lattice.node_count()) + cut_index(n, slot);
    }
    Vec3d position_of(std::int32_t key) const;

    const LevelFunction& m_level;
    const StuffingSettings& m_settings;
    const TaskArena& m_arena;
    BccLattice m_lattice;
    // Per lattice node:
    std::vector<float> m_value;            ///< value of the function; only its sign is valid far
                                           ///< away
    std::vector<std::int8_t> m_sign;       ///< 0: on the surface, or warped onto it
    std::vector<std::uint16_t> m_crossed;  ///< bits of owned edges that cross the surface
    std::vector<std::int32_t> m_first_cut;
    std::vector<std::int8_t> m_warp;  ///< slot of the cut that it was warped to; −1: none
    // Per cut:
    std::vector<double> m_cuts;  ///< position 0…1 from the edge's owner
    std::vector<std::int32_t> m_cut_owner;
    std::vector<std::int8_t> m_cut_slot;
};

Error bad_field(const std::string& what) {
    return {ErrorCode::InvalidArgument, "isosurface stuffing: " + what};
}
std::string text(double value) {
    return std::to_string(value);
}

Status Stuffing::lay_lattice() {
    const StuffingSettings& s = m_settings;
    if (!(s.cell_mm > 0) || !std::isfinite(s.cell_mm))
        return bad_field("cell_mm is " + text(s.cell_mm) + ", expected a length above 0");
    if (!(s.alpha_long >= 0 && s.alpha_long < 0.5))
        return bad_field("alpha_long is " + text(s.alpha_long) + ", expected 0 to 0.5");
    if (!(s.alpha_short >= 0 && s.alpha_short < 0.5))
        return bad_field("alpha_short is " + text(s.alpha_short) + ", expected 0 to 0.5");
    if (!is_finite(s.begin_mm) || !is_finite(s.end_mm)) return bad_field("the box is not finite");
    m_lattice.cell_mm = s.cell_mm;
    double nodes = 2;
    for (int a = 0; a < 3; ++a) {
        if (!(s.begin_mm[a] < s.end_mm[a]))
            return bad_field("the box ends before it begins along " + std::string(1, "xyz"[a]));
        // One cell of margin; the grid of centres is one row shorter in effect.
        const double cells = std::ceil((s.end_mm[a] - s.begin_mm[a]) / s.cell_mm) + 4;
        nodes *= cells;
        if (nodes > 2.0 * double(s.max_cells) || nodes > double(1 << 30))
            return Error{ErrorCode::LimitExceeded,
                         "isosurface stuffing: a box of " + text(s.end_mm.x - s.begin_mm.x) +
                             " × " + text(s.end_mm.y - s.begin_mm.y) + " × " +
                             text(s.end_mm.z - s.begin_mm.z) + " mm in cells of " +
                             text(s.cell_mm) + " mm, expected " + std::to_string(s.max_cells) +
                             " cells at most"};
        m_lattice.size[a] = std::int32_t(cells);
        m_lattice.origin_mm[a] = s.begin_mm[a] - s.cell_mm;
    }
    return Ok{};
}

/// Evaluates a block of 8³ cells, by one call if the surface is certainly far away.
void Stuffing::fill_block(Vec3i first, std::atomic<std::int32_t>& wrong_node) {
    constexpr int kBlock = 8;
    const auto evaluate = [&](BccNode n) {
        const double value = m_level(m_lattice.position(n));
        if (!std::isfinite(value)) {
            // The smallest node, so that the message is independent of threads.
            const std::int32_t v = m_lattice.index(n);
            std::int32_t least = wrong_node.load();
            while (v < least && !wrong_node.compare_exchange_weak(least, v)) {
            }
        }
        return value;
    };
    double all = 0;
    if (m_settings.changes_as_distance) {
        constexpr int kHalf = kBlock / 2;
        const double value = evaluate({0, first + Vec3i{kHalf, kHalf, kHalf}});
        // Distance to the farthest node of the block plus one edge: the block's edges can't cross.
        const double reach = (std::sqrt(3.0) * kHalf + 1.01) * m_lattice.cell_mm;
        if (std::abs(value) > reach) all = value;
    }
    for (std::int32_t k = first.z; k < std::min(first.z + kBlock, m_lattice.size.z); ++k)
        for (std::int32_t j = first.y; j < std::min(first.y + kBlock, m_lattice.size.y); ++j)
            for (std::int32_t i = first.x; i < std::min(first.x + kBlock, m_lattice.size.x); ++i)
                for (int g = 0; g < 2; ++g) {
                    const BccNode n{g, {i, j, k}};
                    const auto v = std::size_t(m_lattice.index(n));
                    const double value = all != 0 ? all : evaluate(n);
                    m_value[v] = float(value);
                    m_sign[v] = std::int8_t(m_value[v] > 0 ? 1 : m_value[v] < 0 ? -1 : 0);
                }
}

Status Stuffing::find_signs() {
    constexpr int kBlock = 8;
    const auto count = std::size_t(m_lattice.node_count());
    m_value.resize(count);
    m_sign.resize(count);
    Vec3i blocks{};
    for (int a = 0; a < 3; ++a) blocks[a] = (m_lattice.size[a] + kBlock - 1) / kBlock;
    constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::max();
    std::atomic<std::int32_t> not_finite{kNone}, outside{kNone};
    m_arena.for_each(std::int64_t(blocks.x) * blocks.y * blocks.z, 1,
                     [&](std::int64_t begin, std::int64_t end) {
                         for (std::int64_t b = begin; b < end; ++b) {
                             const auto row = std::int32_t(b / blocks.x);
                             fill_block({kBlock * std::int32_t(b % blocks.x),
                                         kBlock * (row % blocks.y), kBlock * (row / blocks.y)},
                                        not_finite);
                         }
                     });
    const auto where = [&](std::int32_t v) {
        const Vec3d p = m_lattice.position(m_lattice.node(v));
        return "(" + text(p.x) + ", " + text(p.y) + ", " + text(p.z) + ")";
    };
    if (not_finite != kNone) return bad_field("the function is not finite at " + where(not_finite));
    std::atomic<bool> any{false};
    for_each_layer([&](std::int32_t k) {
        for_nodes_of(k, [&](BccNode n, std::int32_t v) {
            if (m_sign[std::size_t(v)] <= 0) return;
            any.store(true, std::memory_order_relaxed);
            if (!at_border(n)) return;
            std::int32_t least = outside.load();
            while (v < least && !outside.compare_exchange_weak(least, v)) {
            }
        });
    });
    if (outside != kNone)
        return bad_field("the solid reaches the box's border at " + where(outside) +
                         ", expected a box that holds it");
    if (!any) return bad_field("nothing is inside, expected a solid thicker than a cell");
    return Ok{};
}

/// Zero of the function between two nodes, 0…1, by regula falsi with the Illinois rule.
double Stuffing::cut_of(BccNode a, BccNode b) const {
    const Vec3d from = m_lattice.position(a), way = m_lattice.position(b) - from;
    double low = 0, high = 1;
    double f_low = m_value[std::size_t(m_lattice.index(a))];
    double f_high = m_value[std::size_t(m_lattice.index(b))];
    int side = 0;
    double t = 0.5;
    for (int step = 0; step < 60; ++step) {
        t = low + (high - low) * (f_low / (f_low - f_high));
        if (!(t > low && t < high)) t = 0.5 * (low + high);
        const double f = m_level(from + t * way);
        if (std::abs(f) <= 1e-10 * m_lattice.cell_mm || high - low < 1e-10) break;
        if ((f > 0) == (f_low > 0)) {
            low = t;
            f_low = f;
            if (side == -1) f_high *= 0.5;
            side = -1;
        } else {
            high = t;
            f_high = f;
            if (side == 1) f_low *= 0.5;
            side = 1;
        }
    }
    return t;
}

void Stuffing::find_cuts() {
    const auto count = std::size_t(m_lattice.node_count());
    m_crossed.assign(count, 0);
    for_each_layer([&](std::int32_t k) {
        for_nodes_of(k, [&](BccNode n, std::int32_t v) {
            const int own = m_sign[std::size_t(v)];
            if (own == 0) return;
            for (int slot = 0; slot < mesh::kBccSlots; ++slot) {
                const BccNode other = BccLattice::neighbour(n, slot);
                if (BccLattice::owns(n.grid, slot) && m_lattice.inside(other) &&
                    sign(other) == -own)
                    m_crossed[std::size_t(v)] =
                        std::uint16_t(m_crossed[std::size_t(v)] | 1u << slot);
            }
        });
    });
    m_first_cut.resize(count);
    for (std::size_t v = 0; v < count; ++v) {
        m_first_cut[v] = std::int32_t(m_cut_owner.size());
        for (unsigned bits = m_crossed[v]; bits != 0; bits &= bits - 1) {
            m_cut_owner.push_back(std::int32_t(v));
            m_cut_slot.push_back(std::int8_t(std::countr_zero(bits)));
        }
    }
    m_cuts.resize(m_cut_owner.size());
    m_arena.for_each(std::int64_t(m_cuts.size()), 256, [&](std::int64_t begin, std::int64_t end) {
        for (auto c = std::size_t(begin); c < std::size_t(end); ++c) {
            const BccNode n = m_lattice.node(m_cut_owner[c]);
            m_cuts[c] = cut_of(n, BccLattice::neighbour(n, m_cut_slot[c]));
        }
    });
}

void Stuffing::warp_node(BccNode n, std::int32_t v) {
    const int own = m_sign[std::size_t(v)];
    if (own == 0) return;
    double nearest = std::numeric_limits<double>::infinity();
    int to = -1;
    for (int slot = 0; slot < mesh::kBccSlots; ++slot) {
        const BccNode other = BccLattice::neighbour(n, slot);
        if (!m_lattice.inside(other) || sign(other) != -own) continue;
        double t = m_cuts[std::size_t(cut_index(n, slot))];
        if (!BccLattice::owns(n.grid, slot)) t = 1 - t;
        const bool is_long = BccLattice::is_long(slot);
        if (t >= (is_long ? m_settings.alpha_long : m_settings.alpha_short)) continue;
        const double distance = t * (is_long ? 1 : std::sqrt(0.75));
        if (distance < nearest) {
            nearest = distance;
            to = slot;
        }
    }
    if (to < 0) return;
    m_warp[std::size_t(v)] = std::int8_t(to);
    m_sign[std::size_t(v)] = 0;
}

void Stuffing::warp() {
    m_warp.assign(std::size_t(m_lattice.node_count()), -1);
    for (int grid = 0; grid < 2; ++grid)
        for (const bool even : {true, false})
            for_each_layer([&](std::int32_t k) {
                for_nodes_of(k, [&](BccNode n, std::int32_t v) {
                    if (n.grid == grid && BccLattice::is_even(n) == even) warp_node(n, v);
                });
            });
}

Vec3d Stuffing::position_of(std::int32_t key) const {
    const auto nodes = std::int32_t(m_lattice.node_count());
    if (key < nodes) return warped_position(key);
    const auto c = std::size_t(key - nodes);
    return cut_position(m_lattice.node(m_cut_owner[c]), m_cut_slot[c]);
}

void Stuffing::stuff_tetrahedron(const BccNode (&corners)[4],
                                 std::vector<std::array<std::int32_t, 4>>& cells) const {
    std::array<std::int8_t, 4> signs;
    for (std::size_t n = 0; n < 4; ++n) signs[n] = sign(corners[n]);
    const mesh::Stencil& stencil =
        mesh::stencil_of(signs, BccLattice::is_even(corners[0]), BccLattice::is_even(corners[2]));
    const auto length = [&](const mesh::StencilCorner(&d)[2]) {
        const Vec3d way = position_of(key(corners, d[0])) - position_of(key(corners, d[1]));
        return dot(way, way);
    };
    const bool other =
        !stencil.other.empty() && length(stencil.other_diagonal) < length(stencil.diagonal);
    for (const auto& t : other ? stencil.other : stencil.tetrahedra)
        cells.push_back(
            {key(corners, t[0]), key(corners, t[1]), key(corners, t[2]), key(corners, t[3])});
}

TetMesh Stuffing::stuff() const {
    std::vector<std::vector<std::array<std::int32_t, 4>>> layers(std::size_t(m_lattice.size.z));
    for_each_layer([&](std::int32_t k) {
        auto& cells = layers[std::size_t(k)];
        for_nodes_of(k, [&](BccNode n, std::int32_t) {
            if (n.grid == 0) return;
            for (int axis = 0; axis < 3; ++axis) {
                // The tetrahedra around an edge between two centres share the face of the two
                // cubes.
                const BccNode next = BccLattice::neighbour(n, 2 * axis);
                if (!m_lattice.inside(next)) continue;
                const int u = (axis + 1) % 3, v = (axis + 2) % 3;
                BccNode face[4];
                for (int c = 0; c < 4; ++c) {
                    face[c] = {0, next.cell};
                    face[c].cell[u] += c == 1 || c == 2;
                    face[c].cell[v] += c >= 2;
                }
                if (!m_lattice.inside(face[2])) continue;
                for (int c = 0; c < 4; ++c)
                    stuff_tetrahedron({n, next, face[c], face[(c + 1) % 4]}, cells);
            }
        });
    });
    TetMesh mesh;
    std::size_t count = 0;
    for (const auto& layer : layers) count += layer.size();
    mesh.cells.reserve(count);
    for (const auto& layer : layers)
        mesh.cells.insert(mesh.cells.end(), layer.begin(), layer.end());
    // Lattice nodes keep their order; cuts follow.
    std::vector<std::int32_t> number(std::size_t(m_lattice.node_count()) + m_cuts.size(), -1);
    for (const auto& cell : mesh.cells)
        for (const std::int32_t k : cell) number[std::size_t(k)] = 0;
    for (std::size_t k = 0; k < number.size(); ++k) {
        if (number[k] < 0) continue;
        number[k] = std::int32_t(mesh.nodes_mm.size());
        mesh.nodes_mm.push_back(position_of(std::int32_t(k)));
    }
    for (auto& cell : mesh.cells)
        for (std::int32_t& k : cell) k = number[std::size_t(k)];
    return mesh;
}

constexpr double kCellsPerCube = 12;  ///< tetrahedra of the lattice in a cube
constexpr double kTooFew = 24;        ///< tetrahedra of which no organ consists

constexpr Setting<FillSettings> kRows[] = {
    setting<&FillSettings::cell_mm>({.name = "cell_mm",
                                     .unit = "mm",
                                     .range = {0, 1000},
                                     .text = "edge of the lattice's cubes; 0: so that there are "
                                             "about as many tetrahedra as wanted"}),
    setting<&FillSettings::tetrahedra>({.name = "tetrahedra",
                                        .range = {kTooFew, 10'000'000},
                                        .text = "approximate number, without cell_mm"}),
};

mesh::Bounds bounds_of(std::span<const Vec3d> nodes) {
    mesh::Bounds b;
    for (const Vec3d& p : nodes) b.add(p);
    return b;
}

Result<FilledSurface> fill(TriangleMesh surface, const FillSettings& settings,
                           const TaskArena& arena) {
    if (const Status s = check(settings, fill_rows()); !s.ok()) return s.error();
    if (const Status s = check_closed(surface); !s.ok()) return s.error();
    FilledSurface filled;
    filled.surface_mm3 = enclosed_volume_mm3(surface);
    if (filled.surface_mm3 < 0) {  // its triangles face inwards
        for (auto& t : surface.cells) std::swap(t[1], t[2]);
        filled.surface_mm3 = -filled.surface_mm3;
    }
    const mesh::Bounds bounds = bounds_of(surface.nodes_mm);
    const auto distance = SurfaceDistance::create(std::move(surface));
    if (!distance) return distance.error();
    filled.cell_mm =
        settings.cell_mm > 0
            ? settings.cell_mm
            : std::cbrt(kCellsPerCube * filled.surface_mm3 / double(settings.tetrahedra));
    const double margin = 0.01 * filled.cell_mm;
    auto mesh = stuff_isosurface([&](Vec3d x) { return -distance->signed_mm(x); },
                                 {.begin_mm = bounds.low - Vec3d{margin, margin, margin},
                                  .end_mm = bounds.high + Vec3d{margin, margin, margin},
                                  .cell_mm = filled.cell_mm,
                                  .changes_as_distance = true},
                                 arena);
    if (!mesh) return mesh.error();
    filled.mesh = std::move(*mesh);
    filled.removed_cells = make_manifold(filled.mesh);
    if (double(filled.mesh.cells.size()) < kTooFew)
        return expected_error("cell_mm", "cells that are smaller than the solid",
                              std::to_string(filled.cell_mm) + " mm, with which " +
                                  std::to_string(filled.mesh.cells.size()) +
                                  " tetrahedra are left");
    filled.dropped_pieces = drop_crumbs(filled.mesh);
    return filled;
}

}  // namespace

Result<TetMesh> stuff_isosurface(const LevelFunction& level, const StuffingSettings& settings,
                                 const TaskArena& arena) {
    Stuffing stuffing(level, settings, arena);
    if (const Status lattice = stuffing.lay_lattice(); !lattice) return lattice.error();
    if (const Status signs = stuffing.find_signs(); !signs) return signs.error();
    stuffing.find_cuts();
    stuffing.warp();
    TetMesh mesh = stuffing.stuff();
    if (mesh.cells.empty())
        return bad_field("no tetrahedron is left, expected a solid thicker than a cell");
    return mesh;
}

// A closed surface is stuffed as the level set of its signed distance. Cells where the boundary
// would touch itself are taken away, and small pieces that this cuts off.

SettingRows<FillSettings> fill_rows() noexcept {
    return kRows;
}

Result<FilledSurface> fill_surface(TriangleMesh surface, const FillSettings& settings,
                                   const TaskArena& arena) noexcept {
    return attempt([&] { return fill(std::move(surface), settings, arena); });
}

}  // namespace pliant
