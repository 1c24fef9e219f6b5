// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail as a tissue. It adds what ChainMail leaves to its caller: which tools lie where, and
// what they hold while the tissue relaxes.

#pragma once

#include <pliant/chainmail_slide.h>

#include <map>
#include <vector>

#include "scene/tissue.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

class ChainMailTissue : public Tissue {
  public:
    explicit ChainMailTissue(ChainMail model) : m_model(std::move(model)) {}

    Result<PushReport> push(std::uint32_t tool, const Push& push) override;
    Result<GrabReport> grab(std::uint32_t tool, const Push& place, double reach_mm) override;
    Result<PushReport> drag_to(Vec3d offset_mm) override { return m_model.drag_to(offset_mm); }
    void let_go() noexcept override { m_model.let_go(); }
    void release(std::uint32_t tool) noexcept override { m_contacts.erase(tool); }
    void place_eye(std::uint32_t tool, Vec3d place_mm, double radius_mm) override;
    bool has_eye(std::uint32_t tool) const override { return m_eyes.contains(tool); }
    bool is_touched_by(std::uint32_t tool) const override { return m_contacts.contains(tool); }
    bool is_touched() const override { return !m_contacts.empty(); }
    std::optional<Vec3d> force_n(std::uint32_t) override { return {}; }
    Result<Sweep> sweep() override;
    double sweep_time_ms() const override { return 0; }
    Status reset() override;
    void begin_group(const std::string& name) override { m_model.begin_group(name); }
    int end_group() noexcept override { return m_model.end_group(); }
    int undo_steps() const override { return m_model.undo_steps(); }
    Status undo() override { return m_model.undo(); }
    Status redo() override { return m_model.redo(); }
    Status rest() override {
        m_eyes.clear();
        return Ok{};
    }
    Status save_state(const std::filesystem::path& path) const override {
        return m_model.save_state(path);
    }
    Status load_state(const std::filesystem::path& path) override {
        return m_model.load_state(path);
    }
    std::uint64_t hash() const override { return m_model.hash(); }
    ChainMail* chainmail() override { return &m_model; }

    /// Tissue slides off a sphere, which stays in the way.
    Result<SlideReport> slide(std::uint32_t tool, const Push& push, const TissueValues& shown);

    const Volume& volume() const override { return m_model.volume(); }
    const Lattice& lattice() const override { return m_model.lattice(); }
    const TaskArena& arena() const override { return m_model.arena(); }

  private:
    /// What a tool that stays has hold of.
    struct Contact {
        RelaxTool tool;
        std::vector<Vec3i> held;
    };

    ChainMail m_model;
    std::map<std::uint32_t, Contact> m_contacts;
    std::map<std::uint32_t, RelaxTool> m_eyes;
};

}  // namespace pliant
#pragma GCC visibility pop
