// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Virtual nodes [Molino2004, Sifakis2007]: a blade splits the polyhedra of material in the
// tetrahedra that it passes, then the nodes of these tetrahedra are copied.
//
// A point on an edge or a face of the mesh has the same bits in every tetrahedron: weights and sums
// are taken in the order of the uncut nodes' numbers, and the weights of other nodes are exactly 0.
// So neighbours find the same crossings, and divide their common face alike.

#include <pliant/models/cut_mesh.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "base/errors.h"
#include "mesh/blade.h"
#include "mesh/box_tree.h"
#include "mesh/cut_part.h"

namespace pliant {
namespace {

/// Largest distance of the ribbon's points and the nodes from the origin [mm].
constexpr double kFarthestCutMm = 1e5;

using mesh::Bounds;

bool meet(const Bounds& a, const Bounds& b) {
    for (int k = 0; k < 3; ++k)
        if (a.low[k] > b.high[k] || b.low[k] > a.high[k]) return false;
    return true;
}

/// The ribbon of one segment of the line.
struct Strip {
    std::array<Triangle, 2> triangles;
    BladePlane plane;
    Bounds box;

    bool crosses(Position p, Position q) const {
        return passes_inside(triangles[0], p, q) || passes_inside(triangles[1], p, q);
    }
};

/// Splits the parts of the tetrahedra near a ribbon.
class Cutter {
  public:
    Cutter(CutMesh& cut, std::span<const Vec3d> positions, double units_per_mm)
        : m_cut(cut),
          m_positions(positions),
          m_units(units_per_mm),
          m_is_changed(cut.mesh.cells.size(), 0) {}

    void cut(const std::vector<Strip>& strips) {
        Bounds all;
        for (const Strip& strip : strips) all.add(strip.box);
        std::vector<std::int32_t> near;
        for (std::size_t c = 0; c < m_cut.mesh.cells.size(); ++c)
            if (meet(box_of(c), all)) near.push_back(std::int32_t(c));
        for (const Strip& strip : strips) {
            const std::size_t count = near.size();
            for (std::size_t n = 0; n < count; ++n) {
                const auto c = std::size_t(near[n]);
                if (!meet(box_of(c), strip.box)) continue;
                const std::size_t before = m_cut.mesh.cells.size();
                cut_cell(c, strip);
                for (std::size_t k = before; k < m_cut.mesh.cells.size(); ++k)
                    near.push_back(std::int32_t(k));
            }
        }
    }

    /// [tetrahedron before the cut] whether it was split or lost a sliver
    const std::vector<std::uint8_t>& is_changed() const { return m_is_changed; }

  private:
    Bounds box_of(std::size_t cell) const {
        Bounds box;
        for (const std::int32_t n : m_cut.mesh.cells[cell]) box.add(m_positions[std::size_t(n)]);
        return box;
    }

    Position position_of(Vec3d mm) const {
        return {std::llround(m_units * mm.x), std::llround(m_units * mm.y),
                std::llround(m_units * mm.z)};
    }

    /// Corners by ascending number of their uncut nodes.
    void sort_corners(std::size_t cell) {
        const auto& nodes = m_cut.mesh.cells[cell];
        m_order = {0, 1, 2, 3};
        std::sort(m_order.begin(), m_order.end(), [&](std::size_t a, std::size_t b) {
            return m_cut.uncut_node_of[std::size_t(nodes[a])] <
                   m_cut.uncut_node_of[std::size_t(nodes[b])];
        });
    }

    Position position_of(std::size_t cell, const CutPart::Point& point) const {
        Vec3d sum{0, 0, 0};
        for (const std::size_t k : m_order)
            sum = sum + point.weights[k] * m_positions[std::size_t(m_cut.mesh.cells[cell][k])];
        return position_of(sum);
    }

    /// An order of an edge's ends that all tetrahedra agree on.
    bool comes_before(const CutPart::Point& a, const CutPart::Point& b) const {
        for (const std::size_t k : m_order)
            if (a.weights[k] != b.weights[k]) return a.weights[k] > b.weights[k];
        return false;
    }

    void cut_cell(std::size_t cell, const Strip& strip) {
        const std::int32_t index = m_cut.part_of[cell];
        if (index < 0 && !separates_corners(cell, strip)) return;
        sort_corners(cell);
        const CutPart& old = index < 0 ? m_whole : m_cut.parts[std::size_t(index)];
        find_crossings(cell, old, strip);
        if (m_crossings.empty()) return;
        CutPart part = old;
        for (const CutPart::Crossing& crossing : m_crossings) begin(part, crossing);
        if (find_components(part, m_component_of) > 1)
            replace(cell, pliant::split(std::move(part)));
        else
            keep(cell, std::move(part));
    }

    bool separates_corners(std::size_t cell, const Strip& strip) const {
        int sum = 0;
        for (const std::int32_t n : m_cut.mesh.cells[cell])
            sum += strip.plane.side(position_of(m_positions[std::size_t(n)]));
        return std::abs(sum) < 4;
    }

    /// Finds the edges of a part that the strip crosses.
    void find_crossings(std::size_t cell, const CutPart& part, const Strip& strip) {
        m_points.clear();
        m_sides.clear();
        m_crossings.clear();
        for (const CutPart::Point& point : part.points) {
            m_points.push_back(position_of(cell, point));
            m_sides.push_back(strip.plane.side(m_points.back()));
        }
        if (std::count(m_sides.begin(), m_sides.end(), m_sides[0]) == std::ssize(m_sides)) return;
        for (const CutPart::Face& face : part.faces)
            for (std::int32_t n = face.begin; n < face.end; ++n) {
                std::int32_t a = part.loops[std::size_t(n)];
                std::int32_t b = part.loops[std::size_t(n + 1 < face.end ? n + 1 : face.begin)];
                if (a > b || m_sides[std::size_t(a)] == m_sides[std::size_t(b)]) continue;
                if (!comes_before(part.points[std::size_t(a)], part.points[std::size_t(b)]))
                    std::swap(a, b);
                const Position p = m_points[std::size_t(a)], q = m_points[std::size_t(b)];
                if (!strip.crosses(p, q)) continue;
                const double level = strip.plane.level(p);
                m_crossings.push_back({a, b, level / (level - strip.plane.level(q))});
            }
    }

    /// A later crossing of the same edge replaces an earlier one.
    static void begin(CutPart& part, const CutPart::Crossing& crossing) {
        for (CutPart::Crossing& c : part.begun)
            if (c.a == crossing.a && c.b == crossing.b) {
                c = crossing;
                return;
            }
        part.begun.push_back(crossing);
    }

    void keep(std::size_t cell, CutPart part) {
        std::int32_t& index = m_cut.part_of[cell];
        if (index < 0) {
            index = std::int32_t(m_cut.parts.size());
            m_cut.parts.push_back(std::move(part));
        } else {
            m_cut.parts[std::size_t(index)] = std::move(part);
        }
    }

    /// Whether a sliver has something that other tetrahedra can be connected to.
    static bool is_attached(const CutPart& sliver) {
        for (const CutPart::Point& point : sliver.points)
            if (point.corner >= 0) return true;
        for (int side = 0; side < 4; ++side)
            if (side_area(sliver, side) > kSmallestShare) return true;
        return false;
    }

    void replace(std::size_t cell, std::vector<CutPart> parts) {
        std::vector<double> shares;
        double kept = 0;
        std::size_t largest = 0;
        for (const CutPart& part : parts) {
            shares.push_back(share_of(part));
            if (shares.back() > shares[largest]) largest = shares.size() - 1;
        }
        bool is_needed = false;
        std::vector<std::size_t> kept_parts;
        for (std::size_t n = 0; n < parts.size(); ++n)
            if (shares[n] > kSmallestShare || n == largest) {
                kept_parts.push_back(n);
                kept += shares[n];
            } else {
                is_needed |= is_attached(parts[n]);
            }
        // A blade along an old cut splits off slivers of no volume: they are left in place.
        if (kept_parts.empty() || (kept_parts.size() == 1 && !is_needed)) return;
        const double share = m_cut.shares[cell];
        m_is_changed[std::size_t(m_cut.cell_of[cell])] = 1;
        for (std::size_t k = 0; k < kept_parts.size(); ++k) {
            const std::size_t n = kept_parts[k];
            const std::size_t copy = k == 0 ? cell : add_copy(cell);
            m_cut.shares[copy] = share * (shares[n] / kept);
            keep(copy, std::move(parts[n]));
        }
    }

    std::size_t add_copy(std::size_t cell) {
        const std::size_t copy = m_cut.mesh.cells.size();
        m_cut.mesh.cells.push_back(m_cut.mesh.cells[cell]);
        m_cut.cell_of.push_back(m_cut.cell_of[cell]);
        m_cut.uncut_cell_of.push_back(m_cut.uncut_cell_of[cell]);
        m_cut.next_copy.push_back(m_cut.next_copy[cell]);
        m_cut.next_copy[cell] = std::int32_t(copy);
        m_cut.shares.push_back(0);
        m_cut.part_of.push_back(-1);
        return copy;
    }

    CutMesh& m_cut;
    std::span<const Vec3d> m_positions;
    double m_units;
    std::vector<std::uint8_t> m_is_changed;
    std::array<std::size_t, 4> m_order{};
    const CutPart m_whole = whole_part();
    // Scratch of cut_cell.
    std::vector<Position> m_points;
    std::vector<int> m_sides;
    std::vector<CutPart::Crossing> m_crossings;
    std::vector<std::int32_t> m_component_of;
};

/// Copies the nodes of tetrahedra that were split: one for each connected component of the
/// material around a node.
class NodeCopies {
  public:
    NodeCopies(CutMesh& cut, const std::vector<std::uint8_t>& is_changed)
        : m_cut(cut), m_is_near(cut.uncut_node_of.size(), 0), m_parent(4 * cut.mesh.cells.size()) {
        std::iota(m_parent.begin(), m_parent.end(), 0);
        for (std::size_t c = 0; c < cut.mesh.cells.size(); ++c)
            if (is_changed[std::size_t(cut.cell_of[c])])
                for (int k = 0; k < 4; ++k) m_is_near[uncut_node(c, k)] = 1;
        for (std::size_t c = 0; c < cut.mesh.cells.size(); ++c)
            for (int k = 0; k < 4; ++k)
                if (m_is_near[uncut_node(c, k)]) {
                    m_near.push_back(std::int32_t(c));
                    break;
                }
    }

    void make() {
        find_faces();
        for (std::size_t n = 0; n < m_faces.size();) {
            std::size_t end = n + 1;
            while (end < m_faces.size() && m_faces[end].nodes == m_faces[n].nodes) ++end;
            for (std::size_t i = n; i < end; ++i)
                for (std::size_t j = i + 1; j < end; ++j) join(m_faces[i], m_faces[j]);
            n = end;
        }
        join_at_nodes();
        number();
    }

  private:
    struct Face {
        std::array<std::int32_t, 3> nodes;  ///< uncut, ascending
        std::int32_t cell;
        std::array<std::int8_t, 3> corners;  ///< of the cell, in the order of the nodes
        std::int8_t side;

        friend bool operator<(const Face& a, const Face& b) {
            return std::tie(a.nodes, a.cell) < std::tie(b.nodes, b.cell);
        }
    };

    std::size_t uncut_node(std::size_t cell, int corner) const {
        return std::size_t(
            m_cut.uncut_node_of[std::size_t(m_cut.mesh.cells[cell][std::size_t(corner)])]);
    }

    void find_faces() {
        for (const std::int32_t c : m_near)
            for (int side = 0; side < 4; ++side) {
                Face face{{}, c, {}, std::int8_t(side)};
                std::array<std::pair<std::int32_t, int>, 3> corners;
                bool is_near = false;
                for (int k = 0; k < 3; ++k) {
                    const int corner = (side + 1 + k) % 4;
                    const std::size_t node = uncut_node(std::size_t(c), corner);
                    corners[std::size_t(k)] = {std::int32_t(node), corner};
                    is_near |= m_is_near[node] != 0;
                }
                if (!is_near) continue;
                std::sort(corners.begin(), corners.end());
                for (std::size_t k = 0; k < 3; ++k) {
                    face.nodes[k] = corners[k].first;
                    face.corners[k] = std::int8_t(corners[k].second);
                }
                m_faces.push_back(face);
            }
        std::sort(m_faces.begin(), m_faces.end());
    }

    bool are_connected(const Face& a, const Face& b) const {
        const std::int32_t p = m_cut.part_of[std::size_t(a.cell)];
        const std::int32_t q = m_cut.part_of[std::size_t(b.cell)];
        if (p < 0 && q < 0) return true;
        if (p < 0 || q < 0) {
            const Face& divided = p < 0 ? b : a;
            return side_area(m_cut.parts[std::size_t(std::max(p, q))], divided.side) >
                   kSmallestShare;
        }
        const auto corners = [](const Face& f) {
            return std::array<int, 3>{f.corners[0], f.corners[1], f.corners[2]};
        };
        return have_common_area(m_cut.parts[std::size_t(p)], a.side, corners(a),
                                m_cut.parts[std::size_t(q)], b.side, corners(b));
    }

    void join(const Face& a, const Face& b) {
        if (m_cut.uncut_cell_of[std::size_t(a.cell)] == m_cut.uncut_cell_of[std::size_t(b.cell)] ||
            !are_connected(a, b))
            return;
        for (std::size_t k = 0; k < 3; ++k)
            if (m_is_near[std::size_t(a.nodes[k])])
                unite(slot(a.cell, a.corners[k]), slot(b.cell, b.corners[k]));
    }

    bool has_corner(std::int32_t cell, int corner) const {
        const std::int32_t part = m_cut.part_of[std::size_t(cell)];
        if (part < 0) return true;
        for (const CutPart::Point& point : m_cut.parts[std::size_t(part)].points)
            if (point.corner == corner) return true;
        return false;
    }

    /// Material at a node itself is connected.
    void join_at_nodes() {
        m_keeper.assign(m_cut.mesh.nodes_mm.size(), -1);
        for (const std::int32_t c : m_near)
            for (int k = 0; k < 4; ++k) {
                if (!m_is_near[uncut_node(std::size_t(c), k)] || !has_corner(c, k)) continue;
                std::int32_t& keeper = m_keeper[std::size_t(node(c, k))];
                if (keeper < 0)
                    keeper = slot(c, k);
                else
                    unite(keeper, slot(c, k));
            }
    }

    /// The component with the node's material keeps its number, or else the first one.
    void number() {
        for (const std::int32_t c : m_near)
            for (int k = 0; k < 4; ++k)
                if (std::int32_t& keeper = m_keeper[std::size_t(node(c, k))]; keeper < 0)
                    keeper = slot(c, k);
        std::vector<std::int32_t> number_of(m_parent.size(), -1);
        for (const std::int32_t c : m_near)
            for (int k = 0; k < 4; ++k) {
                if (!m_is_near[uncut_node(std::size_t(c), k)]) continue;
                const auto old = std::size_t(node(c, k));
                const std::int32_t root = root_of(slot(c, k));
                std::int32_t& number = number_of[std::size_t(root)];
                if (number < 0) {
                    const bool keeps = root == root_of(m_keeper[old]);
                    number = keeps ? std::int32_t(old) : add_copy(old);
                }
            }
        for (const std::int32_t c : m_near)
            for (int k = 0; k < 4; ++k)
                if (const std::int32_t n = number_of[std::size_t(root_of(slot(c, k)))]; n >= 0)
                    m_cut.mesh.cells[std::size_t(c)][std::size_t(k)] = n;
    }

    std::int32_t add_copy(std::size_t node) {
        const auto number = std::int32_t(m_cut.mesh.nodes_mm.size());
        m_cut.mesh.nodes_mm.push_back(m_cut.mesh.nodes_mm[node]);
        m_cut.node_of.push_back(std::int32_t(node));
        m_cut.uncut_node_of.push_back(m_cut.uncut_node_of[node]);
        return number;
    }

    /// A corner of a tetrahedron's copy, which has a node of its own until it is united.
    static std::int32_t slot(std::int32_t cell, int corner) { return 4 * cell + corner; }
    std::int32_t node(std::int32_t cell, int corner) const {
        return m_cut.mesh.cells[std::size_t(cell)][std::size_t(corner)];
    }
    std::int32_t root_of(std::int32_t slot) {
        while (m_parent[std::size_t(slot)] != slot) {
            std::int32_t& parent = m_parent[std::size_t(slot)];
            parent = m_parent[std::size_t(parent)];
            slot = parent;
        }
        return slot;
    }
    /// Copies that earlier cuts have separated stay separate.
    void unite(std::int32_t a, std::int32_t b) {
        if (node(a / 4, a % 4) != node(b / 4, b % 4)) return;
        const std::int32_t p = root_of(a), q = root_of(b);
        m_parent[std::size_t(std::max(p, q))] = std::min(p, q);
    }

    CutMesh& m_cut;
    std::vector<std::uint8_t> m_is_near;  ///< [uncut node] of a tetrahedron that was split
    std::vector<std::int32_t> m_near;     ///< tetrahedra at these nodes
    std::vector<Face> m_faces;
    std::vector<std::int32_t> m_parent;  ///< [slot]
    std::vector<std::int32_t> m_keeper;  ///< [node] a slot, or −1
};

Result<std::vector<Strip>> strips_of(const CutSurface& surface, double units_per_mm) {
    const auto position_of = [&](Vec3d mm) {
        return Position{std::llround(units_per_mm * mm.x), std::llround(units_per_mm * mm.y),
                        std::llround(units_per_mm * mm.z)};
    };
    const double rounding_mm = 2 / units_per_mm;
    std::vector<Strip> strips;
    for (std::size_t n = 0; n + 1 < surface.line_mm.size(); ++n) {
        const Vec3d a = surface.line_mm[n], b = surface.line_mm[n + 1];
        const auto triangles = swept(position_of(a), position_of(b), position_of(surface.depth_mm));
        Strip strip{triangles, BladePlane(triangles[0]), {}};
        if (strip.plane.is_flat()) continue;
        for (const Vec3d& x : {a, b, a + surface.depth_mm, b + surface.depth_mm}) strip.box.add(x);
        strip.box.low = strip.box.low - rounding_mm * Vec3d{1, 1, 1};
        strip.box.high = strip.box.high + rounding_mm * Vec3d{1, 1, 1};
        strips.push_back(strip);
    }
    if (strips.empty())
        return about("cut", ErrorCode::InvalidArgument,
                     "expected a depth that leads away from the line, found a surface of no area");
    return strips;
}

Status check_cut(const CutMesh& before, std::span<const Vec3d> positions,
                 const CutSurface& surface) {
    if (surface.line_mm.size() < 2)
        return expected_error("cut", "a line of two or more points",
                              std::to_string(surface.line_mm.size()));
    if (positions.size() != before.mesh.nodes_mm.size())
        return expected_error("positions_now", std::to_string(before.mesh.nodes_mm.size()),
                              std::to_string(positions.size()));
    const auto is_near = [](Vec3d x) { return norm(x) <= kFarthestCutMm; };  // false for NaN
    if (!std::all_of(positions.begin(), positions.end(), is_near))
        return expected_error("positions_now", "positions within 100000 mm", "others");
    if (!std::all_of(surface.line_mm.begin(), surface.line_mm.end(), is_near) ||
        !is_near(surface.depth_mm))
        return expected_error("cut", "points and a depth within 100000 mm", "others");
    return Ok{};
}

/// The largest power of two with which all positions are small enough for exact signs.
double units_for(std::span<const Vec3d> positions, const CutSurface& surface) {
    double reach = 0;
    const auto look = [&](Vec3d x) {
        for (int a = 0; a < 3; ++a) reach = std::max(reach, std::abs(x[a]));
    };
    for (const Vec3d& x : positions) look(x);
    for (const Vec3d& x : surface.line_mm) look(x);
    look(surface.depth_mm);
    int exponent = 0;
    (void)std::frexp(reach, &exponent);  // reach < 2^exponent
    return std::ldexp(1.0, std::ilogb(double(kWidestPosition)) - 2 - exponent);
}

CutMesh uncut(const TetMesh& rest) {
    CutMesh cut;
    cut.mesh = rest;
    cut.uncut_node_of.resize(rest.nodes_mm.size());
    std::iota(cut.uncut_node_of.begin(), cut.uncut_node_of.end(), 0);
    cut.uncut_cell_of.resize(rest.cells.size());
    std::iota(cut.uncut_cell_of.begin(), cut.uncut_cell_of.end(), 0);
    cut.shares.assign(rest.cells.size(), 1);
    cut.next_copy.assign(rest.cells.size(), -1);
    cut.part_of.assign(rest.cells.size(), -1);
    return cut;
}

Result<CutMesh> cut_further(CutMesh cut, std::span<const Vec3d> positions,
                            const CutSurface& surface) {
    if (const Status status = check_cut(cut, positions, surface); !status.ok())
        return status.error();
    const double units = units_for(positions, surface);
    const auto strips = strips_of(surface, units);
    if (!strips.ok()) return strips.error();
    cut.node_of.resize(cut.mesh.nodes_mm.size());
    std::iota(cut.node_of.begin(), cut.node_of.end(), 0);
    cut.cell_of.resize(cut.mesh.cells.size());
    std::iota(cut.cell_of.begin(), cut.cell_of.end(), 0);
    const std::size_t cells_before = cut.mesh.cells.size();
    Cutter cutter(cut, positions, units);
    cutter.cut(*strips);
    NodeCopies(cut, cutter.is_changed()).make();
    std::vector<std::uint8_t> is_split(cells_before, 0);
    for (std::size_t c = cells_before; c < cut.cell_of.size(); ++c)
        is_split[std::size_t(cut.cell_of[c])] = 1;
    cut.split_cells = std::count(is_split.begin(), is_split.end(), 1);
    const auto piece = pieces(cut.mesh);
    cut.pieces = piece.empty() ? 0 : *std::max_element(piece.begin(), piece.end()) + 1;
    return cut;
}

}  // namespace

std::int32_t CutMesh::copy_of(std::int32_t uncut_cell, Vec3d rest_mm) const {
    const auto first = std::size_t(uncut_cell);
    if (next_copy[first] < 0) return uncut_cell;
    const auto corner = [&](std::size_t k) {
        return mesh.nodes_mm[std::size_t(mesh.cells[first][k])];
    };
    const Vec3d a = corner(0);
    const Vec3d r = inverse(Mat3d{{corner(1) - a, corner(2) - a, corner(3) - a}}) * (rest_mm - a);
    std::array<double, 4> weights{1 - r.x - r.y - r.z, r.x, r.y, r.z};
    constexpr double kInside = 1e-9;  // on a face, the numbers of all parts would be halved
    double sum = 0;
    for (double& w : weights) sum += w = std::max(w, kInside);
    for (double& w : weights) w /= sum;
    std::int32_t best = uncut_cell;
    double largest = -1;
    for (std::int32_t c = uncut_cell; c >= 0; c = next_copy[std::size_t(c)]) {
        const double winding = winding_number(parts[std::size_t(part_of[std::size_t(c)])], weights);
        if (winding > largest) {
            largest = winding;
            best = c;
        }
    }
    return best;
}

std::vector<double> CutMesh::node_volumes_mm3() const {
    std::vector<double> volumes(mesh.nodes_mm.size(), 0);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const auto corner = [&](std::size_t k) {
            return mesh.nodes_mm[std::size_t(mesh.cells[c][k])];
        };
        const Vec3d a = corner(0);
        const double volume = dot(cross(corner(1) - a, corner(2) - a), corner(3) - a) / 6;
        for (const std::int32_t n : mesh.cells[c])
            volumes[std::size_t(n)] += shares[c] * volume / 4;
    }
    return volumes;
}

Result<CutMesh> cut_tetrahedra(const TetMesh& rest, std::span<const Vec3d> positions_now,
                               const CutSurface& surface) noexcept {
    return attempt([&]() -> Result<CutMesh> {
        if (const Status status = check_cells(rest); !status.ok()) return status.error();
        return cut_further(uncut(rest), positions_now, surface);
    });
}

Result<CutMesh> cut_tetrahedra(const CutMesh& before, std::span<const Vec3d> positions_now,
                               const CutSurface& surface) noexcept {
    return attempt([&] { return cut_further(before, positions_now, surface); });
}

}  // namespace pliant
