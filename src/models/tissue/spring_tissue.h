// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs as a tissue. A sweep is ten node updates, ten milliseconds at 1 kHz.

#pragma once

#include <pliant/tissues.h>

#include <memory>
#include <vector>

namespace pliant {

class SpringScanTissue final : public NodeTissue {
  public:
    static constexpr int kStepsPerSweep = 10;
    static constexpr double kRate_hz = 1000;  ///< node updates per second

    explicit SpringScanTissue(std::unique_ptr<SpringDeformation> model)
        : m_model(std::move(model)), m_positions(m_model->positions_mm()) {}

    TissueTraits traits() const noexcept override;
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override;
    void release(std::uint32_t tool) noexcept override { m_model->let_go(tool); }
    bool is_touched_by(std::uint32_t tool) const noexcept override { return m_model->holds(tool); }
    bool is_touched() const noexcept override { return m_model->is_held(); }
    Result<CutReport> cut(const CutSurface& surface) noexcept override;
    std::optional<Vec3d> force_n(std::uint32_t tool) noexcept override;
    Result<Sweep> sweep() noexcept override;
    /// Its steps are node updates.
    Result<AdvanceReport> advance(const Budget& budget) noexcept override;
    Status reset() noexcept override;
    /// The depth of the forces.
    Record settings() const override;
    Status configure(const Record& changes) noexcept override;
    Result<std::int32_t> take_depth(double threshold_mm, std::int32_t max_depth) noexcept override;
    /// "nodes" along i, j, k and "active_nodes", the nodes that forces reached in the last sweep,
    /// or at most in the last call of advance().
    Record figures() const override;
    Record report() const override;

    void state(std::vector<double>& numbers) const override;
    Status set_state(std::span<const double> numbers) noexcept override;
    std::uint64_t file_kind() const noexcept override { return 0x31'70'73'6c'70'00'00'0a; }
    std::uint64_t hash() const override { return m_model->hash(); }

    const Volume& volume() const override { return m_model->volume(); }
    const Deformation& deformation() const override { return m_model->deformation(); }
    const TaskArena& arena() const override { return m_model->arena(); }
    Status update_deformation() const override { return m_model->update_deformation(); }

  private:
    std::unique_ptr<SpringDeformation> m_model;
    mutable std::vector<Vec3d> m_positions;  ///< memory for state()
    std::int32_t m_active_nodes = 0;
};

}  // namespace pliant
