// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Voxels of a scan in a mesh with cuts. A voxel in a tetrahedron with copies follows the one whose
// polyhedron of material contains it. The line between two neighbours is followed from tetrahedron
// to tetrahedron:
//
//     ┌────────┬────────┬────────┐    A copy goes on in the next tetrahedron in the copy that has
//     │  p ────┼────────┼──── q  │    the same nodes in the face between them. If there is none,
//     │   copy │ copy   │ copy   │    or the last copy isn't the one that carries q, the link
//     └────────┴────────┴────────┘    from p to q is cut.
//
// Everything is decided by nodes and copies, so a blade through the centres of voxels leaves no
// link across it.

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "resample/embedded_scan.h"
#include "volume/boxes.h"

namespace pliant {
namespace {

constexpr int kBrickEdge = kCarriedBrickSize, kVoxels = kBrickEdge * kBrickEdge * kBrickEdge;
constexpr std::int64_t kCutBricks = 4;  ///< per task
/// Tetrahedra between two neighbouring voxels, at most; beyond that they count as linked.
constexpr int kMaxWay = 64;

Vec3i position_in_brick(int index) {
    return {index % kBrickEdge, index / kBrickEdge % kBrickEdge, index / (kBrickEdge * kBrickEdge)};
}

}  // namespace

class CutFinder {
  public:
    CutFinder(const EmbeddedScan& scan, const CutMesh& mesh) : m_scan(scan), m_mesh(mesh) {}

    std::shared_ptr<const EmbeddedScan::Cuts> find() {
        auto cuts = std::make_shared<EmbeddedScan::Cuts>();
        cuts->cells = m_mesh.mesh.cells;
        cuts->rest_mm = m_mesh.mesh.nodes_mm;
        cuts->uncut_cell_of = m_mesh.uncut_cell_of;
        find_near();
        find_neighbours();
        list_bricks(cuts->numbers);
        cuts->bricks.resize(cuts->numbers.size());
        m_carriers.resize(cuts->numbers.size());
        std::vector<BrickEdits> edits(cuts->numbers.size());
        for_bricks(cuts->numbers.size(), [&](std::size_t b) {
            cuts->bricks[b] = with_copies(m_scan.m_bricks[std::size_t(cuts->numbers[b])]);
            list_carriers(cuts->bricks[b], m_carriers[b]);
        });
        for (std::size_t b = 0; b < cuts->bricks.size(); ++b)
            m_brick_at[cuts->bricks[b].coord] = std::int32_t(b);
        for_bricks(cuts->numbers.size(),
                   [&](std::size_t b) { find_edits(cuts->bricks[b].coord, b, edits[b]); });
        for (std::size_t b = 0; b < edits.size(); ++b) {
            if (edits[b].empty()) continue;
            for (const std::uint8_t flags : edits[b])
                for (int a = 0; a < 3; ++a) cuts->links += flags >> a & 1;
            cuts->edits.emplace(cuts->bricks[b].coord, std::move(edits[b]));
        }
        return cuts;
    }

  private:
    using Brick = EmbeddedScan::Brick;
    /// Copy of a tetrahedron that a voxel follows.
    struct Carrier {
        std::int32_t copy = -1;
        bool is_inside = false;  ///< otherwise it follows from outside
    };
    using Carriers = std::array<Carrier, kVoxels>;
    struct Neighbour {
        std::int32_t cell = -1;
        int side = 0;  ///< of the cell
    };

    template <class Work>
    void for_bricks(std::size_t count, const Work& work) const {
        const auto task = [&](std::int64_t begin, std::int64_t end) {
            for (auto b = std::size_t(begin); b < std::size_t(end); ++b) work(b);
        };
        m_scan.m_arena.for_each(std::int64_t(count), kCutBricks, std::ref(task));
    }

    /// Tetrahedra with copies, or with a node that has copies.
    void find_near() {
        std::vector<std::uint8_t> has_copies(m_scan.m_rest_mm.size(), 0);
        for (std::size_t n = has_copies.size(); n < m_mesh.uncut_node_of.size(); ++n)
            has_copies[std::size_t(m_mesh.uncut_node_of[n])] = 1;
        m_number.assign(m_scan.m_cells.size(), -1);
        for (std::size_t c = 0; c < m_number.size(); ++c) {
            bool is_near = m_mesh.next_copy[c] >= 0;
            for (const std::int32_t n : m_scan.m_cells[c])
                is_near |= has_copies[std::size_t(n)] != 0;
            if (!is_near) continue;
            m_number[c] = std::int32_t(m_near.size());
            m_near.push_back(std::int32_t(c));
        }
    }

    void find_neighbours() {
        struct Face {
            std::array<std::int32_t, 3> nodes;
            Neighbour of;
        };
        std::vector<Face> faces;
        for (const std::int32_t c : m_near)
            for (int side = 0; side < 4; ++side) {
                Face face{{}, {c, side}};
                for (int k = 0; k < 3; ++k)
                    face.nodes[std::size_t(k)] =
                        m_scan.m_cells[std::size_t(c)][std::size_t((side + 1 + k) % 4)];
                std::sort(face.nodes.begin(), face.nodes.end());
                faces.push_back(face);
            }
        std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
            return a.nodes != b.nodes ? a.nodes < b.nodes : a.of.cell < b.of.cell;
        });
        m_neighbours.resize(m_near.size());
        const auto at = [&](Neighbour n) -> Neighbour& {
            return m_neighbours[std::size_t(m_number[std::size_t(n.cell)])][std::size_t(n.side)];
        };
        for (std::size_t f = 0; f + 1 < faces.size(); ++f) {
            if (faces[f].nodes != faces[f + 1].nodes) continue;
            at(faces[f].of) = faces[f + 1].of;
            at(faces[f + 1].of) = faces[f].of;
        }
    }

    void list_bricks(std::vector<std::int32_t>& numbers) const {
        for (const std::int32_t c : m_near)
            for (auto b = std::size_t(m_scan.m_brick_starts[std::size_t(c)]);
                 b < std::size_t(m_scan.m_brick_starts[std::size_t(c) + 1]); ++b)
                numbers.push_back(m_scan.m_bricks_of[b]);
        std::sort(numbers.begin(), numbers.end());
        numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    }

    Vec3d rest_of(Vec3d voxel) const { return world_from_voxel(m_scan.m_scan.grid, voxel); }
    bool has_copies(std::int32_t cell) const { return m_mesh.next_copy[std::size_t(cell)] >= 0; }

    Brick with_copies(const Brick& whole) const {
        Brick brick{whole.coord, {}, whole.followers};
        const Vec3i first = kBrickEdge * whole.coord;
        for (const EmbeddedScan::Run& run : whole.runs) {
            if (!has_copies(run.tetrahedron)) {
                brick.runs.push_back(run);
                continue;
            }
            for (int n = 0; n < run.count; ++n) {
                const auto index = std::uint16_t(run.first + n);
                const Vec3i p = first + position_in_brick(index);
                EmbeddedScan::add_inside(
                    brick, index,
                    m_mesh.copy_of(run.tetrahedron,
                                   rest_of({double(p.x), double(p.y), double(p.z)})));
            }
        }
        for (EmbeddedScan::Follower& f : brick.followers)
            if (has_copies(f.tetrahedron))
                f.tetrahedron = m_mesh.copy_of(
                    f.tetrahedron,
                    rest_of({double(f.nearest.x), double(f.nearest.y), double(f.nearest.z)}));
        return brick;
    }

    static void list_carriers(const Brick& brick, Carriers& carriers) {
        for (const EmbeddedScan::Run& run : brick.runs)
            for (int n = 0; n < run.count; ++n)
                carriers[std::size_t(run.first + n)] = {run.tetrahedron, true};
        for (const EmbeddedScan::Follower& f : brick.followers)
            carriers[f.index] = {f.tetrahedron, false};
    }

    /// @param[out] edits  empty if no link of the brick's voxels is cut
    void find_edits(Vec3i coord, std::size_t brick, BrickEdits& edits) const {
        for (int index = 0; index < kVoxels; ++index) {
            const Carrier from = m_carriers[brick][std::size_t(index)];
            if (!is_near(from)) continue;
            const Vec3i at = position_in_brick(index);
            for (int a = 0; a < 3; ++a) {
                Vec3i next = at, next_brick = coord;
                if (++next[a] == kBrickEdge) {
                    next[a] = 0;
                    ++next_brick[a];
                }
                const auto found = m_brick_at.find(next_brick);
                if (found == m_brick_at.end()) continue;
                const Carrier to = m_carriers[std::size_t(found->second)][dense_index(
                    next, {kBrickEdge, kBrickEdge, kBrickEdge})];
                if (!is_near(to)) continue;
                const Vec3i p = kBrickEdge * coord + at, q = kBrickEdge * next_brick + next;
                if (!is_cut(from, to, rest_of({double(p.x), double(p.y), double(p.z)}),
                            rest_of({double(q.x), double(q.y), double(q.z)})))
                    continue;
                edits.resize(kVoxels);
                edits[std::size_t(index)] = std::uint8_t(edits[std::size_t(index)] | (kCutX << a));
            }
        }
    }

    std::int32_t uncut_cell(std::int32_t copy) const {
        return m_mesh.uncut_cell_of[std::size_t(copy)];
    }
    bool is_near(Carrier c) const {
        return c.copy >= 0 && m_number[std::size_t(uncut_cell(c.copy))] >= 0;
    }
    std::int32_t node(std::int32_t copy, std::size_t corner) const {
        return m_mesh.mesh.cells[std::size_t(copy)][corner];
    }

    /// Whether copies have different nodes where their tetrahedra had the same one.
    bool are_apart(std::int32_t a, std::int32_t b) const {
        const auto &p = m_scan.m_cells[std::size_t(uncut_cell(a))],
                   &q = m_scan.m_cells[std::size_t(uncut_cell(b))];
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j)
                if (p[i] == q[j] && node(a, i) != node(b, j)) return true;
        return false;
    }

    /// Whether copies of two neighbours have the same nodes in the face between them.
    bool share_face(std::int32_t a, int side, std::int32_t b) const {
        const auto &p = m_scan.m_cells[std::size_t(uncut_cell(a))],
                   &q = m_scan.m_cells[std::size_t(uncut_cell(b))];
        for (std::size_t i = 0; i < 4; ++i) {
            if (i == std::size_t(side)) continue;
            for (std::size_t j = 0; j < 4; ++j)
                if (p[i] == q[j] && node(a, i) != node(b, j)) return false;
        }
        return true;
    }

    std::array<double, 4> weights_of(std::size_t cell, Vec3d rest_mm) const {
        const EmbeddedScan::Rest& rest = m_scan.m_rests[cell];
        const Vec3d x = voxel_from_world(m_scan.m_scan.grid, rest_mm) - rest.origin;
        std::array<double, 4> weights{1, 0, 0, 0};
        for (std::size_t k = 0; k < 3; ++k) {
            weights[k + 1] = dot(rest.slopes[k], x);
            weights[0] -= weights[k + 1];
        }
        return weights;
    }

    /// Side by which a line leaves a tetrahedron, or −1: it ends in there.
    int side_out(std::size_t cell, int came_by, Vec3d from, Vec3d to) const {
        const auto p = weights_of(cell, from), q = weights_of(cell, to);
        int side = -1;
        double first = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 4; ++k) {
            if (k == came_by || !(q[std::size_t(k)] < 0)) continue;
            const double fall = p[std::size_t(k)] - q[std::size_t(k)];
            const double at = fall > 0 ? p[std::size_t(k)] / fall : 0;
            if (at < first) {
                first = at;
                side = k;
            }
        }
        return side;
    }

    bool is_cut(Carrier from, Carrier to, Vec3d p, Vec3d q) const {
        if (uncut_cell(from.copy) == uncut_cell(to.copy)) return from.copy != to.copy;
        if (!from.is_inside || !to.is_inside) return are_apart(from.copy, to.copy);
        std::int32_t copy = from.copy;
        int came_by = -1;
        for (int n = 0; n < kMaxWay; ++n) {
            const std::int32_t cell = uncut_cell(copy);
            const int side = side_out(std::size_t(cell), came_by, p, q);
            if (side < 0) break;
            const Neighbour next =
                m_neighbours[std::size_t(m_number[std::size_t(cell)])][std::size_t(side)];
            if (next.cell < 0) break;
            if (next.cell == uncut_cell(to.copy)) return !share_face(copy, side, to.copy);
            std::int32_t on = next.cell;
            while (on >= 0 && !share_face(copy, side, on)) on = m_mesh.next_copy[std::size_t(on)];
            if (on < 0) return true;
            copy = on;
            came_by = next.side;
        }
        return are_apart(copy, to.copy);
    }

    const EmbeddedScan& m_scan;
    const CutMesh& m_mesh;
    std::vector<std::int32_t> m_near;    ///< tetrahedra whose copies or nodes a cut has separated
    std::vector<std::int32_t> m_number;  ///< [tetrahedron]: index in m_near, or −1
    std::vector<std::array<Neighbour, 4>> m_neighbours;  ///< [index in m_near]: across each side
    std::vector<Carriers> m_carriers;                    ///< [brick]
    std::unordered_map<Vec3i, std::int32_t, CoordHash> m_brick_at;
};

std::shared_ptr<const EmbeddedScan::Cuts> EmbeddedScan::find_cuts(const CutMesh& mesh) const {
    return CutFinder(*this, mesh).find();
}

}  // namespace pliant
