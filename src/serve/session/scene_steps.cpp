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

bool Scene::begin_step(const std::string& name, std::uint32_t client, std::uint32_t stroke) {
    Stroke begun{name, client, stroke};
    if (m_open && stroke != 0 && goes_on(begun)) return false;
    end_step();
    reserve_step();
    OpenStep open{{std::move(begun)}, tissue().undo_steps()};
    tissue().begin_group(name);
    m_open = std::move(open);
    return true;
}

/// Whether the open step has the stroke. If other clients' strokes have interrupted it, the open
/// step takes in all steps since.
bool Scene::goes_on(const Stroke& stroke) {
    const auto has = [&](const std::vector<Stroke>& strokes) {
        return std::find(strokes.begin(), strokes.end(), stroke) != strokes.end();
    };
    if (has(m_open->strokes)) return true;
    int joined = 0;
    std::vector<Stroke> strokes = m_open->strokes;
    for (auto step = m_done.rbegin(); step != m_done.rend(); ++step) {
        const auto ended = [](const Stroke& part) { return part.number == 0; };
        if (step->kind != StepKind::Tissue || std::ranges::all_of(step->strokes, ended))
            return false;
        ++joined;
        if (joined > m_open->joined)
            strokes.insert(strokes.end(), step->strokes.begin(), step->strokes.end());
        if (!has(step->strokes)) continue;
        m_open->strokes = std::move(strokes);
        m_open->joined = joined;
        return true;
    }
    return false;
}

/// Reserves the memory for the next step of the tissue.
void Scene::reserve_step() {
    if (m_spare.empty()) m_spare.emplace_back();
}

void Scene::end_strokes(std::uint32_t client) noexcept {
    const auto end = [&](std::vector<Stroke>& strokes) {
        for (Stroke& stroke : strokes)
            if (stroke.client == client) stroke.number = 0;
    };
    if (m_open) end(m_open->strokes);
    for (Step& step : m_done) end(step.strokes);
}

void Scene::let_go() noexcept {
    tissue().let_go();
    m_holder = 0;
}

void Scene::end_step() noexcept {
    if (!m_open) return;
    let_go();
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
        Step& step = m_spare.front();
        step = {.kind = StepKind::Tissue, .strokes = std::move(open.strokes)};
        for (; open.joined > 0; --open.joined) {
            step.tissue_steps += m_done.back().tissue_steps;
            m_done.pop_back();
        }
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

/// Drops the steps that have lost tissue steps, the oldest.
void Scene::forget(int tissue_steps) {
    const int hidden = std::min(tissue_steps, m_unreachable);
    m_unreachable -= hidden;
    tissue_steps -= hidden;
    while (tissue_steps > 0 && !m_done.empty()) {
        if (m_done.front().kind == StepKind::Tissue) tissue_steps -= m_done.front().tissue_steps;
        m_done.pop_front();
    }
    m_unreachable += std::max(-tissue_steps, 0);
}

Result<SceneMemo> Scene::rest() noexcept {
    return attempt([&]() -> Result<SceneMemo> {
        end_step();
        if (const Status s = tissue().rest(); !s.ok()) return s.error();
        for (auto* steps : {&m_done, &m_undone})
            for (Step& step : *steps)
                for (Stroke& stroke : step.strokes) stroke.number = 0;
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
        if (is_old(step) && step.kind == StepKind::Tissue) m_unreachable += step.tissue_steps;
    std::erase_if(m_done, is_old);
    std::erase_if(m_undone, is_old);
}

void Scene::lose_steps(std::int64_t made) noexcept {
    for (const Step& step : m_done)
        if (step.kind == StepKind::Tissue) m_unreachable += step.tissue_steps;
    m_done.clear();
    m_undone.clear();
    m_steps = made;
}

/// Undoes or redoes a step.
Outcome Scene::step_back(Step& step, bool undo) {
    Outcome outcome{.message = step.name()};
    for (const Stroke& stroke : step.strokes)
        if (stroke.client != 0 && std::find(outcome.whose.begin(), outcome.whose.end(),
                                            stroke.client) == outcome.whose.end())
            outcome.whose.push_back(stroke.client);
    if (step.kind == StepKind::Iso) {
        std::swap(m_iso_hu, step.iso_hu);
        std::swap(m_polarity, step.polarity);
    } else {
        for (int n = 0; n < step.tissue_steps; ++n) {
            const Status s = undo ? tissue().undo() : tissue().redo();
            if (s.ok()) continue;
            while (n-- > 0) (void)(undo ? tissue().redo() : tissue().undo());
            return refused(s.error());
        }
    }
    // Relaxation would discard the steps that can be redone.
    m_settled = true;
    tissue_changed();
    return outcome;
}

Outcome Scene::act(std::uint32_t, const UndoCommand&) {
    end_step();
    if (m_done.empty())
        return refused({ErrorCode::NotFound, "undo: expected a step to take back, found none"});
    Outcome outcome = step_back(m_done.back(), true);
    if (outcome.ok()) m_undone.splice(m_undone.end(), m_done, std::prev(m_done.end()));
    return outcome;
}

Outcome Scene::act(std::uint32_t, const RedoCommand&) {
    end_step();
    if (m_undone.empty())
        return refused({ErrorCode::NotFound, "redo: expected a step that was undone, found none"});
    Outcome outcome = step_back(m_undone.back(), false);
    if (outcome.ok()) m_done.splice(m_done.end(), m_undone, std::prev(m_undone.end()));
    return outcome;
}

}  // namespace pliant::serve
