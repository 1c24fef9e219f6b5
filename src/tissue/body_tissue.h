// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A position-based body as a tissue. A sweep is a time step of the body.
//
// A tool holds nodes, or is a sphere that keeps the body's surface out (pbd/body_contact.h). While
// there is a sphere, or a second piece, contact follows each sub-step.
//
// The tetrahedra carry the scan (resample/embedded_scan.h).

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

#include "resample/embedded_scan.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// A body's tetrahedra, and what is beside its constraints.
struct BodyPlan {
    TetMesh mesh{};                      ///< of the body's particles, at rest
    std::vector<std::int32_t> pieces{};  ///< [tetrahedron]: its solid, in contact with the others;
                                         ///< empty: all are one
    std::int32_t steps = 1;              ///< of the body in a time step
    double friction = 0;
    double reach_mm = 10;  ///< distance from the body at which the scan rests
    /// Piece that carries a voxel, as of EmbeddedScanSettings.
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
    Status place_eye(std::uint32_t tool, Vec3d position_mm, double radius_mm) noexcept override;
    bool has_eye(std::uint32_t tool) const noexcept override { return m_eyes.contains(tool); }
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_tools.contains(tool) || m_spheres.contains(tool);
    }
    bool is_touched() const noexcept override { return !m_tools.empty() || !m_spheres.empty(); }
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override;
    Result<Sweep> sweep() noexcept override;
    Status reset() noexcept override;
    /// "particles", "tetrahedra", and "fixed_particles".
    Record figures() const override;
    Record report() const override;

    void state(std::vector<double>& numbers) const override;
    Status set_state(std::span<const double> numbers) noexcept override;
    std::uint64_t file_kind() const noexcept override { return 0x33'62'73'6c'70'00'00'0a; }
    std::uint64_t hash() const override;

    void positions_mm(std::span<Vec3d> positions_mm) const override {
        m_body.get_positions(positions_mm);
    }
    std::int32_t node_count() const override { return m_body.particle_count(); }

    const Volume& volume() const override { return m_carried->volume(); }
    const Deformation& deformation() const override;
    const TaskArena& arena() const override { return m_carried->arena(); }
    Status update_deformation() const override;

  private:
    using Tools = std::map<std::uint32_t, std::vector<std::int32_t>>;
    using Spheres = std::map<std::uint32_t, BodyTool>;

    BodyTissue(PbdBody body, BodyContact contact, BodyPlan plan,
               std::unique_ptr<EmbeddedScan> carried);
    Result<PushReport> push_nodes(std::uint32_t tool, const Push& push);
    Result<SlideReport> slide_sphere(std::uint32_t tool, const Push& way);
    Status step(std::int32_t count, std::uint32_t tool = 0, Vec3d way_mm = {0, 0, 0});
    void find_box(Vec3d& low, Vec3d& high) const;
    bool is_free(const BodyTool& sphere, Vec3d way_mm) const;
    bool contains(Vec3d point_mm) const;
    std::vector<std::int32_t> nodes_at(const Push& push, Vec3d point_mm, bool or_around) const;
    void take(std::uint32_t tool, std::vector<std::int32_t> nodes);
    void set_masses() noexcept;
    Status stride(std::uint32_t tool, Vec3d shift);
    void keep_state();
    double folded_mm3() const;
    bool is_weightless() const { return m_body.settings().gravity == Vec3d{0, 0, 0}; }
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

    PbdBody m_body;
    BodyContact m_contact;
    std::int32_t m_steps;                              ///< of the body in a time step
    bool m_has_pieces;                                 ///< two or more
    std::unique_ptr<EmbeddedScan> m_carried;           ///< the scan
    std::vector<std::array<std::int32_t, 4>> m_cells;  ///< tetrahedra of the body
    std::vector<Vec3d> m_rest;                         ///< [node], in the body's precision
    std::vector<double> m_rest_volumes;                ///< [tetrahedron] [mm³]
    double m_edge_mm = 0;                              ///< mean edge of the tetrahedra
    Tools m_tools;                                     ///< nodes that each tool holds, sorted
    Spheres m_spheres, m_eyes;                         ///< they keep the body's surface out
    std::vector<BodyTool> m_from, m_to;                ///< of a step: all spheres, then all eyes
    bool m_settled = true;
    std::vector<Vec3d> m_calm;  ///< positions near which all nodes have stayed; empty: unknown
    int m_calm_sweeps = 0;      ///< since then
    int m_untold_sweeps = 0;    ///< since the last command
    std::vector<Vec3d> m_positions, m_velocities;  ///< memory of noexcept functions
    mutable std::vector<Vec3d> m_shown;            ///< [node], of the deformation
    mutable bool m_is_shown = true;
};

}  // namespace pliant
#pragma GCC visibility pop
