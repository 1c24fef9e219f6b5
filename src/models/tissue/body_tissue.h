// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A position-based body as a tissue. A sweep is a time step of the body.
//
// A tool holds nodes, or is a sphere that keeps the body's surface out (pbd/body_contact.h). While
// there is a sphere, or a second piece, contact follows each sub-step.
//
// The tetrahedra carry the scan (resample/embedded_scan.h).
//
// A cut replaces the body, its contact and the carriers of the voxels (body_cut.h). The last shapes
// are kept, so that an undo is quick. A state is
//
//   6 numbers for each node of the whole body: position and velocity
//   with cuts: the count of their numbers, and these; 6 numbers for each further node

#pragma once

#include <pliant/mesh.h>
#include <pliant/models/body_contact.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tissue/body_cut.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Geometry and contact of a body, beside its constraints.
struct BodyPlan {
    TetMesh mesh{};                      ///< of the body's particles, at rest
    std::vector<std::int32_t> pieces{};  ///< [tetrahedron]: its solid; solids touch each other;
                                         ///< empty: one solid
    std::int32_t steps = 1;              ///< steps of the body in a time step
    double friction = 0;
    double reach_mm = 10;  ///< distance from the body at which the scan rests
    std::string bodies{};  ///< for display, a line each
    /// Piece that carries a voxel, as EmbeddedScanSettings::solid_at.
    std::function<std::int32_t(Vec3i ijk)> solid_at{};
};

/// Steps of a body of solids in a time step: as many as its forces need, and at least the given
/// number. @returns InvalidArgument for more than 1000
Result<std::int32_t> body_steps(const PbdParts& parts, double time_step_s, std::int32_t at_least);

class BodyTissue final : public MeshTissue {
  public:
    /// @pre the body has one sub-step
    static Result<std::unique_ptr<MeshTissue>> create(const Volume& scan, PbdBody body,
                                                      BodyPlan plan, const TaskArena& arena);

    TissueTraits traits() const noexcept override;
    Result<CutReport> cut(const CutSurface& surface) noexcept override;
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override;
    /// "particles", "tetrahedra", "fixed_particles", "edge_mm" (mean), "time_step_ms", and the
    /// plan's "bodies".
    Record figures() const override;
    Record report() const override;

    void state(std::vector<double>& numbers) const override;
    Status set_state(std::span<const double> numbers) noexcept override;
    std::uint64_t file_kind() const noexcept override { return 0x33'62'73'6c'70'00'00'0a; }
    std::uint64_t hash() const override;

    void positions_mm(std::span<Vec3d> positions_mm) const override {
        body().get_positions(positions_mm);
    }
    const CutMesh* cut_mesh() const override { return m_shape->mesh ? &*m_shape->mesh : nullptr; }

  private:
    using ShapePointer = std::shared_ptr<BodyShape>;

    BodyTissue(ShapePointer whole, BodyPlan plan, std::unique_ptr<MovingScan> carried);
    PbdBody& body() { return m_shape->body; }
    const PbdBody& body() const { return m_shape->body; }
    EmbeddedScan& carried() const { return static_cast<EmbeddedScan&>(*m_carried); }
    TetMesh whole_mesh() const { return {m_whole->rest.nodes_mm, m_whole->rest.cells}; }
    bool is_weightless() const { return body().settings().gravity == Vec3d{0, 0, 0}; }
    int fixed_particles() const;
    double step_s() const { return m_plan.steps * body().settings().time_step; }
    const RestMesh& at_rest() const override { return m_shape->rest; }
    bool is_fixed(std::int32_t n) const override {
        return !(body().parts().inverse_masses[std::size_t(n)] > 0);
    }
    void put(std::span<const Vec3d> positions, std::span<const Vec3d> velocities) noexcept override;
    void velocities_mm_s(std::span<Vec3d> velocities) const override;
    void keep() override;
    void take_back() noexcept override;
    void hold_nodes() noexcept override;
    Status stride(std::span<const std::int32_t> nodes, Vec3d shift) override;
    Status step() override { return stride({}, {0, 0, 0}); }
    bool is_calm() override;
    double home_mm() const override;
    Rules rules(const Push& push) const override;
    Status check_free_push(const Push& push) const override;
    bool has_material(std::int32_t n) const override {
        return !m_shape->mesh || m_shape->is_real[std::size_t(n)];
    }
    bool is_in_cell(std::size_t cell, Vec3d point_mm) const override;
    bool contains(std::span<const Vec3d> positions_mm, Vec3d point_mm) const override;
    Result<LimitedBy> slide_by(std::uint32_t tool, TouchTool& sphere, Vec3d shift) override;
    bool touches(const TouchTool& sphere) const override;
    Status step_contact(std::int32_t count, std::uint32_t tool = 0, Vec3d way_mm = {0, 0, 0});
    Result<CutReport> cut_along(const CutSurface& surface);
    Result<CutMesh> cut_further(const BodyShape& shape, const BodyCut& cut) const;
    Result<ShapePointer> make_shape(CutMesh mesh, std::vector<double> cuts) const;
    Result<ShapePointer> shape_with(std::span<const double> cuts) const;
    Status take_shape(const ShapePointer& shape, std::span<const Vec3d> positions,
                      std::span<const Vec3d> velocities, Tools& tools, Spheres& spheres);

    static constexpr std::size_t kKeptShapes = 6;  ///< for undo and redo

    BodyPlan m_plan;                     ///< its mesh is in the shape without cuts
    ShapePointer m_whole, m_shape;       ///< without cuts, and the present one
    std::vector<ShapePointer> m_shapes;  ///< with cuts, the last used one at the end
    std::vector<BodyTool> m_from, m_to;  ///< of a step: all spheres, then all eyes
    std::vector<Vec3d> m_calm;  ///< positions near which all nodes have stayed; empty: unknown
    int m_calm_sweeps = 0;      ///< since then
};

}  // namespace pliant
#pragma GCC visibility pop
