// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Undo: grouping of commands into steps, undo and redo.

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/errors.h"
#include "session/outcomes.h"
#include "session/scene.h"

namespace pliant::serve {

void Scene::begin_step(const std::string& name, std::uint32_t client, std::uint32_t stroke) {
    const bool goes_on = m_open && stroke != 0 && m_open->name == name &&
                         m_open->client == client && m_open->stroke == stroke;
    if (goes_on) return;
    end_step();
    reserve_step();
    OpenStep open{name, client, stroke, tissue().undo_steps()};
    tissue().begin_group(name);
    m_open = std::move(open);
}

/// Reserves the memory for the next step of the tissue.
void Scene::reserve_step() {
    if (m_spare.empty()) m_spare.emplace_back();
}

void Scene::end_step() noexcept {
    if (!m_open) return;
    tissue().let_go();
    m_holder = 0;
    OpenStep open = std::move(*m_open);
    m_open.reset();
    const int forgotten = tissue().end_group();
    if (forgotten < 0) {
        // Earlier steps are unreachable now.
        m_done.clear();
        m_undone.clear();
        m_unreachable = 0;
        m_lost = true;
        return;
    }
    if (tissue().undo_steps() + forgotten > open.undo_steps_before) {
        m_spare.front() = {.kind = StepKind::Tissue, .name = std::move(open.name)};
        keep(m_spare);
    }
    forget(forgotten);
}

/// Moves the single step of a list to the undo list.
void Scene::keep(std::list<Step>& step) noexcept {
    m_undone.clear();
    step.front().number = ++m_steps;
    m_done.splice(m_done.end(), step);
}

void Scene::forget(int tissue_steps) {
    const int hidden = std::min(tissue_steps, m_unreachable);
    m_unreachable -= hidden;
    tissue_steps -= hidden;
    while (tissue_steps > 0 && !m_done.empty()) {
        if (m_done.front().kind == StepKind::Tissue) --tissue_steps;
        m_done.pop_front();
    }
}

Result<SceneMemo> Scene::rest() noexcept {
    return attempt([&]() -> Result<SceneMemo> {
        end_step();
        if (const Status s = tissue().rest(); !s.ok()) return s.error();
        for (auto* steps : {&m_done, &m_undone})
            for (Step& step : *steps) step.stroke = 0;
        return SceneMemo{m_iso_hu,      m_polarity, m_relaxing, m_settled,
                         m_last_client, m_steps,    m_choice};
    });
}

Status Scene::restore(const std::filesystem::path& state, const SceneMemo& memo) {
    if (memo.tissue != m_choice)
        if (const Status s = choose(memo.tissue); !s.ok()) return s;
    if (const Status s = tissue().load_state(state); !s.ok()) return s;
    m_iso_hu = memo.iso_hu;
    m_polarity = memo.polarity;
    m_relaxing = memo.relaxing;
    m_settled = memo.settled;
    m_last_client = memo.last_client;
    m_steps = memo.steps;
    return Ok{};
}

Status Scene::load_state(const std::filesystem::path& state) noexcept {
    return attempt([&] { return choose(TissueChoice(m_choice), state); });
}

void Scene::forget_steps(std::int64_t count) {
    const auto is_old = [&](const Step& step) { return step.number <= count; };
    for (const Step& step : m_done)
        if (is_old(step) && step.kind == StepKind::Tissue) ++m_unreachable;
    std::erase_if(m_done, is_old);
    std::erase_if(m_undone, is_old);
}

void Scene::lose_steps(std::int64_t made) noexcept {
    for (const Step& step : m_done)
        if (step.kind == StepKind::Tissue) ++m_unreachable;
    m_done.clear();
    m_undone.clear();
    m_steps = made;
}

void Scene::swap_iso(Step& step) {
    std::swap(m_iso_hu, step.iso_hu);
    std::swap(m_polarity, step.polarity);
}

Outcome Scene::act(std::uint32_t, const UndoCommand&) {
    end_step();
    if (m_done.empty())
        return refused({ErrorCode::NotFound, "undo: expected a step to take back, found none"});
    if (m_done.back().kind == StepKind::Iso)
        swap_iso(m_done.back());
    else if (const Status s = tissue().undo(); !s.ok())
        return refused(s.error());
    m_undone.splice(m_undone.end(), m_done, std::prev(m_done.end()));
    // Relaxation would discard the steps that can be redone.
    m_settled = true;
    tissue_changed();
    return {.message = m_undone.back().name};
}

Outcome Scene::act(std::uint32_t, const RedoCommand&) {
    end_step();
    if (m_undone.empty())
        return refused({ErrorCode::NotFound, "redo: expected a step that was undone, found none"});
    if (m_undone.back().kind == StepKind::Iso)
        swap_iso(m_undone.back());
    else if (const Status s = tissue().redo(); !s.ok())
        return refused(s.error());
    m_done.splice(m_done.end(), m_undone, std::prev(m_undone.end()));
    m_settled = true;
    tissue_changed();
    return {.message = m_done.back().name};
}

}  // namespace pliant::serve
