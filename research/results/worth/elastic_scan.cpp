// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/deformation.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <memory>

#include "loads.h"
#include "timing.h"
#include "value_of.h"

namespace pliant::results {
namespace {

// The elastic scan turns its cells, the reference doesn't. Pushes of a thousandth of the load are
// linear in both. The voxels are larger instead, so that the tissue's thresholds in mm stay small.
constexpr double kPart = 1e-3, kEdgeMm = 1e4;
constexpr int kBoneValue = 1000;

/// Voxels have the number of their material, and held ones 1000 more.
Volume scan_of(const Body& body, double scale) {
    Volume scan{.grid = {.size = body.lattice.size, .spacing_mm = scale * body.lattice.spacing_mm},
                .voxels = VoxelArray<std::int16_t>(body.held.size()),
                .key_values = {}};
    auto& voxels = *std::get_if<0>(&scan.voxels);
    for (std::size_t n = 0; n < voxels.size(); ++n)
        voxels[n] = std::int16_t(body.of_node[n] + (body.held[n] ? kBoneValue : 0));
    return scan;
}

ElasticScanSettings settings_of(const Body& body) {
    ElasticScanSettings settings;
    for (const int first : {0, kBoneValue})
        for (std::size_t m = 0; m < body.materials.size(); ++m)
            settings.moduli_kpa.push_back(
                {double(first) + double(m), body.materials[m].young_modulus_kpa});
    settings.poisson_ratio = 0;
    for (const ElasticPair& pair : body.materials)
        settings.poisson_ratio = std::max(settings.poisson_ratio, pair.poisson_ratio);
    settings.held_above_hu = kBoneValue - 0.5;
    settings.held_sides.emplace();
    return settings;
}

/// The load's sphere, of voxels: an ellipsoid where edges differ.
class VoxelSphere final : public ToolShape {
  public:
    VoxelSphere(double radius, Vec3d edge_mm) : m_radius(radius), m_edge_mm(edge_mm) {}
    bool contains(Vec3d offset_mm) const noexcept override {
        return norm({offset_mm.x / m_edge_mm.x, offset_mm.y / m_edge_mm.y,
                     offset_mm.z / m_edge_mm.z}) <= m_radius;
    }

  private:
    double m_radius;
    Vec3d m_edge_mm;
};

}  // namespace

Answer elastic_scan(const Body& body, const Load& load, ScanState state, const TaskArena& arena) {
    const Vec3d edge = body.lattice.spacing_mm;
    const double scale = kEdgeMm / std::max({edge.x, edge.y, edge.z});
    const Volume scan = scan_of(body, scale);
    const ElasticScanSettings settings = settings_of(body);
    Answer answer;
    std::unique_ptr<Tissue> tissue;
    answer.prepare_ms =
        processor_ms_of([&] { tissue = value_of(make_elastic(scan, settings, arena)); });
    const Vec3d h = scan.grid.spacing_mm;
    const VoxelSphere sphere(load.radius, h);
    const Push push{
        .point_mm = {load.centre.x * h.x, load.centre.y * h.y, load.centre.z * h.z},
        .push_mm = kPart * Vec3d{load.push.x * h.x, load.push.y * h.y, load.push.z * h.z},
        .sphere_radius_mm = load.radius * std::max({h.x, h.y, h.z}),
        .shape = &sphere};
    answer.solve_ms = processor_ms_of([&] {
        answer.fraction = value_of(tissue->push(1, push)).step_fraction;
        if (state == ScanState::Settled)
            answer.iterations = int(value_of(tissue->advance({})).steps);
    });
    must(tissue->update_deformation());
    const Vec3i size = scan.grid.size;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i)
                answer.displacement_mm.push_back((1 / (kPart * scale)) *
                                                 tissue->deformation().displacement_mm({i, j, k}));
    return answer;
}

}  // namespace pliant::results
