// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "serve/scene.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "core/errors.h"
#include "scene/chainmail_tissue.h"
#include "scene/spring_tissue.h"
#include "serve/guarded.h"
#include "serve/outcomes.h"
#include "serve/vessel_tissue.h"

namespace pliant::serve {
namespace {

/// Region of the control lattice: around its centre, clamped to the scan.
Box3i region_of(const TissueChoice& choice, const Grid& grid) {
    const Vec3d centre = voxel_from_world(grid, choice.centre_mm);
    Box3i region;
    for (int a = 0; a < 3; ++a) {
        const int cell = std::max(1, int(std::lround(choice.springs.cell_mm / grid.spacing_mm[a])));
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
    if (choice.model == TissueModel::Vessel) {
        if (!loaded.vessel)
            return Error{ErrorCode::InvalidArgument,
                         "tissue: model: expected chainmail or springs in a scene without a "
                         "vessel, found vessel"};
        auto model = VesselTissue::create(*loaded.vessel, loaded.volume, arena);
        if (!model.ok()) return model.error();
        return std::unique_ptr<Tissue>(std::move(*model));
    }
    if (choice.model == TissueModel::ChainMail) {
        auto model = ChainMail::create(loaded.volume, loaded.settings, arena);
        if (!model.ok()) return model.error();
        return std::unique_ptr<Tissue>(new ChainMailTissue(std::move(*model)));
    }
    SpringDeformationSettings settings = choice.springs;
    settings.region = region_of(choice, loaded.volume.grid);
    auto model = SpringDeformation::create(loaded.volume, settings, arena);
    if (!model.ok()) return model.error();
    return std::unique_ptr<Tissue>(new SpringScanTissue(std::move(*model)));
}

}  // namespace

Result<std::unique_ptr<Scene>> Scene::open(const SceneSource& source, const TaskArena& arena,
                                           const TaskArena& loading,
                                           const std::function<bool()>& give_up) noexcept {
    return attempt([&] { return load(source, arena, loading, give_up); });
}

Result<std::unique_ptr<Scene>> Scene::load(const SceneSource& source, const TaskArena& arena,
                                           const TaskArena& loading,
                                           const std::function<bool()>& give_up) {
    auto loaded = load_scan(source, loading, give_up);
    if (!loaded.ok()) return loaded.error();
    // The lattice keeps a reference to the volume, so both are made at their final address.
    auto place = std::make_shared<LoadedScan>(std::move(*loaded));
    const TissueChoice choice{.model =
                                  place->vessel ? TissueModel::Vessel : TissueModel::ChainMail};
    auto tissue = make_tissue(choice, *place, arena);
    if (!tissue.ok()) return tissue.error();
    std::unique_ptr<Scene> scene(new Scene(std::move(place), choice, std::move(*tissue)));
    auto live = LiveDeformation::create(scene->m_shown);
    if (!live.ok()) return live.error();
    scene->m_live.emplace(std::move(*live));
    return scene;
}

Scene::Scene(std::shared_ptr<LoadedScan> loaded, const TissueChoice& choice,
             std::unique_ptr<Tissue> tissue)
    : m_loaded(std::move(loaded)),
      m_tissue(std::move(tissue)),
      m_choice(choice),
      m_shown(m_tissue),
      m_iso_hu(m_loaded->iso_hu),
      m_polarity(m_loaded->polarity),
      m_relaxing(choice.model == TissueModel::Vessel) {}

const VesselTissue* Scene::vessel() const {
    return m_choice.model == TissueModel::Vessel ? static_cast<const VesselTissue*>(m_tissue.get())
                                                 : nullptr;
}

Outcome Scene::carry_out(std::uint32_t client, const Action& action) noexcept {
    const std::int64_t changes = m_changes;
    const std::uint32_t last_client = m_last_client;
    const bool settled = m_settled;
    m_last_client = std::max(m_last_client, client);
    Outcome outcome;
    try {
        outcome = std::visit([&](const auto& command) { return act(client, command); }, action);
    } catch (const std::bad_alloc&) {
        outcome = {.error_code = "limit", .message = "out of memory", .ran_out = true};
    } catch (const std::length_error&) {  // thrown by a container beyond its size limit
        outcome = {.error_code = "limit", .message = "out of memory", .ran_out = true};
    } catch (const std::exception& error) {
        print_fault("owner", error.what());
        outcome = {.error_code = "fault", .message = {}, .ran_out = true};
    }
    if (!outcome.ran_out) return outcome;
    // The tissue is unchanged. Steps may have ended, or begun without content.
    m_settled = settled;
    m_last_client = last_client;
    if (m_changes == changes) return outcome;
    interrupt(client);
    outcome.ended_step = true;
    return outcome;
}

void Scene::interrupt(std::uint32_t client) noexcept {
    m_last_client = std::max(m_last_client, client);
    end_step();
    m_settled = false;
}

bool Scene::has_contact(std::uint32_t client) const {
    return m_holder == client || m_tissue->is_touched_by(client);
}

Status Scene::choose(const TissueChoice& choice) {
    auto made = make_tissue(choice, *m_loaded, m_tissue->arena());
    if (!made.ok()) return made.error();
    end_step();
    // The old steps don't apply to the new tissue.
    m_live->start_over();
    m_tissue = std::move(*made);
    m_choice = choice;
    m_done.clear();
    m_undone.clear();
    m_unreachable = 0;
    m_relaxing = choice.model != TissueModel::ChainMail;
    m_settled = true;
    tissue_changed();
    return Ok{};
}

Outcome Scene::act(std::uint32_t, const TissueCommand& command) {
    TissueChoice choice = command.choice;
    const Grid& grid = m_loaded->volume.grid;
    if (choice.model == TissueModel::Springs && !command.is_centred) {
        const Vec3i last = grid.size - Vec3i{1, 1, 1};
        choice.centre_mm = world_from_voxel(grid, {0.5 * last.x, 0.5 * last.y, 0.5 * last.z});
    }
    const Status status = choose(choice);
    return status.ok() ? Outcome{} : refused(status.error());
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
    if (state.vessel) state.vessel->measures.inverted = vessel()->view().inverted;
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
    // Two computations per command would delay all clients if much is deformed. Then the
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

void Scene::measure_energy() noexcept try {
    // Uses at most 5 % of the time: forces are less frequent if much is deformed.
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
} catch (const std::bad_alloc&) {  // no force is reported
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
