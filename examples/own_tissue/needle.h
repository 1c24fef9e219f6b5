// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter of one's own: a needle in jelly, which goes straight ahead. Its tip takes the jelly
// along by up to 3 mm. The page drives it like the catheter of a vessel.

#pragma once

#include <pliant/models/drivable.h>
#include <pliant/own_tissue.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace example {

using namespace pliant;

class Needle final : public NodeTissue, public Drivable {
  public:
    static Result<std::unique_ptr<Tissue>> create(const Volume& scan, const TaskArena& arena) {
        auto rest = Deformation::create(scan.grid);
        if (!rest) return rest.error();
        return std::unique_ptr<Tissue>(new Needle(scan, arena, std::move(*rest)));
    }
    const Volume& volume() const override { return m_scan; }
    const TaskArena& arena() const override { return m_arena; }
    const Deformation& deformation() const override { return m_deformation; }
    /// Moves the jelly around the tip by exp(−|X − tip|² / 2·(6 mm)²) of what the tip takes along.
    Status update_deformation() const override {
        if (m_is_written) return Ok{};
        const Grid& grid = m_scan.grid;
        const Vec3d tip = m_view.catheter_mm.back();
        const Vec3d along = std::min(m_inserted_mm, 3.0) * m_entry.direction;
        const Vec3d middle = voxel_from_world(grid, tip);
        Box3i box;  // 18 mm to each side, in the scan
        for (int a = 0; a < 3; ++a) {
            const double reach = 18 / grid.spacing_mm[a];
            box.begin[a] = std::max(0, int(std::floor(middle[a] - reach)));
            box.end[a] = std::min(grid.size[a], int(std::ceil(middle[a] + reach)));
        }
        m_deformation.reset();
        const Status moved = m_deformation.displace(box, [&](Vec3i e) {
            const Vec3d d = world_from_voxel(grid, {e.x * 1.0, e.y * 1.0, e.z * 1.0}) - tip;
            return std::exp(-dot(d, d) / (2 * 6 * 6)) * along;
        });
        m_is_written = moved.ok();
        return moved;
    }
    TissueTraits traits() const noexcept override {
        return {.model = "needle",
                .takes_pushes = false,
                .moves_by_itself = true,
                .sweep_ms = 1000 * kStep_s,
                .update_hz = 1 / kStep_s};
    }
    Drivable* drivable() noexcept override { return this; }
    Result<PushReport> push(std::uint32_t, const Push&) noexcept override {
        return Error{ErrorCode::Unsupported, "push: expected another tissue than a needle's"};
    }

    Status drive(std::uint32_t tool, const CatheterCommand& hand) noexcept override {
        if (!std::isfinite(hand.insert_mm_s) || !std::isfinite(hand.rotate_deg_s))
            return Error{ErrorCode::InvalidArgument, "expected finite speeds"};
        m_hand = hand;
        m_driver = hand.insert_mm_s != 0 || hand.rotate_deg_s != 0 ? tool : 0;
        return Ok{};
    }
    void release(std::uint32_t tool) noexcept override {
        if (is_touched_by(tool)) stop();
    }
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return tool != 0 && tool == m_driver;
    }
    bool is_touched() const noexcept override { return m_driver != 0; }
    Result<Sweep> sweep() noexcept override {
        if (m_driver == 0) return Sweep{};
        place(std::clamp(m_inserted_mm + kStep_s * m_hand.insert_mm_s, 0.0, length_mm()));
        m_rotated_deg += kStep_s * m_hand.rotate_deg_s;
        m_time_s += kStep_s;
        return Sweep{false};
    }
    Status reset() noexcept override { return set_state(std::array<double, 3>{}); }

    void state(std::vector<double>& n) const override {
        n = {m_inserted_mm, m_rotated_deg, m_time_s};
    }
    Status set_state(std::span<const double> n) noexcept override {
        if (n.size() != 3 || !(n[0] >= 0 && n[0] <= length_mm()))
            return Error{ErrorCode::InvalidArgument, "expected a needle's state"};
        place(n[0]);
        m_rotated_deg = n[1];
        m_time_s = n[2];
        stop();
        return Ok{};
    }

    CatheterCommand hand() const noexcept override { return m_hand; }
    CatheterMeasures measures() const noexcept override {
        return {.time_s = m_time_s,
                .inserted_mm = m_inserted_mm,
                .rotated_deg = m_rotated_deg,
                .force_n = 0.05 * m_inserted_mm};  // friction along it
    }
    const CatheterView& view() const noexcept override { return m_view; }
    double radius_mm() const noexcept override { return 0.5; }
    double length_mm() const noexcept override { return 40; }
    CatheterEntry entry() const noexcept override { return m_entry; }
    const TriangleMesh& wall() const noexcept override { return m_no_wall; }

  private:
    static constexpr double kStep_s = 0.01;

    Needle(const Volume& scan, const TaskArena& arena, Deformation rest)
        : m_scan(scan), m_arena(arena), m_deformation(std::move(rest)) {
        const Vec3i last = scan.grid.size - Vec3i{1, 1, 1};
        m_entry = {.position_mm = world_from_voxel(scan.grid, {0.5 * last.x, 0.5 * last.y, 0}),
                   .direction = scan.grid.direction.columns[2],
                   .inserted_mm = 0};
        m_view.catheter_mm = {m_entry.position_mm, m_entry.position_mm};
    }
    void place(double inserted_mm) noexcept {
        m_inserted_mm = inserted_mm;
        m_view.catheter_mm.back() = m_entry.position_mm + inserted_mm * m_entry.direction;
        m_is_written = false;
    }
    void stop() noexcept {
        m_hand.insert_mm_s = m_hand.rotate_deg_s = 0;
        m_driver = 0;
    }

    const Volume& m_scan;
    const TaskArena& m_arena;
    mutable Deformation m_deformation;
    mutable bool m_is_written = true;  ///< m_deformation shows the needle
    CatheterEntry m_entry;
    CatheterCommand m_hand{};
    std::uint32_t m_driver = 0;  ///< tool of the hand that moves; 0: none
    double m_inserted_mm = 0, m_rotated_deg = 0, m_time_s = 0;
    CatheterView m_view;
    TriangleMesh m_no_wall;
};

}  // namespace example
