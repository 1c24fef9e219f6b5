// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Commands to the tissue.

#include <pliant/chainmail.h>
#include <pliant/models/drivable.h>

#include <algorithm>
#include <utility>

#include "base/errors.h"
#include "protocol/limits.h"
#include "protocol/wire_rows.h"
#include "session/outcomes.h"
#include "session/scene.h"

namespace pliant::serve {
namespace {

constexpr double kSeen = 0.02;  ///< shorter steps can't be seen [mm; voxels of less than 1 mm]

double least_of(Vec3d v) {
    return std::min({v.x, v.y, v.z});
}

/// A single stroke number, so that continuous driving is one step of undo.
constexpr std::uint32_t kDrives = 1;

}  // namespace

Outcome Scene::act(std::uint32_t, const DepthCommand& command) {
    if (!has_setting("depth")) return not_with(m_choice, "depth", "springs");
    int layers = command.layers.value_or(m_choice.springs.depth);
    if (command.within_mm) {
        const auto found = tissue().take_depth(*command.within_mm, kMaxDepthLayers);
        if (!found.ok()) return refused(found.error());
        layers = *found;
    } else if (const Status s = tissue().configure({{"depth", layers}}); !s.ok()) {
        return refused(s.error());
    }
    m_choice.springs.depth = layers;
    m_choice.depth_by_time = command.by_time.value_or(false);
    stir();
    return {};
}

Outcome Scene::act(std::uint32_t client, const DriveCommand& command) {
    Drivable* const catheter = tissue().drivable();
    if (!catheter) return not_with(m_choice, "catheter", "vessel");
    CatheterCommand hand = catheter->hand();
    hand.insert_mm_s = command.insert_mm_s.value_or(hand.insert_mm_s);
    hand.rotate_deg_s = command.rotate_deg_s.value_or(hand.rotate_deg_s);
    hand.bend_first_deg = command.bend_first_deg.value_or(hand.bend_first_deg);
    hand.bend_second_deg = command.bend_second_deg.value_or(hand.bend_second_deg);
    // A step of undo lasts from the start of a motion, or from rest, to the next start.
    const bool moves =
        command.insert_mm_s.value_or(0) != 0 || command.rotate_deg_s.value_or(0) != 0;
    if (!tissue().is_touched() && (moves || m_settled)) {
        end_step();
        end_strokes(client);
    }
    begin_step("catheter", client, kDrives);
    if (const Status s = catheter->drive(client, hand); !s.ok()) return refused(s.error());
    stir();
    return {};
}

// Tools.

Outcome Scene::slide(std::uint32_t client, const Push& push) {
    const TissueValues shown{m_iso_hu, m_polarity == Polarity::Rising};
    auto slid = tissue().slide(client, push, shown);
    if (!slid.ok()) return refused(slid.error());
    PushReport report;
    report.step_fraction = slid->way_fraction;
    report.limited_by = slid->limited_by;
    report.status = slid->way_fraction >= 1  ? PushStatus::Applied
                    : slid->way_fraction > 0 ? PushStatus::Limited
                                             : PushStatus::Rejected;
    report.moved_elements = slid->contacts;
    report.solve_ms = slid->slide_ms;
    report.message = std::move(slid->message);
    report.bone_mm = slid->bone_mm;
    Outcome outcome = outcome_of(std::move(report));
    outcome.end_mm = slid->end_mm;
    // The count is a number of moves, not of elements: it is in the message only.
    outcome.grabbed_elements.reset();
    return outcome;
}

Outcome Scene::act(std::uint32_t client, const PushCommand& command) {
    const TissueTraits traits = tissue().traits();
    if (command.slide && !traits.slides)
        return not_with(m_choice, "slide", "chainmail, elastic or a body");
    if (!traits.takes_pushes) return not_with(m_choice, "push", "chainmail, elastic or springs");
    const bool began = begin_step(command.slide ? "slide" : "push", client, command.stroke);
    const auto before = energy();
    Outcome outcome;
    if (command.slide) {
        outcome = slide(client, command.push);
    } else {
        auto report = tissue().push(client, command.push);
        outcome = report.ok() ? outcome_of(std::move(*report)) : refused(report.error());
    }
    tissue_changed();
    stir();
    if (outcome.ok())
        add_force(client, before, outcome.step_fraction * command.push.push_mm, outcome);
    // Nothing moves: there is nothing to undo.
    const bool is_empty = began && outcome.moved_elements.value_or(0) == 0 &&
                          (outcome.grabbed_elements.value_or(0) == 0 || !traits.moves_by_itself);
    if (command.stroke == 0 || is_empty) end_step();
    return outcome;
}

Outcome Scene::act(std::uint32_t client, const GrabCommand& command) {
    if (!tissue().traits().takes_pushes)
        return not_with(m_choice, "grab", "chainmail, elastic or springs");
    begin_step("drag", client, 0);
    auto report = tissue().grab(client, command.position, command.reach_mm);
    if (!report.ok()) {
        end_step();
        return refused(report.error());
    }
    m_drag_mm = {0, 0, 0};
    if (report->grabbed_elements > 0)
        m_holder = client;
    else
        end_step();
    return {.message = std::move(report->message),
            .grabbed_elements = report->grabbed_elements,
            .solve_ms = report->grab_ms};
}

Outcome Scene::act(std::uint32_t client, const DragCommand& command) {
    if (m_holder != client)
        return {.error_code = "not_holding", .message = "drag: expected a grab before it"};
    const auto before = energy();
    auto report = tissue().drag_to(command.offset_mm);
    tissue_changed();
    stir();
    if (!report.ok()) return refused(report.error());
    const Vec3d way = report->step_fraction * (command.offset_mm - m_drag_mm);
    m_drag_mm = m_drag_mm + way;
    Outcome outcome = outcome_of(std::move(*report));
    add_force(client, before, way, outcome);
    return outcome;
}

Outcome Scene::act(std::uint32_t client, const LetGoCommand&) {
    if (m_holder != client)
        return {.error_code = "not_holding", .message = "let_go: expected a grab before it"};
    m_unmeasured.reset();
    let_go();
    stir();
    return {};
}

Outcome Scene::act(std::uint32_t client, const CutCommand& command) {
    if (!tissue().traits().cuts)
        return not_with(m_choice, "cut", "chainmail, elastic, springs of a scan or a body");
    end_step();
    begin_step("cut", client, 0);
    const auto report = tissue().cut(command.surface);
    end_step();
    tissue_changed();
    stir();
    if (!report.ok()) return refused(report.error());
    return {.cut_links = report->cut_links, .solve_ms = report->cut_ms};
}

Outcome Scene::act(std::uint32_t client, const CarveCommand& command) {
    if (!tissue().traits().carves) return not_with(m_choice, "carve", "chainmail or elastic");
    const bool began = begin_step("carve", client, command.stroke);
    const auto report = tissue().carve(command.tool);
    tissue_changed();
    stir();
    const bool is_empty = began && !(report.ok() && report->carved_elements > 0);
    if (command.stroke == 0 || is_empty) end_step();
    if (!report.ok()) return refused(report.error());
    return {.carved_elements = report->carved_elements, .solve_ms = report->carve_ms};
}

Outcome Scene::act(std::uint32_t client, const ReleaseCommand&) {
    end_strokes(client);
    if (!has_contact(client)) return {};
    if (m_holder == client) let_go();
    m_unmeasured.reset();
    tissue().release(client);
    stir();
    return {};
}

Outcome Scene::act(std::uint32_t client, const EyeCommand& command) {
    if (const Status s = tissue().place_eye(client, command.position_mm, command.radius_mm);
        !s.ok())
        return refused(s.error());
    // Relaxation would discard the steps that can be redone.
    if (m_undone.empty()) stir();
    return {};
}

bool Scene::may_close_over(Vec3d position_mm, double radius_mm) const {
    const TissueTraits traits = tissue().traits();
    if (!traits.closes_at_rest) return false;
    if (traits.keeps_imprints) return true;
    const Volume& scan = m_loaded->volume;
    const TissueValues shown{m_iso_hu, m_polarity == Polarity::Rising};
    const auto is_tissue = [&](Vec3d position) {
        return shown.hold(sample_linear(scan, voxel_from_world(scan.grid, position)));
    };
    // Tests the centre and three spheres, towards the faces, edges and corners of a cube.
    for (int n = 0; n < 27; ++n) {
        const Vec3d towards{n % 3 - 1.0, n / 3 % 3 - 1.0, n / 9 - 1.0};
        const double length = std::max(norm(towards), 1.0);
        for (const double share : {1 / 3.0, 2 / 3.0, 1.0})
            if (is_tissue(position_mm + (share * radius_mm / length) * towards)) return true;
    }
    return false;
}

// The whole tissue.

Outcome Scene::act(std::uint32_t, const RelaxCommand& command) {
    if (!command.on && m_open && m_open->name() == "relax") end_step();
    m_relaxing = command.on;
    stir();
    return {};
}

Result<Sweep> Scene::sweep(const SweepLimit& limit) noexcept {
    const bool opens = !m_open;
    Result<Sweep> sweep = attempt([&]() -> Result<Sweep> {
        if (opens) begin_step("relax", 0, 0);
        measure_energy();
        return tissue().sweep_part(limit);
    });
    if (!sweep.ok()) {
        if (opens) end_step();  // the step is empty
        return sweep.error();
    }
    tissue_changed();
    const double spacing_mm = least_of(m_loaded->volume.grid.spacing_mm);
    m_settled = sweep->settled;
    if (!sweep->parts) m_is_still = sweep->largest_step_mm < kSeen * std::min(1.0, spacing_mm);
    m_trouble = std::move(sweep->message);  // no allocation in noexcept
    if (m_settled && m_open && m_open->name() == "relax") end_step();
    return sweep;
}

Outcome Scene::act(std::uint32_t client, const ResetCommand&) {
    end_step();
    begin_step("reset", client, 0);
    const Status reset = tissue().reset();
    if (!reset.ok()) return refused(reset.error());
    end_step();
    m_trouble.clear();
    tissue_changed();
    return {};
}

Outcome Scene::act(std::uint32_t client, const MaterialsCommand& command) {
    if (!has_setting(kMaterial)) return not_with(m_choice, "materials", "chainmail");
    end_step();
    ChainMailSettings changed;
    if (const Status s = apply(command.values, chainmail_material_rows(), changed); !s)
        return refused(s.error());
    begin_step("materials", client, 0);
    const Status status = tissue().configure(command.values);
    end_step();
    tissue_changed();
    stir();
    return status.ok() ? Outcome{} : refused(status.error());
}

/// Ends a step of this client or of relaxation. Steps of other clients stay open: the threshold
/// changes no tissue, so its step of undo precedes theirs.
Outcome Scene::act(std::uint32_t client, const IsoCommand& command) {
    std::list<Step> made(1);
    reserve_step();
    const Stroke stroke{"threshold", client, command.stroke};
    if (m_open && std::ranges::all_of(m_open->strokes, [&](const Stroke& part) {
            return part.client == client || part.client == 0;
        }))
        end_step();
    Step& step = made.front();
    step = {StepKind::Iso, m_iso_hu, m_polarity, {stroke}};
    m_iso_hu = command.iso_hu.value_or(m_iso_hu);
    m_polarity = command.polarity.value_or(m_polarity);
    if (m_iso_hu == step.iso_hu && m_polarity == step.polarity) return {};
    const bool goes_on = command.stroke != 0 && !m_done.empty() &&
                         m_done.back().strokes == step.strokes && m_undone.empty();
    if (!goes_on) keep(made);
    return {};
}

}  // namespace pliant::serve
