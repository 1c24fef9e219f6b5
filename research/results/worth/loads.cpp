// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "loads.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "timing.h"
#include "value_of.h"

namespace pliant::results {
namespace {

constexpr int kBoneValue = 1000;  ///< above the bone threshold: never moves

Volume volume_of(const HexLattice& lattice, const std::function<int(std::size_t)>& value_of_node) {
    Volume volume{.grid = {.size = lattice.size, .spacing_mm = lattice.spacing_mm},
                  .voxels = VoxelArray<std::int16_t>(std::size_t(node_count(lattice))),
                  .key_values = {}};
    auto& voxels = *std::get_if<0>(&volume.voxels);
    for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = std::int16_t(value_of_node(n));
    return volume;
}

}  // namespace

std::uint64_t Dice::next() {
    std::uint64_t z = (m_state += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

double Dice::real(double low, double high) {
    return low + (high - low) * (double(next() >> 11) * 0x1p-53);
}

Body make_body(std::string name, const HexLattice& lattice, std::vector<ElasticPair> materials,
               const std::function<int(Vec3d voxel)>& material_at) {
    Body body{std::move(name), lattice, std::move(materials), {}, {}, {}};
    const Vec3i size = lattice.size;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) {
                const Vec3d at{double(i), double(j), double(k)};
                body.of_node.push_back(std::uint8_t(material_at(at)));
                if (i + 1 < size.x && j + 1 < size.y && k + 1 < size.z)
                    body.of_cell.push_back(std::uint8_t(material_at(at + Vec3d{0.5, 0.5, 0.5})));
            }
    body.held.resize(body.of_node.size(), false);
    return body;
}

std::vector<Vec3i> nodes_of(const Load& load, const HexLattice& lattice) {
    std::vector<Vec3i> nodes;
    for (int k = 0; k < lattice.size.z; ++k)
        for (int j = 0; j < lattice.size.y; ++j)
            for (int i = 0; i < lattice.size.x; ++i)
                if (norm(Vec3d{double(i), double(j), double(k)} - load.centre) <= load.radius)
                    nodes.push_back({i, j, k});
    return nodes;
}

Answer finite_elements(const Body& body, const Load& load, double tolerance,
                       const TaskArena& arena) {
    ElasticLattice solid{body.lattice, {}, {body.of_cell.begin(), body.of_cell.end()}};
    for (const ElasticPair& pair : body.materials)
        solid.materials.push_back({1000 * pair.young_modulus_kpa, pair.poisson_ratio});
    const Vec3d h = body.lattice.spacing_mm;
    const Vec3d push_mm{load.push.x * h.x, load.push.y * h.y, load.push.z * h.z};
    std::vector<Support> supports;
    for (std::size_t n = 0; n < body.held.size(); ++n)
        if (body.held[n]) supports.push_back({.node = std::int32_t(n)});
    for (const Vec3i& node : nodes_of(load, body.lattice))
        supports.push_back(
            {.node = std::int32_t(node_index(body.lattice, node)), .displacement_mm = push_mm});
    Answer answer;
    std::optional<ElasticSolver> solver;
    answer.prepare_ms = processor_ms_of([&] {
        solver = value_of(ElasticSolver::create(
            std::move(solid), std::move(supports),
            {.method = ElasticMethod::ConjugateGradients, .tolerance = tolerance}, arena));
    });
    ElasticSolution solution;
    answer.solve_ms = processor_ms_of([&] { solution = value_of(solver->solve({})); });
    answer.displacement_mm = std::move(solution.displacement_mm);
    answer.iterations = solution.iterations;
    return answer;
}

ChainBody::ChainBody(const Body& body, const TaskArena& arena)
    : m_body(body), m_arena(arena), m_volume(volume_of(body.lattice, [&](std::size_t n) {
          return body.held[n] ? kBoneValue : 0;
      })) {}

Answer ChainBody::push(const Load& load, const Chain& chain) const {
    ChainMailSettings settings;
    settings.bounded = true;
    settings.air_enabled = false;
    settings.max_movement_mm = 500;
    settings.history_max_steps = 0;
    // The same slack in all of the tissue.
    settings.offset = chain.offset;
    settings.range = {0, kBoneValue};
    Answer answer;
    std::optional<ChainMail> tissue;
    answer.prepare_ms =
        processor_ms_of([&] { tissue = value_of(ChainMail::create(m_volume, settings, m_arena)); });
    const std::vector<Vec3i> nodes = nodes_of(load, m_body.lattice);
    const Vec3d h = m_body.lattice.spacing_mm;
    answer.solve_ms = processor_ms_of([&] {
        answer.fraction =
            value_of(tissue->push_elements(
                         nodes, {load.push.x * h.x, load.push.y * h.y, load.push.z * h.z}))
                .step_fraction;
        if (chain.sweeps > 0)
            answer.iterations =
                value_of(tissue->relax({.max_sweeps = chain.sweeps, .held = nodes})).sweeps;
    });
    const Vec3i size = m_body.lattice.size;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i)
                answer.displacement_mm.push_back(tissue->displacement_mm({i, j, k}));
    return answer;
}

}  // namespace pliant::results
