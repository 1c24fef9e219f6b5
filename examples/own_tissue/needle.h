// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A catheter of one's own: a needle in jelly, which goes straight ahead. Its tip takes the jelly
// along by up to 3 mm. The page drives it like the catheter of a vessel.

#pragma once

#include <pliant/drivable.h>

#include <algorithm>

#include "jelly.h"

namespace example {

class Needle final : public Jelly, public Drivable {
  public:
    static Result<std::unique_ptr<Tissue>> create(const Volume& scan, const TaskArena& arena) {
        auto rest = Deformation::create(scan.grid);
        if (!rest) return rest.error();
        return std::unique_ptr<Tissue>(new Needle(scan, arena, std::move(*rest)));
    }
    TissueTraits traits() const noexcept override {
        return {.model = "needle",
                .takes_pushes = false,
                .moves_by_itself = true,
                .sweep_ms = 1000 * kStep_s,
                .update_hz = 1 / kStep_s};
    }
    Drivable* drivable() noexcept override { return this; }

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
        const double inserted =
            std::clamp(m_inserted_mm + kStep_s * m_hand.insert_mm_s, 0.0, length_mm());
        if (const Status s = place(inserted); !s) return s.error();
        m_rotated_deg += kStep_s * m_hand.rotate_deg_s;
        m_time_s += kStep_s;
        return Sweep{false};
    }
    Status reset() noexcept override { return set_state(std::vector<double>(3)); }

    void state(std::vector<double>& n) const override {
        n = {m_inserted_mm, m_rotated_deg, m_time_s};
    }
    Status set_state(std::span<const double> n) noexcept override {
        if (n.size() != 3 || !(n[0] >= 0 && n[0] <= length_mm()))
            return Error{ErrorCode::InvalidArgument, "expected a needle's state"};
        if (const Status s = place(n[0]); !s) return s;
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
        : Jelly(scan, arena, std::move(rest)) {
        const Vec3i last = scan.grid.size - Vec3i{1, 1, 1};
        m_entry = {.position_mm = world_from_voxel(scan.grid, {0.5 * last.x, 0.5 * last.y, 0}),
                   .direction = scan.grid.direction.columns[2],
                   .inserted_mm = 0};
        m_view.catheter_mm = {m_entry.position_mm, m_entry.position_mm};
    }
    Status place(double inserted_mm) noexcept {
        const Vec3d tip = m_entry.position_mm + inserted_mm * m_entry.direction;
        const Status moved = move(tip, std::min(inserted_mm, 3.0) * m_entry.direction);
        if (!moved) return moved;
        m_inserted_mm = inserted_mm;
        m_view.catheter_mm.back() = tip;
        return Ok{};
    }
    void stop() noexcept {
        m_hand.insert_mm_s = m_hand.rotate_deg_s = 0;
        m_driver = 0;
    }

    CatheterEntry m_entry;
    CatheterCommand m_hand{};
    std::uint32_t m_driver = 0;  ///< tool of the hand that moves; 0: none
    double m_inserted_mm = 0, m_rotated_deg = 0, m_time_s = 0;
    CatheterView m_view;
    TriangleMesh m_no_wall;
};

}  // namespace example
