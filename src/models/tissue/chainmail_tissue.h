// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail as a tissue. Adds the state that ChainMail leaves to its caller: the positions of
// resting tools, and the elements that they hold during relaxation.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/tissues.h>

#include <map>
#include <vector>

namespace pliant {

class ChainMailTissue final : public Tissue {
  public:
    explicit ChainMailTissue(ChainMail model, RestingTool resting = RestingTool::KeepsTissueOut)
        : m_model(std::move(model)), m_resting(resting) {}

    TissueTraits traits() const noexcept override;
    Result<PushReport> push(std::uint32_t tool, const Push& push) noexcept override;
    Result<GrabReport> grab(std::uint32_t tool, const Push& position,
                            double reach_mm) noexcept override;
    Result<PushReport> drag_to(Vec3d offset_mm) noexcept override;
    void let_go() noexcept override { m_model.let_go(); }
    void release(std::uint32_t tool) noexcept override { m_contacts.erase(tool); }
    bool is_touched_by(std::uint32_t tool) const noexcept override {
        return m_contacts.contains(tool);
    }
    bool is_touched() const noexcept override { return !m_contacts.empty(); }
    Result<SlideReport> slide(std::uint32_t tool, const Push& way,
                              const TissueValues& tissue_values) noexcept override;
    Result<CutReport> cut(const CutSurface& surface) noexcept override;
    Result<CarveReport> carve(const CarveTool& tool) noexcept override;
    Status place_eye(std::uint32_t tool, Vec3d position_mm, double radius_mm) noexcept override;
    bool has_eye(std::uint32_t tool) const noexcept override { return m_eyes.contains(tool); }
    std::optional<double> energy_mm2() noexcept override;
    Result<Sweep> sweep() noexcept override { return sweep_part({}); }
    /// Its parts are bricks.
    Result<Sweep> sweep_part(const SweepLimit& limit) noexcept override;
    Result<AdvanceReport> advance(const Budget& budget) noexcept override;
    Status reset() noexcept override;
    Record settings() const override;
    Status configure(const Record& changes) noexcept override;
    /// The solver, the largest violation of a limit, and the certificate against folds.
    Record report() const override;

    void begin_group(const std::string& name) override { m_model.begin_group(name); }
    int end_group() noexcept override { return m_model.end_group(); }
    int undo_steps() const noexcept override { return m_model.undo_steps(); }
    Status undo() noexcept override;
    Status redo() noexcept override;
    Status rest() noexcept override;
    Status save_state(const std::string& path) const noexcept override;
    Status load_state(const std::string& path) noexcept override;
    std::uint64_t hash() const override { return m_model.hash(); }

    const Volume& volume() const override { return m_model.volume(); }
    const Deformation& deformation() const override { return m_model.deformation(); }
    const TaskArena& arena() const override { return m_model.arena(); }

  private:
    /// A resting tool, and the elements that it holds.
    struct Contact {
        RelaxTool tool;
        std::vector<Vec3i> held;
        bool slid = false;  ///< without holding elements
    };

    RelaxOptions relax_options() const;

    ChainMail m_model;
    RestingTool m_resting;
    std::map<std::uint32_t, Contact> m_contacts;
    std::map<std::uint32_t, RelaxTool> m_eyes;
};

}  // namespace pliant
