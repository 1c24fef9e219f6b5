// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/spring_nodes.h"

#include <algorithm>
#include <utility>

#include "base/units.h"

namespace pliant {
namespace {

constexpr double kSettled_mm_s = 0.05;

}  // namespace

SpringNodes::SpringNodes(SpringTissue tissue, std::unique_ptr<MovingScan> carried,
                         std::vector<std::array<std::int32_t, 4>> cells)
    : MeshTissue(std::move(carried), std::size_t(tissue.network().node_count())),
      m_tissue(std::move(tissue)) {
    TetMesh mesh{{}, std::move(cells)};
    for (const SpringNode& node : m_tissue.network().nodes()) mesh.nodes_mm.push_back(node.rest);
    m_rest = rest_mesh(std::move(mesh));
    m_held.reserve(m_rest.nodes_mm.size());
    m_held_positions.reserve(m_rest.nodes_mm.size());
}

std::int32_t SpringNodes::fixed_nodes() const {
    const auto nodes = m_tissue.network().nodes();
    return std::int32_t(
        std::count_if(nodes.begin(), nodes.end(), [](const SpringNode& n) { return n.fixed; }));
}

void SpringNodes::put(std::span<const Vec3d> positions,
                      std::span<const Vec3d> velocities) noexcept {
    for (std::size_t n = 0; n < positions.size(); ++n)
        if (!is_fixed(std::int32_t(n)))
            (void)m_tissue.set_state(std::int32_t(n), positions[n], velocities[n]);
}

void SpringNodes::move_held(std::span<const std::int32_t> nodes, Vec3d shift) noexcept {
    m_held_positions.clear();
    for (const std::int32_t n : m_held) {
        const bool moves = std::binary_search(nodes.begin(), nodes.end(), n);
        m_held_positions.push_back(moves ? m_tissue.position(n) + shift : m_tissue.position(n));
    }
    (void)m_tissue.move_held(m_held_positions);
}

Status SpringNodes::stride(std::span<const std::int32_t> nodes, Vec3d shift) {
    move_held(nodes, shift);
    return step();
}

double SpringNodes::fastest_mm_s() const {
    double fastest = 0;
    for (std::int32_t n = 0; n < node_count(); ++n)
        fastest = std::max(fastest, norm(m_tissue.velocity(n)));
    return fastest;
}

bool SpringNodes::is_calm(double fastest_mm_s) {
    return fastest_mm_s < kSettled_mm_s;
}

std::optional<Vec3d> SpringNodes::force_n(std::uint32_t tool) noexcept {
    return force_on(held_by(tool));
}

std::optional<Vec3d> SpringNodes::force_on(std::span<const std::int32_t> nodes) noexcept {
    if (nodes.empty()) return Vec3d{0, 0, 0};
    const auto reaction = m_tissue.reaction(nodes, ReactionLaw::Held);
    if (!reaction.ok()) return {};
    return kNewtonsPerMicronewton * reaction->force;
}

}  // namespace pliant
