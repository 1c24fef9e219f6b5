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

#include <pliant/body_contact.h>
#include <pliant/mesh.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
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

class BodyTissue final : public MeshTissue {
  public:
    /// @pre the body has one sub-step
    static Result<std::unique_ptr<MeshTissue>> create(const Volume& scan, PbdBody body,
                                                      BodyPlan plan, const TaskArena& arena);

    TissueTraits traits() const noexcept override;
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override;
    void release(std::uint32_t tool) noexcept override;
    Result<SlideReport> slide(std::uint32_t tool, const Push& way,
                              const TissueValues& tissue_values) noexcept override;
    Result<CutReport> cut(const CutSurface& surface) noexcept override;
    Status place_eye(std::uint32_t tool, Vec3d position_mm, double radius_mm) noexcept override;
    bool has_eye(std::uint32_t tool) const noexcept override { return m_eyes.contains(tool); }
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_tools.contains(tool) || m_spheres.contains(tool);
    }
    bool is_touched() const noexcept override { return !m_tools.empty() || !m_spheres.empty(); }
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override;
    Result<Sweep> sweep() noexcept override;
    Status reset() noexcept override;
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
    std::int32_t node_count() const override { return body().particle_count(); }
    const CutMesh* cut_mesh() const override { return m_shape->mesh ? &*m_shape->mesh : nullptr; }

    const Volume& volume() const override { return m_carried->volume(); }
    const Deformation& deformation() const override;
    const TaskArena& arena() const override { return m_carried->arena(); }
    Status update_deformation() const override;

  private:
    using Tools = std::map<std::uint32_t, std::vector<std::int32_t>>;
    using Spheres = std::map<std::uint32_t, BodyTool>;

    using ShapePointer = std::shared_ptr<BodyShape>;

    BodyTissue(ShapePointer whole, BodyPlan plan, std::unique_ptr<EmbeddedScan> carried);
    PbdBody& body() { return m_shape->body; }
    const PbdBody& body() const { return m_shape->body; }
    TetMesh whole_mesh() const { return {m_whole->rest, m_whole->cells}; }
    Result<PushReport> push_nodes(std::uint32_t tool, const Push& push);
    Result<SlideReport> slide_sphere(std::uint32_t tool, const Push& way);
    Status step(std::int32_t count, std::uint32_t tool = 0, Vec3d way_mm = {0, 0, 0});
    void find_box(Vec3d& low, Vec3d& high) const;
    bool is_free(const BodyTool& sphere, Vec3d way_mm) const;
    bool contains(std::span<const Vec3d> positions_mm, Vec3d point_mm) const;
    std::vector<std::int32_t> nodes_at(const Push& push, Vec3d point_mm, bool or_around) const;
    void take(std::uint32_t tool, std::vector<std::int32_t> nodes);
    void set_masses() noexcept;
    Status stride(std::uint32_t tool, Vec3d shift);
    void keep_state();
    double folded_mm3(std::span<const Vec3d> positions_mm) const;
    bool is_weightless() const { return body().settings().gravity == Vec3d{0, 0, 0}; }
    void put(std::span<const Vec3d> positions, std::span<const Vec3d> velocities) noexcept;
    void wake() noexcept {
        m_settled = false;
        m_calm.clear();
        m_untold_sweeps = 0;
    }
    bool is_calm();
    void halt() noexcept;
    void come_to_rest() noexcept;
    Status show() const;
    Result<CutReport> cut_along(const CutSurface& surface);
    Result<CutMesh> cut_further(const BodyShape& shape, const BodyCut& cut) const;
    Result<ShapePointer> make_shape(CutMesh mesh, std::vector<double> cuts) const;
    Result<ShapePointer> shape_with(std::span<const double> cuts) const;
    Status take_shape(const ShapePointer& shape, std::span<const Vec3d> positions,
                      std::span<const Vec3d> velocities, Tools& tools, Spheres& spheres);
    bool carries(std::size_t cell, Vec3d point_mm) const;

    static constexpr std::size_t kKeptShapes = 6;  ///< for undo and redo

    BodyPlan m_plan;                          ///< its mesh is in the shape without cuts
    ShapePointer m_whole, m_shape;            ///< without cuts, and the present one
    std::vector<ShapePointer> m_shapes;       ///< with cuts, the last used one at the end
    std::unique_ptr<EmbeddedScan> m_carried;  ///< the scan
    double m_edge_mm = 0;                     ///< mean edge of the tetrahedra
    Tools m_tools;                            ///< nodes that each tool holds, sorted
    Spheres m_spheres, m_eyes;                ///< they keep the body's surface out
    std::vector<BodyTool> m_from, m_to;       ///< of a step: all spheres, then all eyes
    bool m_settled = true;
    std::vector<Vec3d> m_calm;  ///< positions near which all nodes have stayed; empty: unknown
    int m_calm_sweeps = 0;      ///< since then
    int m_untold_sweeps = 0;    ///< since the last command
    std::vector<Vec3d> m_positions, m_velocities;  ///< memory of noexcept functions
    std::vector<Vec3d> m_stepped;                  ///< [node], after a stride
    mutable std::vector<Vec3d> m_shown;            ///< [node], of the deformation
    mutable bool m_is_shown = true;
};

}  // namespace pliant
#pragma GCC visibility pop
