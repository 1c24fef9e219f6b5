// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/body_cut.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "base/errors.h"

namespace pliant {
namespace {

using Cell = std::array<std::int32_t, 4>;

/// Takes numbers from a list, one after the other.
class Taker {
  public:
    explicit Taker(std::span<const double> numbers) : m_left(numbers) {}
    bool is_empty() const { return m_left.empty(); }
    /// @returns nullopt if fewer than further_vectors remain
    std::optional<std::size_t> take_count(std::size_t further_vectors = 0) {
        if (m_left.empty()) return {};
        const double number = m_left.front();
        m_left = m_left.subspan(1);
        if (!(number >= 0 && number <= double(m_left.size() / 3)) || number != std::floor(number))
            return {};
        const auto count = std::size_t(number);
        if (count + further_vectors > m_left.size() / 3) return {};
        return count;
    }
    Vec3d take_vector() {
        const Vec3d v{m_left[0], m_left[1], m_left[2]};
        m_left = m_left.subspan(3);
        return v;
    }

  private:
    std::span<const double> m_left;
};

/// The tetrahedra by their corners.
class CellsByCorners {
  public:
    explicit CellsByCorners(std::span<const Cell> cells) {
        for (std::size_t c = 0; c < cells.size(); ++c)
            m_cells.emplace_back(cells[c], std::int32_t(c));
        std::sort(m_cells.begin(), m_cells.end());
    }
    /// @returns −1 if there is none
    std::int32_t find(const Cell& corners) const {
        const auto at =
            std::lower_bound(m_cells.begin(), m_cells.end(), std::pair(corners, std::int32_t(-1)));
        return at != m_cells.end() && at->first == corners ? at->second : -1;
    }

  private:
    std::vector<std::pair<Cell, std::int32_t>> m_cells;
};

/// Calls visit(corners, share) for each copy of the tetrahedron with these corners.
template <class Visit>
void for_copies(const CellsByCorners& cells, const Cell& corners, const CutMesh& mesh,
                const Visit& visit) {
    const std::int32_t first = cells.find(corners);
    if (first < 0) return visit(corners, 1.0);
    for (std::int32_t c = first; c >= 0; c = mesh.next_copy[std::size_t(c)])
        visit(mesh.mesh.cells[std::size_t(c)], mesh.shares[std::size_t(c)]);
}

double volume_of_cell(const Cell& cell, std::span<const Vec3d> x) {
    const auto at = [&](std::size_t n) { return x[std::size_t(cell[n])]; };
    return dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))) / 6;
}

/// Density of each solid, of its nodes that aren't held; 0 if all are.
std::map<std::int32_t, double> densities(const PbdParts& whole, std::span<const Cell> cells,
                                         std::span<const std::int32_t> solids) {
    std::vector<double> volumes(whole.positions.size(), 0);
    std::vector<std::int32_t> solid_of(whole.positions.size(), -1);
    for (std::size_t c = 0; c < cells.size(); ++c)
        for (const std::int32_t n : cells[c]) {
            volumes[std::size_t(n)] += volume_of_cell(cells[c], whole.positions) / 4;
            solid_of[std::size_t(n)] = solids[c];
        }
    std::map<std::int32_t, std::pair<double, double>> sums;  // mass and volume
    for (std::size_t n = 0; n < volumes.size(); ++n)
        if (whole.inverse_masses[n] > 0 && solid_of[n] >= 0) {
            sums[solid_of[n]].first += 1 / whole.inverse_masses[n];
            sums[solid_of[n]].second += volumes[n];
        }
    std::map<std::int32_t, double> found;
    for (const auto& [solid, sum] : sums) found[solid] = sum.first / sum.second;
    return found;
}

void add_particles(const PbdParts& whole, std::span<const Cell> cells,
                   std::span<const std::int32_t> solids, const CutMesh& mesh, PbdParts& parts) {
    const std::size_t count = mesh.mesh.nodes_mm.size();
    const std::vector<double> volumes = mesh.node_volumes_mm3();
    std::vector<double> sums(whole.positions.size(), 0);
    std::vector<std::int32_t> copies(whole.positions.size(), 0), solid_of(count, -1);
    for (std::size_t n = 0; n < count; ++n) {
        sums[std::size_t(mesh.uncut_node_of[n])] += volumes[n];
        ++copies[std::size_t(mesh.uncut_node_of[n])];
    }
    for (std::size_t c = 0; c < mesh.mesh.cells.size(); ++c)
        for (const std::int32_t n : mesh.mesh.cells[c])
            solid_of[std::size_t(n)] = solids[std::size_t(mesh.uncut_cell_of[c])];
    const std::vector<std::uint8_t> is_real = real_nodes(mesh);
    const auto density = densities(whole, cells, solids);
    for (std::size_t n = 0; n < count; ++n) {
        const auto uncut = std::size_t(mesh.uncut_node_of[n]);
        double w = whole.inverse_masses[uncut];
        if (copies[uncut] > 1) {
            const auto found = density.find(solid_of[n]);
            if (w > 0)
                w *= sums[uncut] / volumes[n];
            else if (!is_real[n] && found != density.end())
                w = 1 / (found->second * volumes[n]);
        }
        parts.positions.push_back(whole.positions[uncut]);
        parts.inverse_masses.push_back(w);
    }
}

/// An edge has the share of its stiffness that its tetrahedra have.
void add_distances(const PbdParts& whole, const CutMesh& mesh, PbdParts& parts) {
    struct Edge {
        std::int32_t uncut_a, uncut_b, a, b;
        double share;
    };
    std::vector<Edge> edges;
    for (std::size_t c = 0; c < mesh.mesh.cells.size() && !whole.distances.empty(); ++c)
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j) {
                const std::int32_t a = mesh.mesh.cells[c][i], b = mesh.mesh.cells[c][j];
                const std::int32_t p = mesh.uncut_node_of[std::size_t(a)],
                                   q = mesh.uncut_node_of[std::size_t(b)];
                if (p < q) edges.push_back({p, q, a, b, mesh.shares[c]});
            }
    const auto key = [](const Edge& e) { return std::tie(e.uncut_a, e.uncut_b, e.a, e.b); };
    const auto ends = [](const Edge& e) { return std::pair(e.uncut_a, e.uncut_b); };
    std::stable_sort(edges.begin(), edges.end(),
                     [&](const Edge& x, const Edge& y) { return key(x) < key(y); });
    for (const PbdDistance& whole_one : whole.distances) {
        const bool swapped = whole_one.nodes[0] > whole_one.nodes[1];
        const std::pair<std::int32_t, std::int32_t> wanted =
            std::minmax(whole_one.nodes[0], whole_one.nodes[1]);
        auto at = std::lower_bound(edges.begin(), edges.end(), wanted,
                                   [&](const Edge& e, const auto& w) { return ends(e) < w; });
        std::vector<Edge> found;
        double sum = 0;
        for (; at != edges.end() && ends(*at) == wanted; ++at) {
            sum += at->share;
            if (found.empty() || key(found.back()) != key(*at))
                found.push_back(*at);
            else
                found.back().share += at->share;
        }
        if (found.empty()) parts.distances.push_back(whole_one);
        for (const Edge& edge : found) {
            PbdDistance distance = whole_one;
            distance.nodes = {swapped ? edge.b : edge.a, swapped ? edge.a : edge.b};
            if (found.size() > 1) distance.compliance *= sum / edge.share;
            parts.distances.push_back(distance);
        }
    }
}

void add_attachments(const PbdParts& whole, std::span<const Cell> cells, const CutMesh& mesh,
                     PbdParts& parts) {
    for (PbdAttachment attachment : whole.attachments) {
        const auto corner_of = [&](std::size_t n, const Cell& cell) {
            return std::size_t(std::find(cell.begin(), cell.end(), attachment.nodes[n]) -
                               cell.begin());
        };
        Vec3d point{0, 0, 0};
        double sum = 0;
        for (std::size_t n = 0; n < 4; ++n) {
            if (attachment.weights[n] == 0) continue;
            point =
                point + attachment.weights[n] * whole.positions[std::size_t(attachment.nodes[n])];
            sum += attachment.weights[n];
        }
        const auto holder = std::find_if(cells.begin(), cells.end(), [&](const Cell& cell) {
            for (std::size_t n = 0; n < 4; ++n)
                if (attachment.weights[n] != 0 && corner_of(n, cell) == 4) return false;
            return true;
        });
        if (holder != cells.end() && sum != 0) {
            const std::int32_t copy =
                mesh.copy_of(std::int32_t(holder - cells.begin()), (1 / sum) * point);
            for (std::size_t n = 0; n < 4; ++n)
                if (attachment.weights[n] != 0)
                    attachment.nodes[n] = mesh.mesh.cells[std::size_t(copy)][corner_of(n, *holder)];
        }
        parts.attachments.push_back(attachment);
    }
}

}  // namespace

void add_numbers(const BodyCut& cut, std::vector<double>& numbers) {
    const auto add = [&](Vec3d v) {
        for (int a = 0; a < 3; ++a) numbers.push_back(v[a]);
    };
    numbers.push_back(double(cut.surface.line_mm.size()));
    for (const Vec3d& p : cut.surface.line_mm) add(p);
    add(cut.surface.depth_mm);
    numbers.push_back(double(cut.positions_mm.size()));
    for (const Vec3d& p : cut.positions_mm) add(p);
}

Result<std::vector<BodyCut>> cuts_of(std::span<const double> numbers) {
    std::vector<BodyCut> cuts;
    for (Taker taker(numbers); !taker.is_empty();) {
        BodyCut cut;
        const auto points = taker.take_count(1);
        if (!points) return invalid("expected the points of a cut's line");
        for (std::size_t n = 0; n < *points; ++n)
            cut.surface.line_mm.push_back(taker.take_vector());
        cut.surface.depth_mm = taker.take_vector();
        const auto nodes = taker.take_count();
        if (!nodes) return invalid("expected the positions of a cut's nodes");
        for (std::size_t n = 0; n < *nodes; ++n) cut.positions_mm.push_back(taker.take_vector());
        cuts.push_back(std::move(cut));
    }
    return cuts;
}

std::vector<std::uint8_t> real_nodes(const CutMesh& mesh) {
    std::vector<std::uint8_t> is_real(mesh.mesh.nodes_mm.size(), 0);
    for (std::size_t c = 0; c < mesh.mesh.cells.size(); ++c) {
        const Cell& cell = mesh.mesh.cells[c];
        const std::int32_t part = mesh.part_of[c];
        if (part < 0)
            for (const std::int32_t n : cell) is_real[std::size_t(n)] = 1;
        else
            for (const CutPart::Point& point : mesh.parts[std::size_t(part)].points)
                if (point.corner >= 0) is_real[std::size_t(cell[std::size_t(point.corner)])] = 1;
    }
    return is_real;
}

PbdParts cut_parts(const PbdParts& whole, std::span<const Cell> cells,
                   std::span<const std::int32_t> solids, const CutMesh& mesh) {
    PbdParts parts;
    parts.planes = whole.planes;
    add_particles(whole, cells, solids, mesh, parts);
    const CellsByCorners by_corners(cells);
    for (const PbdSolid& solid : whole.solids)
        for_copies(by_corners, solid.nodes, mesh, [&](const Cell& nodes, double share) {
            parts.solids.push_back(solid);
            parts.solids.back().nodes = nodes;
            parts.solids.back().young_modulus *= share;
        });
    for (const PbdVolume& volume : whole.volumes)
        for_copies(by_corners, volume.nodes, mesh, [&](const Cell& nodes, double share) {
            parts.volumes.push_back(volume);
            parts.volumes.back().nodes = nodes;
            parts.volumes.back().compliance /= share;
        });
    add_distances(whole, mesh, parts);
    add_attachments(whole, cells, mesh, parts);
    return parts;
}

TouchedSolids touched_solids(const TetMesh& whole, std::span<const std::int32_t> solids,
                             const CutMesh& mesh) {
    TouchedSolids touched{{mesh.mesh.nodes_mm, {}}, {}};
    const std::vector<std::int32_t> before = pieces(whole), after = pieces(mesh.mesh);
    std::int32_t next = *std::max_element(solids.begin(), solids.end()) + 1;
    // Parts of a solid were connected without the cuts. The first one keeps its number.
    std::map<std::pair<std::int32_t, std::int32_t>, std::map<std::int32_t, std::int32_t>> numbers;
    for (std::size_t c = 0; c < whole.cells.size(); ++c) {
        auto best = std::int32_t(c);
        for (std::int32_t copy = best; copy >= 0; copy = mesh.next_copy[std::size_t(copy)])
            if (mesh.shares[std::size_t(copy)] > mesh.shares[std::size_t(best)]) best = copy;
        const Cell& cell = mesh.mesh.cells[std::size_t(best)];
        auto& of_part = numbers[{solids[c], before[std::size_t(whole.cells[c][0])]}];
        const auto [found, is_new] =
            of_part.try_emplace(after[std::size_t(cell[0])], of_part.empty() ? solids[c] : next);
        next += is_new && found->second == next;
        touched.mesh.cells.push_back(cell);
        touched.solids.push_back(found->second);
    }
    return touched;
}

void BodyShape::set_touched(std::vector<Cell> tetrahedra, std::span<const std::int32_t> solids) {
    touched = std::move(tetrahedra);
    has_pieces = std::any_of(solids.begin(), solids.end(),
                             [&](std::int32_t s) { return s != solids.front(); });
}

}  // namespace pliant
