// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts of a body, the exchange of its shapes, and states with cuts.

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/errors.h"
#include "base/hash.h"
#include "base/stopwatch.h"
#include "pbd/rollback.h"
#include "tissue/body_tissue.h"

namespace pliant {
namespace {

constexpr double kFarthestNode_mm = 500;

/// Whether a cut has changed a mesh, if only by a crossing of an edge that later cuts complete.
bool has_changed(const CutMesh& now, const RestMesh& rest, const CutMesh* before) {
    const auto crossings = [](const CutMesh& mesh) {
        std::size_t sum = mesh.parts.size();
        for (const CutPart& part : mesh.parts) sum += part.begun.size();
        return sum;
    };
    return now.mesh.nodes_mm.size() != rest.nodes_mm.size() ||
           now.mesh.cells.size() != rest.cells.size() ||
           crossings(now) != (before ? crossings(*before) : 0);
}

}  // namespace

Result<CutMesh> BodyTissue::cut_further(const BodyShape& shape, const BodyCut& cut) const {
    return shape.mesh ? cut_tetrahedra(*shape.mesh, cut.positions_mm, cut.surface)
                      : cut_tetrahedra(whole_mesh(), cut.positions_mm, cut.surface);
}

/// Makes the body with the cuts of a mesh.
Result<BodyTissue::ShapePointer> BodyTissue::make_shape(CutMesh mesh,
                                                        std::vector<double> cuts) const {
    auto body =
        PbdBody::create(cut_parts(m_whole->body.parts(), m_whole->rest.cells, m_plan.pieces, mesh),
                        m_whole->body.settings());
    if (!body.ok()) return body.error();
    TouchedSolids touched = touched_solids(whole_mesh(), m_plan.pieces, mesh);
    auto contact = BodyContact::create(touched.mesh, touched.solids, {.friction = m_plan.friction});
    if (!contact.ok()) return contact.error();
    auto shape = std::make_shared<BodyShape>(BodyShape{
        .cuts = std::move(cuts), .body = std::move(*body), .contact = std::move(*contact)});
    PbdRollback::reserve(shape->body);
    shape->rest = rest_mesh(mesh.mesh);
    shape->rest.edge_mm = m_whole->rest.edge_mm;  // strides are those of the whole body
    shape->set_touched(std::move(touched.mesh.cells), touched.solids);
    shape->is_real = real_nodes(mesh);
    shape->carried = carried().find_cuts(mesh);
    shape->mesh = std::move(mesh);
    return shape;
}

/// The kept shape with these cuts, or a new one.
Result<BodyTissue::ShapePointer> BodyTissue::shape_with(std::span<const double> cuts) const {
    ShapePointer begun = m_whole;
    for (const ShapePointer& shape : m_shapes)
        if (shape->cuts.size() > begun->cuts.size() && shape->cuts.size() <= cuts.size() &&
            std::equal(shape->cuts.begin(), shape->cuts.end(), cuts.begin()))
            begun = shape;
    const auto more = cuts_of(cuts.subspan(begun->cuts.size()));
    if (!more.ok()) return more.error();
    if (more->empty()) return begun;
    std::optional<CutMesh> mesh;
    for (const BodyCut& cut : *more) {
        auto next =
            mesh ? cut_tetrahedra(*mesh, cut.positions_mm, cut.surface) : cut_further(*begun, cut);
        if (!next.ok()) return next.error();
        mesh = std::move(*next);
    }
    return make_shape(std::move(*mesh), {cuts.begin(), cuts.end()});
}

/// Replaces the body, with its state and tools. On an error nothing has changed.
Status BodyTissue::take_shape(const ShapePointer& shape, std::span<const Vec3d> positions,
                              std::span<const Vec3d> velocities, Tools& tools, Spheres& spheres) {
    if (shape != m_shape) {
        Memory memory(shape->rest.nodes_mm.size());
        std::vector<Vec3d> calm;
        calm.reserve(shape->rest.nodes_mm.size());
        if (const Status s = carried().place(shape->carried, positions); !s.ok()) return s;
        std::swap(m_memory, memory);
        m_calm.swap(calm);
        m_shape = shape;
        if (shape != m_whole) {
            std::erase(m_shapes, shape);
            m_shapes.push_back(shape);  // never more than the reserved ones
            if (m_shapes.size() > kKeptShapes) m_shapes.erase(m_shapes.begin());
        }
    }
    m_tools.swap(tools);
    m_spheres.swap(spheres);
    hold_nodes();
    put(positions, velocities);
    return Ok{};
}

Result<CutReport> BodyTissue::cut(const CutSurface& surface) noexcept {
    return attempt([&]() -> Result<CutReport> {
        if (!m_whole->body.parts().bends.empty())
            return expected_error("cut", "a body without bends", "one with some",
                                  ErrorCode::Unsupported);
        const Stopwatch watch;
        auto report = cut_along(surface);
        if (report.ok()) report->cut_ms = watch.ms();
        return report;
    });
}

Result<CutReport> BodyTissue::cut_along(const CutSurface& surface) {
    BodyCut cut{surface, std::vector<Vec3d>(std::size_t(node_count()))};
    body().get_positions(cut.positions_mm);
    auto mesh = cut_further(*m_shape, cut);
    if (!mesh.ok()) return mesh.error();
    if (!has_changed(*mesh, m_shape->rest, cut_mesh())) return CutReport{};
    std::vector<double> cuts = m_shape->cuts;
    add_numbers(cut, cuts);
    const std::vector<std::int32_t> node_of = mesh->node_of;
    const auto shape = make_shape(std::move(*mesh), std::move(cuts));
    if (!shape.ok()) return shape.error();
    std::vector<Vec3d> positions, velocities;
    for (const std::int32_t n : node_of) {
        positions.push_back(body().position(n));
        velocities.push_back(body().velocity(n));
    }
    // A tool goes on holding the copies of its nodes.
    Tools tools = m_tools;
    Spheres spheres = m_spheres;
    for (auto& [tool, nodes] : tools)
        for (std::size_t n = m_shape->rest.nodes_mm.size(); n < node_of.size(); ++n)
            if (std::binary_search(m_tools.at(tool).begin(), m_tools.at(tool).end(), node_of[n]))
                nodes.push_back(std::int32_t(n));
    const std::int64_t links = carried().cut_links();
    if (const Status s = take_shape(*shape, positions, velocities, tools, spheres); !s.ok())
        return s.error();
    wake();
    return CutReport{.cut_links = carried().cut_links() - links};
}

// States: those of the nodes, and the cuts that determine which these are.

/// The first six numbers are those of node 0.
void BodyTissue::state(std::vector<double>& numbers) const {
    const std::vector<double>& cuts = m_shape->cuts;
    const std::size_t whole = m_whole->rest.nodes_mm.size();
    const std::size_t beside = cuts.empty() ? 0 : 1 + cuts.size();
    const auto nodes = std::size_t(node_count());
    numbers.resize(6 * nodes + beside);
    for (std::size_t n = 0; n < nodes; ++n) {
        const Vec3d x = body().position(std::int32_t(n)), v = body().velocity(std::int32_t(n));
        const std::size_t at = 6 * n + (n < whole ? 0 : beside);
        for (int a = 0; a < 3; ++a) {
            numbers[at + std::size_t(a)] = x[a];
            numbers[at + 3 + std::size_t(a)] = v[a];
        }
    }
    if (cuts.empty()) return;
    numbers[6 * whole] = double(cuts.size());
    std::copy(cuts.begin(), cuts.end(), numbers.begin() + std::ptrdiff_t(6 * whole + 1));
}

Status BodyTissue::set_state(std::span<const double> numbers) noexcept {
    return attempt([&]() -> Status {
        const std::size_t whole = 6 * m_whole->rest.nodes_mm.size();
        std::span<const double> cuts;
        std::size_t beside = 0;
        if (numbers.size() > whole) {
            const double count = numbers[whole];
            if (!(count >= 1 && count <= double(numbers.size() - whole - 1)) ||
                count != std::floor(count))
                return invalid("expected position and velocity of as many particles");
            cuts = numbers.subspan(whole + 1, std::size_t(count));
            beside = 1 + cuts.size();
        }
        const auto shape = shape_with(cuts);
        if (!shape.ok()) return shape.error();
        const std::vector<Vec3d>& rest = (*shape)->rest.nodes_mm;
        if (numbers.size() != 6 * rest.size() + beside)
            return invalid("expected position and velocity of as many particles");
        std::vector<Vec3d> positions, velocities;
        bool is_home = true;
        for (std::size_t n = 0; n < rest.size(); ++n) {
            const double* at = numbers.data() + 6 * n + (6 * n < whole ? 0 : beside);
            positions.push_back({at[0], at[1], at[2]});
            velocities.push_back({at[3], at[4], at[5]});
            if (!(norm(positions.back() - rest[n]) <= kFarthestNode_mm) ||
                !(norm(velocities.back()) <= 1e9))
                return invalid("expected particles within 500 mm of their rest positions");
            is_home &= positions.back() == rest[n] && velocities.back() == Vec3d{0, 0, 0};
        }
        Tools tools;
        Spheres spheres;
        if (const Status s = take_shape(*shape, positions, velocities, tools, spheres); !s.ok())
            return s;
        wake();
        m_settled = is_home && is_weightless();
        return Ok{};
    });
}

std::uint64_t BodyTissue::hash() const {
    Hash64 hash;
    for (std::int32_t n = 0; n < body().particle_count(); ++n) {
        const Vec3d numbers[2] = {body().position(n), body().velocity(n)};
        hash.add(std::span<const Vec3d>(numbers));
    }
    if (!m_shape->cuts.empty()) hash.add(std::span<const double>(m_shape->cuts));
    return hash.value();
}

}  // namespace pliant
