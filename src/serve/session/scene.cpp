// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/scene.h"

#include <pliant/models/drivable.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <new>
#include <type_traits>
#include <utility>

#include "base/errors.h"
#include "protocol/limits.h"
#include "session/guarded.h"
#include "session/outcomes.h"
#include "volume/boxes.h"

namespace pliant::serve {
namespace {

template <class T, class... Ts>
inline constexpr bool is_any = (std::is_same_v<T, Ts> || ...);

Vec3d middle_of(const Grid& grid) {
    const Vec3i last = grid.size - Vec3i{1, 1, 1};
    return world_from_voxel(grid, {0.5 * last.x, 0.5 * last.y, 0.5 * last.z});
}

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

Result<std::unique_ptr<Tissue>> make_springs_of(const TissueChoice& choice,
                                                const LoadedScan& loaded, const TaskArena& arena) {
    SpringDeformationSettings settings;
    settings.fixed_hu = loaded.info.values.bone_threshold;
    settings.air_threshold_hu = loaded.info.values.air_threshold;
    if (const Status s = take_materials(loaded.settings, settings); !s.ok()) return s.error();
    for (const Setting<SpringDeformationSettings>& row : spring_rows())
        if (!follows_scan(choice, row.name)) row.set(settings, value_of(choice.springs, row));
    settings.region = region_of(choice, loaded.volume.grid);
    return make_springs(loaded.volume, settings, arena);
}

/// Settings of the scene's elastic scan, with those that are given.
Result<ElasticScanSettings> elastic_of(const TissueChoice& choice, const LoadedScan& loaded) {
    ElasticScanSettings settings = loaded.elastic;
    if (const Status s = take_materials(loaded.settings, settings); !s.ok()) return s.error();
    if (const Status s = apply(choice.elastic, elastic_scan_rows(), settings); !s.ok())
        return s.error();
    return settings;
}

Result<std::unique_ptr<Tissue>> make_elastic_of(const TissueChoice& choice,
                                                const LoadedScan& loaded, const TaskArena& arena) {
    const auto settings = elastic_of(choice, loaded);
    if (!settings.ok()) return settings.error();
    return make_elastic(loaded.volume, *settings, arena);
}

Result<std::unique_ptr<Tissue>> make_tissue(const TissueChoice& choice, const LoadedScan& loaded,
                                            const TaskArena& arena) {
    if (choice.model == "chainmail") return make_chainmail(loaded.volume, loaded.settings, arena);
    if (choice.is_springs()) return make_springs_of(choice, loaded, arena);
    if (choice.is_elastic()) return make_elastic_of(choice, loaded, arena);
    const auto own = loaded.own_tissues.find(choice.model);
    if (own == loaded.own_tissues.end()) {
        std::string expected = "chainmail, springs, elastic";
        for (const auto& [model, make] : loaded.own_tissues) expected += ", " + model;
        return expected_error("tissue: model", expected, choice.model);
    }
    auto made = own->second(loaded.volume, arena);
    const Drivable* const driven = made.ok() ? (*made)->drivable() : nullptr;
    if (!driven || driven->wall().nodes_mm.size() <= kMaxSurfaceNodes) return made;
    return Error{ErrorCode::LimitExceeded,
                 loaded.info.name + ": expected a vessel whose inner surface has up to " +
                     std::to_string(kMaxSurfaceNodes) + " nodes, found " +
                     std::to_string(driven->wall().nodes_mm.size())};
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
    auto scan = std::make_shared<LoadedScan>(std::move(*loaded));
    FirstModel first{source.model, {}};
    if (source.model == kChosenModel)
        first = scan->own_tissues.empty() ? choose_model(*scan, arena, give_up) : FirstModel{};
    TissueChoice choice;
    if (!first.model.empty())
        choice.model = first.model;
    else if (!scan->own_tissues.empty())
        choice.model = scan->own_tissues.rbegin()->first;
    if (choice.is_springs()) choice.centre_mm = middle_of(scan->volume.grid);
    auto tissue = make_tissue(choice, *scan, arena);
    if (!tissue.ok()) return tissue.error();
    std::unique_ptr<Scene> scene(
        new Scene(std::move(first), std::move(scan), choice, std::move(*tissue)));
    auto live = LiveDeformation::create(*scene->m_tissue);
    if (!live.ok()) return live.error();
    scene->m_live.emplace(std::move(*live));
    return scene;
}

Scene::Scene(FirstModel first_model, std::shared_ptr<LoadedScan> loaded, const TissueChoice& choice,
             std::unique_ptr<Tissue> tissue)
    : m_first_model(std::move(first_model)),
      m_loaded(std::move(loaded)),
      m_tissue(std::move(tissue)),
      m_choice(choice),
      m_iso_hu(m_loaded->iso_hu),
      m_polarity(m_loaded->polarity),
      m_relaxing(this->tissue().traits().moves_by_itself) {}

Outcome Scene::carry_out(std::uint32_t client, const Action& action) {
    m_last_client = std::max(m_last_client, client);
    Outcome outcome;
    const auto work = [&](const auto& command) { outcome = act(client, command); };
    const auto carried_out = guarded("owner", [&] {
        if (auto refusal = held_from(client, action))
            outcome = std::move(*refusal);
        else
            std::visit(work, action);
    });
    if (carried_out) return outcome;
    interrupt(client);  // the tissue is unchanged, but a step may have begun or ended
    throw std::bad_alloc();
}

std::optional<Outcome> Scene::held_from(std::uint32_t client, const Action& action) const {
    if (m_holder == 0 || m_holder == client) return {};
    const bool moves_tissue = std::visit(
        []<class T>(const T&) {
            return is_any<T, PushCommand, GrabCommand, CutCommand, CarveCommand, ResetCommand,
                          MaterialsCommand, UndoCommand, RedoCommand, TissueCommand, DriveCommand>;
        },
        action);
    if (!moves_tissue) return {};
    return Outcome{
        .error_code = "held_by_other",
        .message = "expected free tissue, found it held by client " + std::to_string(m_holder)};
}

void Scene::interrupt(std::uint32_t client) noexcept {
    m_last_client = std::max(m_last_client, client);
    end_step();
    stir();
}

bool Scene::has_contact(std::uint32_t client) const {
    return m_holder == client || tissue().is_touched_by(client);
}

Status Scene::choose(const TissueChoice& choice, const std::filesystem::path& state) {
    auto made = make_tissue(choice, *m_loaded, tissue().arena());
    if (!made.ok()) return made.error();
    if (!state.empty())
        if (const Status s = (*made)->load_state(state); !s.ok()) return s;
    TissueChoice kept = choice;
    // Nothing fails from here on.
    end_step();
    // The old steps don't apply to the new tissue.
    m_live->start_over(**made);
    m_tissue = std::move(*made);
    m_choice = std::move(kept);
    m_done.clear();
    m_undone.clear();
    m_unreachable = 0;
    m_relaxing = tissue().traits().moves_by_itself;
    m_settled = true;
    m_trouble.clear();
    tissue_changed();
    return Ok{};
}

Outcome Scene::act(std::uint32_t, const TissueCommand& command) {
    TissueChoice choice = command.choice;
    if (choice.is_springs() && !command.is_centred)
        choice.centre_mm = middle_of(m_loaded->volume.grid);
    const Status status = choose(choice);
    return status.ok() ? Outcome{} : refused(status.error());
}

bool Scene::has_setting(std::string_view name) const {
    const Record settings = tissue().settings();
    return std::any_of(settings.begin(), settings.end(),
                       [&](const NamedValue& setting) { return setting.name == name; });
}

void Scene::describe(SharedState& state) const {
    state.iso_hu = m_iso_hu;
    state.polarity = m_polarity;
    state.materials = m_loaded->settings;
    state.tissue = m_choice;
    if (m_choice.is_elastic())
        if (auto settings = elastic_of(m_choice, *m_loaded); settings.ok())
            state.elastic = std::move(*settings);
    if (has_setting(kMaterial))
        (void)apply(tissue().settings(), chainmail_material_rows(), state.materials);
    state.figures = tissue().figures();
    state.trouble = m_trouble;
    if (const Drivable* driven = tissue().drivable()) {
        state.vessel = VesselState{.hand = driven->hand(),
                                   .measures = driven->measures(),
                                   .radius_mm = driven->radius_mm(),
                                   .length_mm = driven->length_mm(),
                                   .failure = driven->failure()};
        const CatheterView& view = driven->view();
        state.vessel->measures.wall_moved_mm = view.wall_moved_mm;
        state.vessel->measures.inverted = view.inverted;
    }
    for (const auto& [model, make] : m_loaded->own_tissues) state.own_models.push_back(model);
    state.traits = tissue().traits();
    state.relaxing = m_relaxing;
    state.settled = !wants_sweep() || m_is_still;
    state.holder = m_holder;
    state.undo_steps = int(m_done.size()) + (m_open ? 1 - m_open->joined : 0);
    state.redo_steps = m_open ? 0 : int(m_undone.size());
    state.next_undo = m_open ? m_open->name() : m_done.empty() ? "" : m_done.back().name();
    state.next_redo = state.redo_steps == 0 ? "" : m_undone.back().name();
}

// Forces.

std::optional<double> Scene::energy() {
    // Two computations per command would delay all clients if much is deformed. Then the
    // energy after a command is kept, and the next command has a force.
    constexpr std::int64_t kFew = 100'000;
    if (m_energy_rests > 0) return {};
    if (!m_energy && m_energy_elements < kFew) m_energy = tissue().energy_mm2();
    return m_energy;
}

void Scene::add_force(std::uint32_t client, std::optional<double> before, Vec3d way_mm,
                      Outcome& outcome) {
    outcome.force_n = tissue().force_n(client);
    if (!tissue().traits().has_energy || !(norm(way_mm) > 0)) return;
    if (m_energy_rests > 0)
        --m_energy_rests;
    else
        m_unmeasured = {client, before, way_mm};
}

void Scene::measure_energy() noexcept {
    // At most about a twentieth of the time: forces are reported less often if much is deformed.
    constexpr std::int64_t kElementsPerRest = 15'000;
    if (!m_unmeasured) return;
    const auto [client, before, way_mm] = *std::exchange(m_unmeasured, {});
    m_energy = tissue().energy_mm2();
    if (!m_energy) return;  // forces are disabled
    const Box3i moved = tissue().deformation().moved_box();
    m_energy_elements = box_count(moved);
    if (!before) return;
    m_energy_rests = m_energy_elements / kElementsPerRest;
    const double way = norm(way_mm);
    m_felt = {client, (-(*m_energy - *before) / (way * way)) * way_mm};
}

std::optional<FeltEnergy> Scene::measure_force() {
    measure_energy();
    return std::exchange(m_felt, {});
}

void Scene::tissue_changed() {
    m_energy.reset();
    m_unmeasured.reset();
}

}  // namespace pliant::serve
