// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue of one's own: jelly. A tool drags a Gaussian bump along; a bump without a tool decays.
//
//   u(X) = s · exp(−|X − c|² / 2·(6 mm)²)      c centre, s shift of the bump [mm, LPS]

#pragma once

#include <pliant/own_tissue.h>

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace example {

using namespace pliant;

class Jelly final : public OwnTissue {
  public:
    static Result<std::unique_ptr<Tissue>> create(const Volume& scan, const TaskArena& arena) {
        auto rest = Deformation::create(scan.grid);
        if (!rest) return rest.error();
        return std::unique_ptr<Tissue>(new Jelly(scan, arena, std::move(*rest)));
    }
    const Volume& volume() const override { return m_scan; }
    const TaskArena& arena() const override { return m_arena; }
    const Deformation& deformation() const override { return m_deformation; }
    /// Writes 20,000 elements: once for each picture or hash, instead of once for each step.
    Status update_deformation() const override {
        if (m_is_written) return Ok{};
        m_deformation.reset();
        const Status written = m_deformation.displace(box(), [&](Vec3i e) {
            const Vec3d d =
                world_from_voxel(m_scan.grid, {e.x * 1.0, e.y * 1.0, e.z * 1.0}) - m_centre;
            return std::exp(-dot(d, d) / (2 * 6 * 6)) * m_shift;
        });
        m_is_written = written.ok();
        return written;
    }
    TissueTraits traits() const noexcept override {
        return {.model = "jelly", .moves_by_itself = true, .sweep_ms = 10, .update_hz = 100};
    }
    void release(std::uint32_t tool) noexcept override {
        if (tool == m_tool) m_tool.reset();
    }
    bool is_touched_by(std::uint32_t tool) const noexcept override { return tool == m_tool; }
    bool is_touched() const noexcept override { return m_tool.has_value(); }

    void state(std::vector<double>& n) const override {
        n = {m_centre.x, m_centre.y, m_centre.z, m_shift.x, m_shift.y, m_shift.z};
    }

  protected:
    Result<PushReport> do_push(std::uint32_t tool, const Push& push) override {
        const Vec3d centre = tool == m_tool ? m_centre : push.point_mm;
        const Vec3d shift = tool == m_tool ? m_shift + push.push_mm : push.push_mm;
        if (!(norm(push.point_mm) <= 1e4 && norm(shift) <= kFarthest_mm &&
              push.sphere_radius_mm >= 0))
            return Error{ErrorCode::InvalidArgument, "push: expected a bump of 0 to 500 mm"};
        move(centre, shift);
        m_tool = tool;
        return PushReport{.status = PushStatus::Applied,
                          .step_fraction = 1,
                          .grabbed_elements = 1,
                          .message = {}};
    }
    Result<Sweep> do_sweep() override {
        if (m_tool || norm(m_shift) == 0) return Sweep{};
        move(m_centre, norm(m_shift) < 0.01 ? Vec3d{} : 0.9 * m_shift);
        return Sweep{.settled = false, .message = {}};
    }
    Status do_reset() override {
        move(m_centre, {0, 0, 0});
        m_tool.reset();
        return Ok{};
    }
    Status do_set_state(std::span<const double> n) override {
        if (n.size() != 6) return Error{ErrorCode::InvalidArgument, "expected six numbers"};
        const Vec3d centre{n[0], n[1], n[2]}, shift{n[3], n[4], n[5]};
        if (!(norm(centre) <= 1e4 && norm(shift) <= kFarthest_mm))
            return Error{ErrorCode::InvalidArgument, "expected a bump of 0 to 500 mm"};
        move(centre, shift);
        m_tool.reset();
        return Ok{};
    }
    std::optional<Vec3d> do_force_n(std::uint32_t tool) override {
        return tool == m_tool ? -0.2 * m_shift : Vec3d{0, 0, 0};  // 0.2 N/mm
    }

  private:
    static constexpr double kFarthest_mm = 500;  ///< of an element, see Deformation::write

    Jelly(const Volume& scan, const TaskArena& arena, Deformation rest)
        : m_scan(scan), m_arena(arena), m_deformation(std::move(rest)) {}
    void move(Vec3d centre, Vec3d shift) {
        m_is_written = m_is_written && centre == m_centre && shift == m_shift;
        m_centre = centre;
        m_shift = shift;
    }
    /// Elements up to 18 mm from the bump's centre.
    Box3i box() const {
        const Vec3d middle = voxel_from_world(m_scan.grid, m_centre);
        Box3i box;
        for (int a = 0; a < 3; ++a) {
            const double reach = 18 / m_scan.grid.spacing_mm[a];
            box.begin[a] = int(std::floor(middle[a] - reach));
            box.end[a] = int(std::ceil(middle[a] + reach));
        }
        return box;
    }

    const Volume& m_scan;
    const TaskArena& m_arena;
    Vec3d m_centre{0, 0, 0}, m_shift{0, 0, 0};
    std::optional<std::uint32_t> m_tool;  ///< tool that holds the bump
    mutable Deformation m_deformation;
    mutable bool m_is_written = true;  ///< whether m_deformation shows the bump
};

}  // namespace example
