// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "serve/scene.h"

#include <pliant/chainmail_slide.h>

#include <algorithm>
#include <utility>

#include "scene/chainmail_tissue.h"
#include "scene/spring_tissue.h"
#include "serve/vessel_tissue.h"

namespace pliant::serve {
namespace {

/// As if all that is driven without a pause were one stroke.
constexpr std::uint32_t kDrives = 1;

Outcome refused(const Error& error) {
    const char* code = error.code == ErrorCode::LimitExceeded ? "limit"
                       : error.code == ErrorCode::NotFound    ? "nothing"
                                                              : "out_of_range";
    return {.error_code = code, .message = error.message};
}

Outcome outcome_of(const PushReport& report) {
    return {.message = report.message,
            .status = report.status,
            .limited_by = report.limited_by,
            .step_fraction = report.step_fraction,
            .grabbed_elements = report.grabbed_elements,
            .moved_elements = report.moved_elements,
            .solve_ms = report.solve_ms};
}

Outcome not_with(const TissueChoice& choice, const char* what, const char* expected) {
    return {.error_code = "other_tissue",
            .message = std::string(what) + ": expected the tissue " + expected + ", found " +
                       name_of(choice)};
}

/// Where the control lattice lies: around its centre, but in the scan.
Box3i region_of(const TissueChoice& choice, const Grid& grid) {
    const Vec3d centre = voxel_from_world(grid, choice.centre_mm);
    Box3i region;
    for (int a = 0; a < 3; ++a) {
        const int cell = std::max(1, int(std::lround(choice.cell_mm / grid.spacing_mm[a])));
        const int last = grid.size[a] - 1;
        const int length = std::min(last, cell * (choice.nodes - 1));
        const double low = std::clamp(centre[a] - 0.5 * length, 0.0, double(last - length));
        region.begin[a] = int(std::lround(low));
        region.end[a] = region.begin[a] + length + 1;
    }
    return region;
}

Result<std::unique_ptr<Tissue>> make_tissue(const TissueChoice& choice, const LoadedScan& loaded,
                                            const TaskArena& arena) {
    if (choice.vessel) {
        if (!loaded.vessel)
            return Error{ErrorCode::InvalidArgument,
                         "tissue: model: expected chainmail or springs in a scene without a "
                         "vessel, found vessel"};
        auto model = VesselTissue::create(*loaded.vessel, loaded.volume, arena);
        if (!model.ok()) return model.error();
        return std::unique_ptr<Tissue>(std::move(*model));
    }
    if (!choice.springs) {
        auto model = ChainMail::create(loaded.volume, loaded.settings, arena);
        if (!model.ok()) return model.error();
        return std::unique_ptr<Tissue>(new ChainMailTissue(std::move(*model)));
    }
    const SpringDeformationSettings settings{.region = region_of(choice, loaded.volume.grid),
                                             .cell_mm = choice.cell_mm,
                                             .young_modulus_pa = choice.young_modulus_pa,
                                             .fixed_above_hu = choice.fixed_hu,
                                             .depth = choice.depth};
    auto model = SpringDeformation::create(loaded.volume, settings, arena);
    if (!model.ok()) return model.error();
    return std::unique_ptr<Tissue>(new SpringScanTissue(std::move(*model)));
}

}  // namespace

Result<std::unique_ptr<Scene>> Scene::open(const SceneSource& source, const TaskArena& arena,
                                           const TaskArena& loading) {
    auto loaded = load_scan(source, loading);
    if (!loaded.ok()) return loaded.error();
    // The lattice keeps a reference to the volume, so both are made where they stay.
    auto place = std::make_shared<LoadedScan>(std::move(*loaded));
    const TissueChoice choice{.vessel = place->vessel != nullptr};
    auto tissue = make_tissue(choice, *place, arena);
    if (!tissue.ok()) return tissue.error();
    return std::unique_ptr<Scene>(new Scene(std::move(place), choice, std::move(*tissue)));
}

Scene::Scene(std::shared_ptr<LoadedScan> loaded, const TissueChoice& choice,
             std::unique_ptr<Tissue> tissue)
    : m_loaded(std::move(loaded)),
      m_tissue(std::move(tissue)),
      m_choice(choice),
      m_shown(m_tissue),
      m_live(m_shown),
      m_iso_hu(m_loaded->iso_hu),
      m_polarity(m_loaded->polarity),
      m_relaxing(choice.vessel) {}

const VesselTissue* Scene::vessel() const {
    return m_choice.vessel ? static_cast<const VesselTissue*>(m_tissue.get()) : nullptr;
}

Outcome Scene::carry_out(std::uint32_t client, const Action& action) {
    m_last_client = std::max(m_last_client, client);
    return std::visit([&](const auto& command) { return act(client, command); }, action);
}

bool Scene::has_contact(std::uint32_t client) const {
    return m_holder == client || m_tissue->is_touched_by(client);
}

LiveUpdate Scene::update() {
    LiveUpdate update = m_live.update();
    if (m_pending.empty()) return update;
    m_boxes = std::exchange(m_pending, {});
    m_boxes.insert(m_boxes.end(), update.boxes.begin(), update.boxes.end());
    update.boxes = m_boxes;
    return update;
}

Status Scene::choose(const TissueChoice& choice) {
    auto made = make_tissue(choice, *m_loaded, m_tissue->arena());
    if (!made.ok()) return made.error();
    end_step();
    // What was done can't be done to this one. The old one stays until the voxels are back.
    const std::unique_ptr<Tissue> old = std::exchange(m_tissue, std::move(*made));
    const LiveUpdate update = m_live.update();
    m_pending.insert(m_pending.end(), update.boxes.begin(), update.boxes.end());
    m_choice = choice;
    m_done.clear();
    m_undone.clear();
    m_unreachable = 0;
    m_relaxing = choice.springs || choice.vessel;
    m_settled = true;
    tissue_changed();
    return Ok{};
}

// Steps of undo.

void Scene::begin_step(const std::string& name, std::uint32_t client, std::uint32_t stroke) {
    const bool goes_on = m_open && stroke != 0 && m_open->name == name &&
                         m_open->client == client && m_open->stroke == stroke;
    if (goes_on) return;
    end_step();
    m_open = OpenStep{name, client, stroke, m_tissue->undo_steps()};
    m_tissue->begin_group(name);
}

void Scene::end_step() {
    if (!m_open) return;
    m_tissue->let_go();
    m_holder = 0;
    const OpenStep open = *std::exchange(m_open, {});
    const int forgotten = m_tissue->end_group();
    if (forgotten < 0) {
        // Too large to be kept, and nothing before it can be reached any more.
        m_done.clear();
        m_undone.clear();
        m_unreachable = 0;
        return;
    }
    if (m_tissue->undo_steps() + forgotten > open.undo_steps_before)
        keep({.kind = StepKind::Tissue, .name = open.name});
    forget(forgotten);
}

void Scene::keep(Step step) {
    m_undone.clear();
    step.number = ++m_steps;
    m_done.push_back(std::move(step));
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

SceneMemo Scene::rest() {
    end_step();
    for (auto* steps : {&m_done, &m_undone})
        for (Step& step : *steps) step.stroke = 0;
    m_tissue->rest();
    return {m_iso_hu, m_polarity, m_relaxing, m_settled, m_last_client, m_steps, m_choice};
}

Status Scene::restore(const std::filesystem::path& state, const SceneMemo& memo) {
    if (memo.tissue != m_choice)
        if (const Status s = choose(memo.tissue); !s.ok()) return s;
    if (const Status s = m_tissue->load_state(state); !s.ok()) return s;
    m_iso_hu = memo.iso_hu;
    m_polarity = memo.polarity;
    m_relaxing = memo.relaxing;
    m_settled = memo.settled;
    m_last_client = memo.last_client;
    m_steps = memo.steps;
    return Ok{};
}

void Scene::forget_steps(std::int64_t count) {
    const auto is_old = [&](const Step& step) { return step.number <= count; };
    for (const Step& step : m_done)
        if (is_old(step) && step.kind == StepKind::Tissue) ++m_unreachable;
    std::erase_if(m_done, is_old);
    std::erase_if(m_undone, is_old);
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
    else if (const Status s = m_tissue->undo(); !s.ok())
        return refused(s.error());
    m_undone.push_back(std::move(m_done.back()));
    m_done.pop_back();
    // Relaxation would take the place of what could be done again.
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
    else if (const Status s = m_tissue->redo(); !s.ok())
        return refused(s.error());
    m_done.push_back(std::move(m_undone.back()));
    m_undone.pop_back();
    m_settled = true;
    tissue_changed();
    return {.message = m_done.back().name};
}

Outcome Scene::act(std::uint32_t, const TissueCommand& command) {
    TissueChoice choice = command.choice;
    const Grid& grid = m_loaded->volume.grid;
    if (choice.springs && !command.is_centred) {
        const Vec3i last = grid.size - Vec3i{1, 1, 1};
        choice.centre_mm = world_from_voxel(grid, {0.5 * last.x, 0.5 * last.y, 0.5 * last.z});
    }
    const Status status = choose(choice);
    return status.ok() ? Outcome{} : refused(status.error());
}

Outcome Scene::act(std::uint32_t, const DepthCommand& command) {
    SpringDeformation* springs = m_tissue->springs();
    if (!springs) return not_with(m_choice, "depth", "springs");
    if (const Status s = springs->set_depth(command.layers); !s.ok()) return refused(s.error());
    m_choice.depth = command.layers;
    m_settled = false;
    return {};
}

Outcome Scene::act(std::uint32_t client, const DriveCommand& command) {
    if (!m_choice.vessel) return not_with(m_choice, "catheter", "vessel");
    auto& vessel = static_cast<VesselTissue&>(*m_tissue);
    // A step of undo: from a hand that begins to move, or from rest, until the next one does.
    const bool moves =
        command.insert_mm_s.value_or(0) != 0 || command.rotate_deg_s.value_or(0) != 0;
    if (!vessel.is_touched() && (moves || m_settled)) end_step();
    begin_step("catheter", client, kDrives);
    if (const Status s = vessel.drive(client, command); !s.ok()) return refused(s.error());
    m_settled = false;
    return {};
}

// Tools.

Result<PushReport> Scene::slide(std::uint32_t client, const Push& push) {
    auto& tissue = static_cast<ChainMailTissue&>(*m_tissue);
    const auto slid = slide_sphere(*tissue.chainmail(), push);
    if (!slid.ok()) return slid.error();
    PushReport report;
    report.step_fraction = slid->way_fraction;
    report.limited_by = slid->limited_by;
    report.status = slid->way_fraction >= 1  ? PushStatus::Applied
                    : slid->way_fraction > 0 ? PushStatus::Limited
                                             : PushStatus::Rejected;
    report.moved_elements = slid->contacts;
    report.solve_ms = slid->slide_ms;
    const Vec3d end = push.point_mm + slid->way_fraction * push.push_mm;
    tissue.lay(client, end, push.sphere_radius_mm);
    return report;
}

Outcome Scene::act(std::uint32_t client, const PushCommand& command) {
    if (command.slide && !m_tissue->chainmail()) return not_with(m_choice, "slide", "chainmail");
    if (m_choice.vessel) return not_with(m_choice, "push", "chainmail or springs");
    begin_step(command.slide ? "slide" : "push", client, command.stroke);
    const auto before = energy();
    const auto report =
        command.slide ? slide(client, command.push) : m_tissue->push(client, command.push);
    tissue_changed();
    m_settled = false;
    Outcome outcome = report.ok() ? outcome_of(*report) : refused(report.error());
    if (report.ok())
        add_force(client, before, report->step_fraction * command.push.push_mm, outcome);
    // Moves are not elements: a slide's number is told in its message only.
    if (command.slide) outcome.grabbed_elements.reset();
    if (command.stroke == 0) end_step();
    return outcome;
}

Outcome Scene::act(std::uint32_t client, const GrabCommand& command) {
    if (m_holder && m_holder != client)
        return {.error_code = "held_by_other",
                .message = "grab: expected nobody else to hold tissue, found client " +
                           std::to_string(m_holder)};
    if (m_choice.vessel) return not_with(m_choice, "grab", "chainmail or springs");
    begin_step("drag", client, 0);
    const auto report = m_tissue->grab(client, command.place, command.reach_mm);
    if (!report.ok()) {
        end_step();
        return refused(report.error());
    }
    m_drag_mm = {0, 0, 0};
    if (report->grabbed_elements > 0)
        m_holder = client;
    else
        end_step();
    return {.message = report->message,
            .grabbed_elements = report->grabbed_elements,
            .solve_ms = report->pick_ms};
}

Outcome Scene::act(std::uint32_t client, const DragCommand& command) {
    if (m_holder != client)
        return {.error_code = "not_holding", .message = "drag: expected a grab before it"};
    const auto before = energy();
    const auto report = m_tissue->drag_to(command.offset_mm);
    tissue_changed();
    m_settled = false;
    if (!report.ok()) return refused(report.error());
    const Vec3d way = report->step_fraction * (command.offset_mm - m_drag_mm);
    m_drag_mm = m_drag_mm + way;
    Outcome outcome = outcome_of(*report);
    add_force(client, before, way, outcome);
    return outcome;
}

Outcome Scene::act(std::uint32_t client, const LetGoCommand&) {
    if (m_holder != client)
        return {.error_code = "not_holding", .message = "let_go: expected a grab before it"};
    m_unmeasured.reset();
    end_step();
    m_settled = false;
    return {};
}

Outcome Scene::act(std::uint32_t, const CutCommand& command) {
    ChainMail* model = m_tissue->chainmail();
    if (!model) return not_with(m_choice, "cut", "chainmail");
    end_step();
    begin_step("cut", 0, 0);
    const auto report = model->cut(command.surface);
    end_step();
    tissue_changed();
    m_settled = false;
    if (!report.ok()) return refused(report.error());
    return {.cut_links = report->cut_links, .solve_ms = report->cut_ms};
}

Outcome Scene::act(std::uint32_t client, const CarveCommand& command) {
    ChainMail* model = m_tissue->chainmail();
    if (!model) return not_with(m_choice, "carve", "chainmail");
    begin_step("carve", client, command.stroke);
    const auto report = model->carve(command.tool);
    tissue_changed();
    m_settled = false;
    if (command.stroke == 0) end_step();
    if (!report.ok()) return refused(report.error());
    return {.carved_elements = report->carved_elements, .solve_ms = report->carve_ms};
}

Outcome Scene::act(std::uint32_t client, const ReleaseCommand&) {
    if (!has_contact(client)) return {};
    if (m_holder == client) end_step();
    m_unmeasured.reset();
    m_tissue->release(client);
    m_settled = false;
    return {};
}

// The whole tissue.

Outcome Scene::act(std::uint32_t, const RelaxCommand& command) {
    if (!command.on && m_open && m_open->name == "relax") end_step();
    m_relaxing = command.on;
    m_settled = false;
    return {};
}

double Scene::sweep() {
    if (!m_open) begin_step("relax", 0, 0);
    measure_energy();
    const Sweep sweep = m_tissue->sweep();
    tissue_changed();
    m_settled = sweep.settled;
    if (m_settled && m_open && m_open->name == "relax") end_step();
    return sweep.ms;
}

Outcome Scene::act(std::uint32_t, const ResetCommand&) {
    end_step();
    begin_step("reset", 0, 0);
    m_tissue->reset();
    end_step();
    tissue_changed();
    return {};
}

Outcome Scene::act(std::uint32_t, const MaterialsCommand& command) {
    ChainMail* model = m_tissue->chainmail();
    if (!model) return not_with(m_choice, "materials", "chainmail");
    end_step();
    ChainMailSettings changed = model->settings();
    const auto set = [](auto& field, const auto& value) {
        if (value) field = *value;
    };
    set(changed.offset, command.offset);
    set(changed.max_movement_mm, command.max_movement_mm);
    set(changed.bone_threshold_hu, command.bone_threshold_hu);
    set(changed.air_threshold_hu, command.air_threshold_hu);
    set(changed.yield, command.yield);
    set(changed.air_enabled, command.air_enabled);
    if (command.rounded) changed.limits = *command.rounded ? LinkLimits::Rounded : LinkLimits::Box;
    begin_step("materials", 0, 0);
    const Status status = model->set_materials(changed);
    end_step();
    tissue_changed();
    m_settled = false;
    return status.ok() ? Outcome{} : refused(status.error());
}

Outcome Scene::act(std::uint32_t client, const IsoCommand& command) {
    end_step();
    Step step{StepKind::Iso, "threshold", m_iso_hu, m_polarity, client, command.stroke};
    m_iso_hu = command.iso_hu.value_or(m_iso_hu);
    m_polarity = command.polarity.value_or(m_polarity);
    if (m_iso_hu == step.iso_hu && m_polarity == step.polarity) return {};
    const bool goes_on = command.stroke != 0 && !m_done.empty() &&
                         m_done.back().kind == StepKind::Iso && m_done.back().client == client &&
                         m_done.back().stroke == command.stroke && m_undone.empty();
    if (!goes_on) keep(std::move(step));
    return {};
}

void Scene::describe(SharedState& state) const {
    state.iso_hu = m_iso_hu;
    state.polarity = m_polarity;
    const ChainMail* chainmail = m_tissue->chainmail();
    state.materials = chainmail ? chainmail->settings() : m_loaded->settings;
    state.tissue = m_choice;
    if (const auto* springs = dynamic_cast<const SpringScanTissue*>(m_tissue.get())) {
        state.spring_nodes = springs->control_nodes();
        state.active_nodes = springs->active_nodes();
    }
    if (const VesselTissue* v = vessel())
        state.vessel = VesselState{.hand = v->hand(),
                                   .measures = v->measures(),
                                   .wall_moved_mm = v->view().wall_moved_mm,
                                   .radius_mm = v->vessel().settings.catheter.radius_mm,
                                   .length_mm = v->vessel().settings.catheter.length_mm,
                                   .failure = v->failure()};
    state.has_vessel = m_loaded->vessel != nullptr;
    state.relaxing = m_relaxing;
    state.settled = !wants_sweep();
    state.holder = m_holder;
    state.undo_steps = int(m_done.size()) + (m_open ? 1 : 0);
    state.redo_steps = m_open ? 0 : int(m_undone.size());
    state.next_undo = m_open ? m_open->name : m_done.empty() ? "" : m_done.back().name;
    state.next_redo = state.redo_steps == 0 ? "" : m_undone.back().name;
}

// Forces.

std::optional<double> Scene::energy() {
    // Computing it twice for one command would hold up everybody where much is deformed. There the
    // energy after a command is kept, and the next command has a force.
    constexpr std::int64_t kFew = 100'000;
    const ChainMail* model = m_tissue->chainmail();
    if (!model || m_energy_rests > 0) return {};
    if (!m_energy && m_energy_elements < kFew) m_energy = model->elastic_energy_mm2();
    return m_energy;
}

void Scene::add_force(std::uint32_t client, std::optional<double> before, Vec3d way_mm,
                      Outcome& outcome) {
    outcome.force = m_tissue->force_n(client);
    if (!m_tissue->chainmail() || !(norm(way_mm) > 0)) return;
    if (m_energy_rests > 0)
        --m_energy_rests;
    else
        m_unmeasured = {client, before, way_mm};
}

void Scene::measure_energy() {
    // About a twentieth of the time at most: where much is deformed, forces are told less often.
    constexpr std::int64_t kElementsPerRest = 15'000;
    if (!m_unmeasured) return;
    const auto [client, before, way_mm] = *std::exchange(m_unmeasured, {});
    const ChainMail& model = *m_tissue->chainmail();
    m_energy = model.elastic_energy_mm2();
    const Box3i moved = model.moved_box();
    const Vec3i size = moved.end - moved.begin;
    m_energy_elements = std::int64_t(size.x) * size.y * size.z;
    if (!before) return;
    m_energy_rests = m_energy_elements / kElementsPerRest;
    const double way = norm(way_mm);
    m_felt = {client, (-(*m_energy - *before) / (way * way)) * way_mm};
}

std::optional<FeltForce> Scene::measure_force() {
    measure_energy();
    return std::exchange(m_felt, {});
}

void Scene::tissue_changed() {
    m_energy.reset();
    m_unmeasured.reset();
}

}  // namespace pliant::serve
