// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The organs of a scene as one position-based body, of which each organ is a piece, or a single
// organ as a mass-spring network.

#include <pliant/models/organs.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/text.h"
#include "base/units.h"
#include "mesh/box_tree.h"
#include "tissue/body_tissue.h"
#include "tissue/network_tissue.h"

namespace pliant {
namespace {

/// Without volume energy an edge network has Poisson's ratio ¼; a smaller one can't be had.
constexpr double kLeastBulkShare = 0.01;

/// Edges with a stiffness of (√2/5)·µ·length, summed over their tetrahedra [Lloyd2007], and volumes
/// with a bulk modulus of λ − µ.
void add_distances(const OrganSettings& settings, PbdParts& parts, std::size_t first_solid) {
    const double nu = settings.poisson_ratio;
    const double mu = settings.young_modulus_pa / (2 * (1 + nu));
    const double lambda = 2 * mu * nu / (1 - 2 * nu);
    const double bulk = std::max(lambda - mu, kLeastBulkShare * lambda);
    std::map<std::pair<std::int32_t, std::int32_t>, double> stiffness;
    for (std::size_t c = first_solid; c < parts.solids.size(); ++c) {
        const auto& nodes = parts.solids[c].nodes;
        Vec3d x[4];
        for (std::size_t n = 0; n < 4; ++n) x[n] = parts.positions[std::size_t(nodes[n])];
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b)
                stiffness[std::minmax(nodes[a], nodes[b])] +=
                    0.2 * std::sqrt(2.0) * mu * norm(x[a] - x[b]);
        const double volume = dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) / 6;
        parts.volumes.push_back({.nodes = nodes, .compliance = volume / bulk});
    }
    parts.solids.resize(first_solid);
    for (const auto& [nodes, k] : stiffness)
        parts.distances.push_back({.nodes = {nodes.first, nodes.second}, .compliance = 1 / k});
}

/// Position along y (LPS: to the back) from which on nodes are held [mm].
double held_from(std::span<const Vec3d> positions, double share) {
    if (!(share > 0) || positions.empty()) return std::numeric_limits<double>::infinity();
    double front = positions.front().y, back = front;
    for (const Vec3d& p : positions) {
        front = std::min(front, p.y);
        back = std::max(back, p.y);
    }
    return back - share * (back - front);
}

/// Whether a value above the bound lies within a distance of a position.
class FixedPositions {
  public:
    FixedPositions(const Volume& scan, double above_hu, double near_mm)
        : m_scan(scan), m_above(above_hu), m_near(near_mm) {}
    bool hold(Vec3d p) const {
        const Vec3d at = voxel_from_world(m_scan.grid, p);
        Box3i box;
        for (int a = 0; a < 3; ++a) {
            const double reach = std::max(0.5, m_near / m_scan.grid.spacing_mm[a]);
            box.begin[a] = std::max(0, int(std::ceil(at[a] - reach)));
            box.end[a] = std::min(m_scan.grid.size[a], int(std::floor(at[a] + reach)) + 1);
        }
        for (int k = box.begin.z; k < box.end.z; ++k)
            for (int j = box.begin.y; j < box.end.y; ++j)
                for (int i = box.begin.x; i < box.end.x; ++i) {
                    if (!(double(m_scan.at({i, j, k})) > m_above)) continue;
                    if (!(m_near > 0)) return true;
                    const Vec3d x =
                        world_from_voxel(m_scan.grid, {double(i), double(j), double(k)});
                    if (norm(x - p) <= m_near) return true;
                }
        return false;
    }

  private:
    const Volume& m_scan;
    double m_above, m_near;
};

bool lies_in_box(Vec3d p, std::span<const Vec3d> corners) {
    for (std::size_t n = 0; n + 1 < corners.size(); n += 2) {
        bool inside = true;
        for (int a = 0; a < 3; ++a)
            inside &= p[a] >= std::min(corners[n][a], corners[n + 1][a]) &&
                      p[a] <= std::max(corners[n][a], corners[n + 1][a]);
        if (inside) return true;
    }
    return false;
}

/// Whether each box holds a node. The six faces of surroundings may lie in air.
Status check_boxes(const OrganSettings& s, std::span<const Vec3d> positions) {
    if (s.mesh.empty() && s.labels.empty()) return Ok{};
    const std::span<const Vec3d> boxes(s.held_mm);
    for (std::size_t n = 0; n + 1 < boxes.size(); n += 2) {
        const auto box = boxes.subspan(n, 2);
        if (std::any_of(positions.begin(), positions.end(),
                        [&](Vec3d p) { return lies_in_box(p, box); }))
            continue;
        mesh::Bounds body;
        for (const Vec3d& p : positions) body.add(p);
        return expected_error(
            "held_mm",
            "boxes with a node of the body, which lies from " + short_text(body.low) + " to " +
                short_text(body.high) + " mm",
            "none in the box from " + short_text(box[0]) + " to " + short_text(box[1]));
    }
    return Ok{};
}

/// Whether nodes of an organ don't move.
class HeldNodes {
  public:
    HeldNodes(const OrganSettings& settings, const FixedPositions& fixed,
              std::span<const Vec3d> positions)
        : m_settings(settings),
          m_fixed(fixed),
          m_held_mm(held_from(positions, settings.held_back)) {}
    bool hold(Vec3d p) const {
        return p.y >= m_held_mm || m_fixed.hold(p) || lies_in_box(p, m_settings.held_mm);
    }

  private:
    const OrganSettings& m_settings;
    const FixedPositions& m_fixed;
    double m_held_mm;
};

Status check_organ(const Organ& organ) {
    Status status = check(organ.settings, organ_rows());
    if (status.ok()) status = check_boxes(organ.settings, organ.mesh.nodes_mm);
    return status.ok() ? status : within(organ.name, status.error());
}

/// Adds an organ's particles and constraints. @returns the number of held ones
Result<std::int64_t> add(const Organ& organ, const FixedPositions& fixed, PbdParts& parts,
                         TetMesh& mesh) {
    const OrganSettings& s = organ.settings;
    if (const Status checked = check_organ(organ); !checked.ok()) return checked.error();
    auto own =
        pbd_of_mesh(organ.mesh, {.density = kGramsPerMm3 * s.density_kg_m3,
                                 .edges = false,
                                 .volumes = false,
                                 .solids = true,
                                 .young_modulus = s.young_modulus_pa,
                                 .poisson_ratio = s.poisson_ratio,
                                 .ogden_alpha = s.law == BodyLaw::Ogden ? s.ogden_alpha : 2});
    if (!own) return within(organ.name, own.error());
    const HeldNodes held(s, fixed, own->positions);
    std::int64_t held_count = 0;
    for (std::size_t n = 0; n < own->positions.size(); ++n)
        if (held.hold(own->positions[n])) {
            own->inverse_masses[n] = 0;
            ++held_count;
        }
    const auto first = std::int32_t(parts.positions.size());
    const std::size_t first_solid = parts.solids.size();
    parts.positions.insert(parts.positions.end(), own->positions.begin(), own->positions.end());
    parts.inverse_masses.insert(parts.inverse_masses.end(), own->inverse_masses.begin(),
                                own->inverse_masses.end());
    for (PbdSolid solid : own->solids) {
        for (std::int32_t& n : solid.nodes) n += first;
        parts.solids.push_back(solid);
        mesh.cells.push_back(solid.nodes);
    }
    if (s.law == BodyLaw::Distances) add_distances(s, parts, first_solid);
    return held_count;
}

std::string name_of(const OrganSettings& s) {
    switch (s.law) {
        case BodyLaw::Solid:
            return "neo-Hookean";
        case BodyLaw::Ogden:
            return "Ogden's law with α " + short_text(s.ogden_alpha);
        default:
            return "edges and volumes";
    }
}
/// Line about an organ: "liver: 54789 tetrahedra, neo-Hookean, 5 kPa, ν 0.45".
std::string line_about(const Organ& organ, bool is_held) {
    const OrganSettings& s = organ.settings;
    return organ.name + ": " + std::to_string(organ.mesh.cells.size()) + " tetrahedra, " +
           name_of(s) + ", " + short_text(1e-3 * s.young_modulus_pa) + " kPa, ν " +
           short_text(s.poisson_ratio) + (is_held ? "" : ", no node held");
}

/// The organ that carries each voxel of the scan, by label.
Result<std::vector<std::int16_t>> organs_of_voxels(const MadeOrgans& made, const Volume& scan,
                                                   const TaskArena& arena) {
    constexpr std::int16_t kAny = -1;
    std::map<int, std::int16_t> organ_of;
    std::int16_t others = kAny;
    for (std::size_t n = 0; n < made.organs.size(); ++n) {
        for (const int label : made.organs[n].settings.labels) organ_of[label] = std::int16_t(n);
        if (made.organs[n].settings.labels.empty() && made.organs[n].settings.mesh.empty())
            others = std::int16_t(n);
    }
    std::vector<std::int16_t> organs(voxel_count(scan.grid), others);
    const auto labels = labels_on(*made.labels, scan.grid, arena);
    if (!labels) return labels.error();
    std::visit(
        [&](const auto& voxels) {
            for (std::size_t n = 0; n < organs.size(); ++n)
                if (const auto found = organ_of.find(int(voxels[n])); found != organ_of.end())
                    organs[n] = found->second;
        },
        labels->voxels);
    return organs;
}

/// A single organ as a network: edges with a stiffness of (√2/5)·µ·length [Lloyd2007], and volumes
/// with a bulk modulus of λ − µ, which is 0 at a Poisson's ratio of ¼.
Result<std::unique_ptr<MeshTissue>> network_of(const MadeOrgans& made, const Volume& scan,
                                               const TaskArena& arena) {
    const OrganFile& file = made.file;
    const Organ& organ = made.organs.front();
    const OrganSettings& s = organ.settings;
    if (made.organs.size() > 1)
        return expected_error("law", "a single body with springs",
                              std::to_string(made.organs.size()) + " bodies");
    if (const Status checked = check_organ(organ); !checked.ok()) return checked.error();
    if (!(s.poisson_ratio >= 0.25))
        return within(organ.name, expected_error("poisson_ratio", "0.25 or more with springs",
                                                 text_of(s.poisson_ratio)));
    // Stiffness of a cube with an edge of 1.
    const SpringMaterial material = closed_form(s.young_modulus_pa, s.poisson_ratio, 1);
    auto parts = springs_of_elastic_tetrahedra(organ.mesh.nodes_mm, organ.mesh.cells,
                                               {.stiffness = material.stiffness,
                                                .density = kGramsPerMm3 * s.density_kg_m3,
                                                .bulk = std::max(0.0, material.bulk)});
    if (!parts) return within(organ.name, parts.error());
    const FixedPositions fixed(scan, file.fixed_hu, file.fixed_near_mm);
    const HeldNodes held(s, fixed, organ.mesh.nodes_mm);
    for (SpringNode& node : parts->nodes) {
        node.fixed = held.hold(node.rest);
        node.damping = file.damping_per_s * node.mass;
    }
    return make_network_tissue(scan, std::move(*parts),
                               {.time_step_s = file.time_step_s, .reach_mm = file.reach_mm}, arena);
}

Result<std::unique_ptr<MeshTissue>> tissue_of(const MadeOrgans& made, const Volume& scan,
                                              const TaskArena& arena) {
    if (const Status s = check_volume(scan); !s.ok()) return s.error();
    if (const Status s = check(made.file, organ_file_rows()); !s.ok()) return s.error();
    const OrganFile& file = made.file;
    if (std::any_of(made.organs.begin(), made.organs.end(),
                    [](const Organ& organ) { return organ.settings.law == BodyLaw::Springs; }))
        return network_of(made, scan, arena);
    const FixedPositions fixed(scan, file.fixed_hu, file.fixed_near_mm);
    PbdParts parts;
    TetMesh mesh;
    BodyPlan plan;
    for (std::size_t n = 0; n < made.organs.size(); ++n) {
        const auto held = add(made.organs[n], fixed, parts, mesh);
        if (!held) return held.error();
        plan.pieces.resize(mesh.cells.size(), std::int32_t(n));
        plan.bodies += (n > 0 ? "\n" : "") + line_about(made.organs[n], *held > 0);
    }
    mesh.nodes_mm = parts.positions;
    const auto steps = body_steps(parts, file.time_step_s, file.sub_steps);
    if (!steps) return steps.error();
    plan.steps = *steps;
    auto body = PbdBody::create(std::move(parts), {.time_step = file.time_step_s / plan.steps,
                                                   .sub_steps = 1,
                                                   .damping = file.damping_per_s,
                                                   .warm_starts = true});
    if (!body) return body.error();
    plan.friction = file.friction;
    plan.reach_mm = file.reach_mm;
    plan.mesh = std::move(mesh);
    if (made.labels) {
        auto by_voxel = organs_of_voxels(made, scan, arena);
        if (!by_voxel) return by_voxel.error();
        plan.solid_at = [organs = std::move(*by_voxel), grid = scan.grid](Vec3i p) {
            return std::int32_t(organs[voxel_index(grid, p)]);
        };
    }
    return BodyTissue::create(scan, std::move(*body), std::move(plan), arena);
}

}  // namespace

Result<std::unique_ptr<MeshTissue>> make_tissue(const MadeOrgans& made, const Volume& scan,
                                                const TaskArena& arena) noexcept {
    return attempt([&] { return tissue_of(made, scan, arena); });
}

}  // namespace pliant
