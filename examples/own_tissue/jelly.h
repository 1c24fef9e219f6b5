// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue of one's own: jelly. A tool drags a Gaussian bump along; a bump without a tool decays.
//
//   u(X) = s · exp(−|X − c|² / 2·(6 mm)²)      c centre, s shift of the bump [mm, LPS]

#pragma once

#include <pliant/tissue.h>

#include <cmath>

namespace example {

using namespace pliant;

class Jelly final : public NodeTissue {
  public:
    static Result<std::unique_ptr<Tissue>> create(const Volume& scan, const TaskArena& arena) {
        auto rest = Deformation::create(scan.grid);
        if (!rest) return rest.error();
        return std::unique_ptr<Tissue>(new Jelly(scan, arena, std::move(*rest)));
    }
    const Volume& volume() const override { return m_scan; }
    const TaskArena& arena() const override { return m_arena; }
    const Deformation& deformation() const override { return m_deformation; }
    TissueTraits traits() const noexcept override {
        return {.model = "jelly", .moves_by_itself = true, .sweep_ms = 10, .update_hz = 100};
    }

    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override {
        const bool goes_on = tool == m_tool;
        const Status moved = move(goes_on ? m_centre : push.point_mm,
                                  goes_on ? m_shift + push.push_mm : push.push_mm);
        if (!moved) return moved.error();
        m_tool = tool;
        return PushReport{.status = PushStatus::Applied,
                          .step_fraction = 1,
                          .grabbed_elements = 1,
                          .message = {}};
    }
    void release(std::uint32_t tool) noexcept override { m_tool = tool == m_tool ? 0 : m_tool; }
    bool is_touched_by(std::uint32_t tool) const noexcept override { return tool == m_tool; }
    bool is_touched() const noexcept override { return m_tool != 0; }
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override {
        return tool == m_tool ? -0.2 * m_shift : Vec3d{0, 0, 0};  // 0.2 N/mm
    }
    Result<Sweep> sweep() noexcept override {
        if (m_tool != 0 || norm(m_shift) == 0) return Sweep{};
        const Status moved = move(m_centre, norm(m_shift) < 0.01 ? Vec3d{} : 0.9 * m_shift);
        if (!moved) return moved.error();
        return Sweep{false};
    }
    Status reset() noexcept override { return move(m_centre, {0, 0, 0}); }

    void state(std::vector<double>& n) const override {
        n = {m_centre.x, m_centre.y, m_centre.z, m_shift.x, m_shift.y, m_shift.z};
    }
    Status set_state(std::span<const double> n) noexcept override {
        if (n.size() != 6) return Error{ErrorCode::InvalidArgument, "expected six numbers"};
        m_tool = 0;
        return move({n[0], n[1], n[2]}, {n[3], n[4], n[5]});
    }

  private:
    Jelly(const Volume& scan, const TaskArena& arena, Deformation rest)
        : m_scan(scan), m_arena(arena), m_deformation(std::move(rest)) {}
    Status move(Vec3d centre, Vec3d shift) noexcept {
        const Vec3d middle = voxel_from_world(m_scan.grid, centre);
        Box3i box;  // 18 mm to each side
        for (int a = 0; a < 3; ++a) {
            const double reach = 18 / m_scan.grid.spacing_mm[a];
            box.begin[a] = int(std::floor(middle[a] - reach));
            box.end[a] = int(std::ceil(middle[a] + reach));
        }
        if (centre != m_centre) m_deformation.reset();
        const Status moved = m_deformation.displace(box, [&](Vec3i e) {
            const Vec3d d =
                world_from_voxel(m_scan.grid, {e.x * 1.0, e.y * 1.0, e.z * 1.0}) - centre;
            return std::exp(-dot(d, d) / (2 * 6 * 6)) * shift;
        });
        if (moved.ok()) m_centre = centre, m_shift = shift;
        return moved;
    }

    const Volume& m_scan;
    const TaskArena& m_arena;
    Deformation m_deformation;
    Vec3d m_centre{0, 0, 0}, m_shift{0, 0, 0};
    std::uint32_t m_tool = 0;  ///< tool that holds the bump; 0: none
};

}  // namespace example
