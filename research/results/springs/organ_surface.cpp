// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "organ_surface.h"

#include <pliant/models/vessel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace pliant::results {
namespace {

using Triangle = std::array<std::int32_t, 3>;

/// A closed surface whose edges can be collapsed. Each collapse removes a node and two triangles.
class Collapse {
  public:
    explicit Collapse(TriangleMesh surface) : m_surface(std::move(surface)) {
        m_triangles_of.resize(m_surface.nodes_mm.size());
        for (std::size_t t = 0; t < m_surface.cells.size(); ++t)
            for (const std::int32_t n : m_surface.cells[t])
                m_triangles_of[std::size_t(n)].insert(std::int32_t(t));
        for (std::size_t n = 0; n < m_triangles_of.size(); ++n) add_edges(std::int32_t(n));
    }
    std::size_t node_count() const { return m_triangles_of.size() - m_gone; }
    /// Collapses the shortest edge that can be. @returns false: there is none
    bool step() {
        for (auto at = m_edges.begin(); at != m_edges.end(); ++at) {
            const auto [a, b] = at->second;
            if (!can_be(a, b)) continue;
            merge(a, b);
            return true;
        }
        return false;
    }
    TriangleMesh surface() const {
        std::vector<Triangle> kept;
        for (std::size_t t = 0; t < m_surface.cells.size(); ++t)
            if (m_triangles_of[std::size_t(m_surface.cells[t][0])].contains(std::int32_t(t)))
                kept.push_back(m_surface.cells[t]);
        return part_of(m_surface.nodes_mm, kept);
    }

  private:
    using Edge = std::pair<double, std::pair<std::int32_t, std::int32_t>>;

    Vec3d at(std::int32_t n) const { return m_surface.nodes_mm[std::size_t(n)]; }
    std::set<std::int32_t> ring(std::int32_t n) const {
        std::set<std::int32_t> nodes;
        for (const std::int32_t t : m_triangles_of[std::size_t(n)])
            nodes.insert(m_surface.cells[std::size_t(t)].begin(),
                         m_surface.cells[std::size_t(t)].end());
        nodes.erase(n);
        return nodes;
    }
    Edge edge(std::int32_t a, std::int32_t b) const {
        return {norm(at(a) - at(b)), {std::min(a, b), std::max(a, b)}};
    }
    void add_edges(std::int32_t n) {
        for (const std::int32_t other : ring(n)) m_edges.insert(edge(n, other));
    }
    void remove_edges(std::int32_t n) {
        for (const std::int32_t other : ring(n)) m_edges.erase(edge(n, other));
    }
    /// The link condition, and no triangle that turns over.
    bool can_be(std::int32_t a, std::int32_t b) const {
        const auto around_a = ring(a), around_b = ring(b);
        int common = 0;
        for (const std::int32_t n : around_a) common += int(around_b.count(n));
        if (common != 2 || around_a.size() + around_b.size() < 10) return false;
        const Vec3d middle = 0.5 * (at(a) + at(b));
        for (const std::int32_t n : {a, b})
            for (const std::int32_t t : m_triangles_of[std::size_t(n)]) {
                const Triangle& c = m_surface.cells[std::size_t(t)];
                const auto has = [&](std::int32_t k) { return std::count(c.begin(), c.end(), k); };
                if (has(a) && has(b)) continue;
                std::array<Vec3d, 3> before, after;
                for (std::size_t k = 0; k < 3; ++k) {
                    before[k] = at(c[k]);
                    after[k] = c[k] == n ? middle : before[k];
                }
                const Vec3d u = cross(before[1] - before[0], before[2] - before[0]),
                            v = cross(after[1] - after[0], after[2] - after[0]);
                if (!(dot(u, v) > 0.5 * norm(u) * norm(v))) return false;
            }
        return true;
    }
    void merge(std::int32_t a, std::int32_t b) {
        remove_edges(a);
        remove_edges(b);
        m_surface.nodes_mm[std::size_t(a)] = 0.5 * (at(a) + at(b));
        auto& of_a = m_triangles_of[std::size_t(a)];
        for (const std::int32_t t : m_triangles_of[std::size_t(b)]) {
            Triangle& c = m_surface.cells[std::size_t(t)];
            if (std::count(c.begin(), c.end(), a) > 0) {
                for (const std::int32_t n : c)
                    if (n != b) m_triangles_of[std::size_t(n)].erase(t);
                continue;
            }
            std::replace(c.begin(), c.end(), b, a);
            of_a.insert(t);
        }
        m_triangles_of[std::size_t(b)].clear();
        ++m_gone;
        add_edges(a);
    }

    TriangleMesh m_surface;
    std::vector<std::set<std::int32_t>> m_triangles_of;
    std::set<Edge> m_edges;
    std::size_t m_gone = 0;
};

bool is_sphere(const TriangleMesh& surface) {
    const SurfaceTopology topology = surface_topology(surface);
    return topology.closed_manifold() && topology.pieces == 1 && topology.euler == 2;
}

}  // namespace

Result<TriangleMesh> organ_surface(const Volume& labels, int label, double smoothing_voxels,
                                   std::size_t nodes, const TaskArena& arena) {
    constexpr int kTries = 12;
    for (int n = 0; n < kTries; ++n, smoothing_voxels *= 1.15) {
        auto lumen = lumen_of_labels(labels, std::array{label}, smoothing_voxels, arena);
        if (!lumen.ok()) return lumen.error();
        // Nodes grow with the square of the fineness; a few more than wanted are collapsed.
        double cell_mm = std::cbrt(lumen->region_mm3) / std::sqrt(double(nodes)) * 2;
        for (int k = 0; k < 3; ++k) {
            const auto filled = fill_surface(lumen->surface, {.cell_mm = cell_mm}, arena);
            if (!filled.ok()) return filled.error();
            TriangleMesh surface = boundary_triangles(filled->mesh);
            const double share = double(surface.nodes_mm.size()) / double(nodes);
            if (share < 1.1 || share > 1.6) {
                cell_mm *= std::sqrt(share / 1.3);
                continue;
            }
            if (!is_sphere(surface)) break;
            Collapse collapse(std::move(surface));
            while (collapse.node_count() > nodes && collapse.step()) continue;
            TriangleMesh made = collapse.surface();
            if (made.nodes_mm.size() == nodes && is_sphere(made)) return made;
            break;
        }
    }
    return Error{ErrorCode::Unsupported, "the organ's surface has holes or several parts"};
}

}  // namespace pliant::results
