// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A problem on an organ's mesh: its network, groups and references.

#include <pliant/models/fit_mesh.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/errors.h"
#include "base/text.h"
#include "base/units.h"
#include "fit/elastic_tetrahedra.h"
#include "mesh/mean_edge.h"

namespace pliant {
namespace {

constexpr double kModulusShare = 0.4;  ///< µ/E of links alone, whose Poisson's ratio is 1/4
constexpr double kMinVolumePoisson = 0.25;

Status check_regions(const FitMesh& f) {
    if (f.regions.empty()) return expected_error("regions", "one or more", "none");
    for (const FitRegion& r : f.regions) {
        const std::string here = "region" + (r.name.empty() ? "" : " " + r.name);
        if (!(std::isfinite(r.young_modulus_pa) && r.young_modulus_pa > 0))
            return expected_error(here, "a Young's modulus above 0", text_of(r.young_modulus_pa));
        if (!(r.poisson_ratio > -1 && r.poisson_ratio < 0.5))
            return expected_error(here, "a Poisson's ratio above -1 and below 0.5",
                                  text_of(r.poisson_ratio));
        if (f.volume_energy && !(r.poisson_ratio > kMinVolumePoisson))
            return expected_error(here, "a Poisson's ratio above 0.25 for a volume energy",
                                  text_of(r.poisson_ratio));
    }
    if (!f.region_of.empty() && f.region_of.size() != f.mesh.cells.size())
        return expected_error("region_of", std::to_string(f.mesh.cells.size()) + " numbers",
                              std::to_string(f.region_of.size()));
    for (const std::int32_t r : f.region_of)
        if (r < 0 || std::size_t(r) >= f.regions.size())
            return expected_error("region_of", "regions below " + std::to_string(f.regions.size()),
                                  std::to_string(r));
    return Ok{};
}

Status check_mesh_fit(const FitMesh& f) {
    if (const Status s = check_mesh(f.mesh); !s.ok()) return within("mesh", s.error());
    if (const Status s = check_regions(f); !s.ok()) return s;
    if (!(std::isfinite(f.range) && f.range > 1))
        return expected_error("range", "a factor above 1", text_of(f.range));
    if (!(std::isfinite(f.density_kg_per_m3) && f.density_kg_per_m3 > 0))
        return expected_error("density_kg_per_m3", "a number above 0",
                              text_of(f.density_kg_per_m3));
    if (f.held.empty()) return expected_error("held", "nodes that don't move", "none");
    const auto is_node = [&](std::int32_t n) {
        return n >= 0 && std::size_t(n) < f.mesh.nodes_mm.size();
    };
    for (const std::int32_t n : f.held)
        if (!is_node(n))
            return expected_error("held", "nodes below " + std::to_string(f.mesh.nodes_mm.size()),
                                  std::to_string(n));
    if (f.loads.empty()) return expected_error("loads", "one or more", "none");
    for (const FitMeshLoad& load : f.loads) {
        if (load.nodes.empty())
            return expected_error("load " + load.name, "nodes that it acts on", "none");
        for (const std::int32_t n : load.nodes)
            if (!is_node(n))
                return expected_error("load " + load.name,
                                      "nodes below " + std::to_string(f.mesh.nodes_mm.size()),
                                      std::to_string(n));
        if (!is_finite(load.force_n))
            return expected_error("load " + load.name, "a force of three numbers",
                                  text_of(load.force_n));
    }
    return Ok{};
}

/// Links, cells and groups, region by region.
Result<SpringParts> parts_of_mesh(const FitMesh& f, std::span<const std::int32_t> region_of,
                                  std::vector<FitGroup>& groups) {
    auto whole = springs_of_tetrahedra(f.mesh.nodes_mm, f.mesh.cells,
                                       {.density = kGramsPerMm3 * f.density_kg_per_m3, .bulk = 0});
    if (!whole.ok()) return whole.error();
    SpringParts parts{.nodes = std::move(whole->nodes), .links = {}, .cells = {}};
    for (const std::int32_t n : f.held) parts.nodes[std::size_t(n)].fixed = true;
    for (std::size_t r = 0; r < f.regions.size(); ++r) {
        const FitRegion& region = f.regions[r];
        std::vector<std::array<std::int32_t, 4>> cells;
        for (std::size_t t = 0; t < f.mesh.cells.size(); ++t)
            if (std::size_t(region_of[t]) == r) cells.push_back(f.mesh.cells[t]);
        if (cells.empty())
            return expected_error("region " + region.name, "one or more tetrahedra", "none");
        auto own = springs_of_elastic_tetrahedra(
            f.mesh.nodes_mm, cells, {.stiffness = 1, .bulk = f.volume_energy ? 1.0 : 0.0});
        if (!own.ok()) return own.error();
        const double e = region.young_modulus_pa, nu = region.poisson_ratio;
        const double mu = f.volume_energy ? e / (2 * (1 + nu)) : kModulusShare * e;
        const std::string name = region.name.empty() ? "" : " " + region.name;
        const auto add = [&](const std::string& kind, double start) -> FitGroup& {
            groups.push_back({.name = kind + name,
                              .start = start,
                              .low = start / f.range,
                              .high = start * f.range});
            return groups.back();
        };
        FitGroup& links = add("links", mu);
        for (const SpringLink& link : own->links) {
            links.links.push_back(std::int32_t(parts.links.size()));
            parts.links.push_back(link);
        }
        if (f.volume_energy) {
            FitGroup& volume = add("volume", e * nu / ((1 + nu) * (1 - 2 * nu)) - mu);
            for (std::size_t c = 0; c < own->cells.size(); ++c)
                volume.cells.push_back(std::int32_t(parts.cells.size() + c));
        }
        parts.cells.insert(parts.cells.end(), own->cells.begin(), own->cells.end());
    }
    return parts;
}

/// Measurements as weighted means of nodes.
Result<std::vector<FitPointTarget>> points_of(const FitMeshLoad& load, const TetMesh& mesh,
                                              double reach_mm, const TaskArena& arena) {
    std::vector<Vec3d> positions;
    for (const FitMeasurement& m : load.measured) {
        if (!is_finite(m.position_mm) || !is_finite(m.displacement_mm))
            return expected_error("load " + load.name, "measurements of finite numbers",
                                  text_of(m.position_mm));
        positions.push_back(m.position_mm);
    }
    const std::vector<Embedded> embedded = embed(positions, mesh, arena);
    std::vector<FitPointTarget> points;
    for (std::size_t p = 0; p < positions.size(); ++p) {
        Embedded at = embedded[p];
        double sum = 0;
        for (double& w : at.weights) sum += w = std::max(0.0, w);
        for (double& w : at.weights) w /= sum;
        const double away = norm(positions[p] - position_of(at, mesh));
        if (!(away <= reach_mm))
            return expected_error(
                "load " + load.name,
                "measurements within " + short_text(reach_mm) + " mm of the mesh, its mean edge",
                "one at " + text_of(positions[p]) + ", " + short_text(away) + " mm away");
        points.push_back({.nodes = mesh.cells[std::size_t(at.tetrahedron)],
                          .weights = at.weights,
                          .displacement = load.measured[p].displacement_mm});
    }
    return points;
}

Result<std::vector<FitCase>> cases_of(const FitMesh& f, std::span<const std::int32_t> region_of,
                                      const TaskArena& arena) {
    std::unique_ptr<ElasticTetrahedra> reference;
    const double reach_mm = mean_edge_mm(f.mesh);
    std::vector<FitCase> cases;
    for (const FitMeshLoad& load : f.loads) {
        FitCase c{.name = load.name,
                  .nodes = load.nodes,
                  .weight = load.weight,
                  .held_out = load.held_out};
        const Vec3d force = (kMicronewtonsPerNewton / double(load.nodes.size())) * load.force_n;
        c.forces.assign(load.nodes.size(), force);
        if (!load.measured.empty()) {
            auto points = points_of(load, f.mesh, reach_mm, arena);
            if (!points.ok()) return points.error();
            c.points = std::move(*points);
        } else {
            if (!reference) {
                std::vector<std::uint8_t> held(f.mesh.nodes_mm.size(), 0);
                for (const std::int32_t n : f.held) held[std::size_t(n)] = 1;
                reference = std::make_unique<ElasticTetrahedra>(f.mesh, f.regions, region_of, held);
                if (!reference->is_supported())
                    return expected_error("held", "nodes that leave no rigid motion free",
                                          std::to_string(f.held.size()) + " nodes");
            }
            std::vector<Vec3d> forces(f.mesh.nodes_mm.size(), Vec3d{0, 0, 0});
            for (const std::int32_t n : load.nodes) forces[std::size_t(n)] = force;
            c.target = reference->displacements_mm(forces);
        }
        cases.push_back(std::move(c));
    }
    return cases;
}

const char* note_of(FitBound bound) {
    return bound == FitBound::Low ? "at its lower bound" : "at its upper bound";
}

}  // namespace

Result<FitMeshProblem> fit_mesh(const FitMesh& f, const TaskArena& arena) {
    if (const Status s = check_mesh_fit(f); !s.ok()) return s.error();
    std::vector<std::int32_t> region_of = f.region_of;
    region_of.resize(f.mesh.cells.size(), 0);
    std::vector<FitGroup> groups;
    auto parts = parts_of_mesh(f, region_of, groups);
    if (!parts.ok()) return parts.error();
    auto cases = cases_of(f, region_of, arena);
    if (!cases.ok()) return cases.error();
    std::vector<double> start;
    for (const FitGroup& group : groups) start.push_back(group.start);
    FitSettings settings = f.settings;
    if (settings.spring_length == 0) settings.spring_length = mean_edge_mm(f.mesh);
    auto problem =
        FitProblem::create(std::move(*parts), std::move(groups), std::move(*cases), settings);
    if (!problem.ok()) return problem.error();
    return FitMeshProblem{std::move(*problem), f.mesh, std::move(region_of), std::move(start)};
}

NetworkFile network_of(const FitMeshProblem& fitted, const FitResult& found,
                       std::span<const FitInterval> intervals, const CreepResult* creep) {
    NetworkFile network{.parts = fitted.problem.parts_at(found.values)};
    SpringParts& parts = network.parts;
    network.link_groups.assign(parts.links.size(), -1);
    network.cell_groups.assign(parts.cells.size(), -1);
    network.node_groups.assign(parts.nodes.size(), -1);
    const auto groups = fitted.problem.groups();
    const auto with_interval = [](NetworkGroup group, const FitInterval& interval) {
        if (!interval.identifiable) {
            group.note = "not identifiable";
        } else {
            group.low = interval.low;
            group.high = interval.high;
        }
        return group;
    };
    for (std::size_t g = 0; g < groups.size(); ++g) {
        NetworkGroup group{.name = groups[g].name, .unit = "Pa", .value = found.values[g]};
        if (!intervals.empty()) group = with_interval(std::move(group), intervals[g]);
        if (found.at_bound[g] != FitBound::None) group.note = note_of(found.at_bound[g]);
        network.groups.push_back(std::move(group));
        for (const std::int32_t l : groups[g].links)
            network.link_groups[std::size_t(l)] = std::int32_t(g);
        for (const std::int32_t c : groups[g].cells)
            network.cell_groups[std::size_t(c)] = std::int32_t(g);
    }
    if (!creep) return network;
    NetworkGroup damping{.name = "damping", .unit = "1/s", .value = creep->damping_per_s};
    if (creep->interval.high > 0) damping = with_interval(std::move(damping), creep->interval);
    if (creep->at_bound != FitBound::None) damping.note = note_of(creep->at_bound);
    for (std::size_t n = 0; n < parts.nodes.size(); ++n) {
        parts.nodes[n].damping = creep->damping_per_s * parts.nodes[n].mass;
        network.node_groups[n] = std::int32_t(groups.size());
    }
    network.groups.push_back(std::move(damping));
    return network;
}

}  // namespace pliant
