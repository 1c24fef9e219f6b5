// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Springs as a tissue. A sweep is ten node updates, ten milliseconds at 1 kHz. Steps that can be
// taken back are the places of all nodes: there are few of them.

#pragma once

#include <pliant/spring_deformation.h>

#include <list>
#include <memory>
#include <vector>

#include "scene/tissue.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

class SpringScanTissue : public Tissue {
  public:
    static constexpr int kStepsPerSweep = 10;
    static constexpr double kRate_hz = 1000;  ///< of node updates

    explicit SpringScanTissue(std::unique_ptr<SpringDeformation> model)
        : m_model(std::move(model)) {}

    Result<PushReport> push(std::uint32_t tool, const Push& push) override;
    Result<GrabReport> grab(std::uint32_t tool, const Push& place, double reach_mm) override;
    Result<PushReport> drag_to(Vec3d offset_mm) override;
    void let_go() noexcept override;
    void release(std::uint32_t tool) noexcept override { m_model->let_go(tool); }
    bool is_touched_by(std::uint32_t tool) const override { return m_model->holds(tool); }
    bool is_touched() const override { return m_model->is_held(); }
    std::optional<Vec3d> force_n(std::uint32_t tool) override { return m_model->force_n(tool); }
    Result<Sweep> sweep() override;
    double sweep_time_ms() const override { return 1000 * kStepsPerSweep / kRate_hz; }
    Status reset() override {
        m_model->reset();
        return Ok{};
    }
    void begin_group(const std::string& name) override;
    int end_group() noexcept override;
    int undo_steps() const override { return int(m_done.size()); }
    Status undo() override;
    Status redo() override;
    Status rest() override { return m_model->set_places(m_model->places_mm()); }
    Status save_state(const std::filesystem::path& path) const override;
    Status load_state(const std::filesystem::path& path) override;
    std::uint64_t hash() const override { return m_model->hash(); }
    SpringDeformation* springs() override { return m_model.get(); }
    std::int32_t active_nodes() const { return m_active_nodes; }
    Vec3i control_nodes() const { return m_model->control().grid().size; }

    const Volume& volume() const override { return m_model->volume(); }
    const Lattice& lattice() const override { return m_model->lattice(); }
    const TaskArena& arena() const override { return m_model->arena(); }
    Status update_lattice() const override { return m_model->update_lattice(); }

  private:
    using Places = std::vector<Vec3d>;
    Status go_back(std::list<Places>& from, std::list<Places>& to);
    struct Drag {
        std::uint32_t tool;
        Push place;
        Vec3d done_mm;
    };

    std::unique_ptr<SpringDeformation> m_model;
    std::optional<Drag> m_drag;
    std::list<Places> m_before;          ///< one, while a group goes on
    std::list<Places> m_done, m_undone;  ///< as it was before, or after; the next one last
    Places m_now;                        ///< scratch
    std::int32_t m_active_nodes = 0;
};

}  // namespace pliant
#pragma GCC visibility pop
