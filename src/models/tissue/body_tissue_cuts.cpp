// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts of a body, and the exchange of its shapes.

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "base/errors.h"
#include "pbd/rollback.h"
#include "tissue/body_tissue.h"

namespace pliant {
namespace {

/// Whether a cut has changed a mesh, if only by a crossing of an edge that later cuts complete.
bool has_changed(const CutMesh& now, std::size_t nodes, std::size_t cells, const CutMesh* before) {
    const auto crossings = [](const CutMesh& mesh) {
        std::size_t sum = mesh.parts.size();
        for (const CutPart& part : mesh.parts) sum += part.begun.size();
        return sum;
    };
    return now.mesh.nodes_mm.size() != nodes || now.mesh.cells.size() != cells ||
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
        PbdBody::create(cut_parts(m_whole->body.parts(), m_whole->cells, m_plan.pieces, mesh),
                        m_whole->body.settings());
    if (!body.ok()) return body.error();
    TouchedSolids touched = touched_solids(whole_mesh(), m_plan.pieces, mesh);
    auto contact = BodyContact::create(touched.mesh, touched.solids, {.friction = m_plan.friction});
    if (!contact.ok()) return contact.error();
    auto shape = std::make_shared<BodyShape>(BodyShape{
        .cuts = std::move(cuts), .body = std::move(*body), .contact = std::move(*contact)});
    PbdRollback::reserve(shape->body);
    shape->set_mesh(mesh.mesh);
    shape->set_touched(std::move(touched.mesh.cells), touched.solids);
    shape->is_real = real_nodes(mesh);
    shape->carried = m_carried->find_cuts(mesh);
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
        std::vector<Vec3d> memory[4];
        for (auto& vectors : memory) vectors.resize(shape->rest.size());
        if (const Status s = m_carried->place(shape->carried, positions); !s.ok()) return s;
        m_positions.swap(memory[0]);
        m_velocities.swap(memory[1]);
        m_shown.swap(memory[2]);
        m_stepped.swap(memory[3]);
        m_shape = shape;
        if (shape != m_whole) {
            std::erase(m_shapes, shape);
            m_shapes.push_back(shape);  // never more than the reserved ones
            if (m_shapes.size() > kKeptShapes) m_shapes.erase(m_shapes.begin());
        }
    }
    m_tools.swap(tools);
    m_spheres.swap(spheres);
    set_masses();
    put(positions, velocities);
    return Ok{};
}

Result<CutReport> BodyTissue::cut(const CutSurface& surface) noexcept {
    return attempt([&]() -> Result<CutReport> {
        if (!m_whole->body.parts().bends.empty())
            return expected_error("cut", "a body without bends", "one with some",
                                  ErrorCode::Unsupported);
        const auto start = std::chrono::steady_clock::now();
        auto report = cut_along(surface);
        if (report.ok())
            report->cut_ms =
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                    .count();
        return report;
    });
}

Result<CutReport> BodyTissue::cut_along(const CutSurface& surface) {
    BodyCut cut{surface, std::vector<Vec3d>(m_positions.size())};
    body().get_positions(cut.positions_mm);
    auto mesh = cut_further(*m_shape, cut);
    if (!mesh.ok()) return mesh.error();
    if (!has_changed(*mesh, m_shape->rest.size(), m_shape->cells.size(), cut_mesh()))
        return CutReport{};
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
        for (std::size_t n = m_shape->rest.size(); n < node_of.size(); ++n)
            if (std::binary_search(m_tools.at(tool).begin(), m_tools.at(tool).end(), node_of[n]))
                nodes.push_back(std::int32_t(n));
    const std::int64_t links = m_carried->cut_links();
    if (const Status s = take_shape(*shape, positions, velocities, tools, spheres); !s.ok())
        return s.error();
    wake();
    return CutReport{.cut_links = m_carried->cut_links() - links};
}

}  // namespace pliant
