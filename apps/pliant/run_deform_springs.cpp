// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant deform --model springs`: each push is a tool that grabs control nodes and stays; then
// time advances until the tissue is at rest.

#include <pliant/chainmail.h>
#include <pliant/tissue.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "deform_outputs.h"
#include "setting_options.h"
#include "standard_output.h"

namespace pliant::app {
namespace {

constexpr int kStepsAtATime = 20;
constexpr std::int64_t kMostSteps = 100'000;  ///< limit to come to rest

Status check_spring_options(const DeformOptions& o) {
    const std::pair<const char*, bool> given[] = {
        {"--config", !o.config.empty()},
        {"--labels", !o.labels.empty()},
        {"--directions", !o.directions.empty()},
        {"--relax", o.relax_ms.has_value()},
        {"--relax-sweeps", o.relax_sweeps.has_value()},
        {"--solver", !o.solver.empty()},
        {"--load-state", !o.load_state.empty()},
        {"--save-state", !o.save_state.empty()},
    };
    for (const auto& [option, is_given] : given)
        if (is_given)
            return Error{ErrorCode::InvalidArgument,
                         std::string(option) + ": expected --model chainmail, found springs"};
    for (const DeformAction& action : o.actions)
        if (!std::holds_alternative<PushOption>(action)) {
            const char* option = std::holds_alternative<SlideOption>(action)  ? "--slide"
                                 : std::holds_alternative<CutSurface>(action) ? "--cut"
                                                                              : "--carve";
            return Error{ErrorCode::InvalidArgument,
                         std::string(option) + ": expected --model chainmail, found springs"};
        }
    if (o.look && !(norm(*o.look) > 0))
        return Error{ErrorCode::InvalidArgument, "--look: expected a direction, found 0,0,0"};
    return Ok{};
}

/// Box of voxels between two corners.
Result<Box3i> region_of(const std::pair<Vec3d, Vec3d>& corners_mm, const Grid& grid) {
    const Vec3d one = voxel_from_world(grid, corners_mm.first);
    const Vec3d other = voxel_from_world(grid, corners_mm.second);
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const double low = std::max(0.0, std::ceil(std::min(one[a], other[a]) - 1e-6));
        const double high =
            std::min(grid.size[a] - 1.0, std::floor(std::max(one[a], other[a]) + 1e-6));
        if (!(low <= high))
            return Error{ErrorCode::InvalidArgument,
                         "--region: expected a box with voxels of the scan in it, found none "
                         "along axis " +
                             std::to_string(a)};
        box.begin[a] = int(low);
        box.end[a] = int(high) + 1;
    }
    return box;
}

Result<SpringDeformationSettings> settings_of(const DeformOptions& o, const Grid& grid) {
    const SpringOptions& given = o.springs;
    SpringDeformationSettings settings;
    if (const Status s = apply(given.settings, spring_rows(), settings); !s)
        return named_by_option(s.error());
    if (given.region_mm) {
        const auto region = region_of(*given.region_mm, grid);
        if (!region.ok()) return region.error();
        settings.region = *region;
    }
    return settings;
}

Status apply_pushes(const DeformOptions& o, SpringDeformation& tissue, DeformResult& result,
                    ProgressBar& bar) {
    std::uint32_t tool = 0;
    for (const DeformAction& action : o.actions) {
        const auto& push = std::get<PushOption>(action);
        const auto report = tissue.push(++tool, {.point_mm = push.point_mm,
                                                 .push_mm = push.push_mm,
                                                 .sphere_radius_mm = o.sphere_radius_mm});
        if (!report.ok()) return named_by_option(report.error());
        result.pushes.push_back(*report);
        bar.show(0.2 + 0.1 * double(tool) / double(o.actions.size()));
    }
    return Ok{};
}

Result<SpringResult> let_time_pass(const DeformOptions& o, SpringDeformation& tissue,
                                   std::vector<std::string>& notes) {
    const auto tools = std::uint32_t(o.actions.size());
    if (o.release)
        for (std::uint32_t tool = 1; tool <= tools; ++tool) tissue.let_go(tool);
    const ControlGrid& grid = tissue.control().grid();
    SpringResult springs{.cell_voxels = grid.cell,
                         .nodes = grid.size,
                         .fixed_nodes = tissue.fixed_nodes(),
                         .depth = tissue.settings().depth,
                         .time_step_ms = 1000 * tissue.time_step_s(),
                         .young_modulus_pa = tissue.settings().young_modulus_pa};
    const std::int64_t most = o.springs.steps ? *o.springs.steps : kMostSteps;
    while (springs.steps < most && !tissue.is_settled()) {
        const int count = int(std::min<std::int64_t>(kStepsAtATime, most - springs.steps));
        const Result<SpringMotion> motion = tissue.step(count);
        if (!motion) return motion.error();
        springs.steps += motion->steps;
        springs.solve_ms += motion->solve_ms;
        springs.active_nodes = std::max(springs.active_nodes, motion->active_nodes);
        if (!motion->message.empty()) notes.push_back("motion stopped: " + motion->message);
    }
    springs.settled = tissue.is_settled();
    springs.force_n = tissue.force_n(tools);
    return springs;
}

}  // namespace

int run_deform_springs(const DeformOptions& options) {
    Outputs outputs;
    if (const Status s = check_spring_options(options); !s.ok())
        return bad_input(s.error().message);
    if (const Status s = stage_outputs(options, outputs); !s.ok())
        return bad_input(s.error().message);
    DeformResult result;
    std::optional<ProgressBar> bar(std::in_place, "deform");
    const auto fail = [&](const Error& error) {
        bar.reset();
        return bad_input(error.message);
    };
    ReadNotes read_notes;
    const auto volume = read_volume(options.file, {options.series}, &read_notes);
    if (!volume.ok()) return fail(volume.error());
    result.notes = read_notes.notes;
    bar->show(0.2);
    const auto settings = settings_of(options, volume->grid);
    if (!settings.ok()) return fail(settings.error());
    const TaskArena arena(options.threads);
    auto created = SpringDeformation::create(*volume, *settings, arena);
    if (!created.ok()) return fail(named_by_option(created.error()));
    SpringDeformation& tissue = **created;
    if (const Status s = apply_pushes(options, tissue, result, *bar); !s.ok())
        return fail(s.error());
    auto springs = let_time_pass(options, tissue, result.notes);
    if (!springs.ok()) return fail(springs.error());
    result.springs = *springs;
    const Result<DeformationState> state = state_of(tissue);
    if (!state) return fail(state.error());
    result.state = {*state};
    auto deformed = deform_volume(
        tissue, options.mapping == "tetrahedra" ? Mapping::Tetrahedra : Mapping::Cells,
        !options.transform.empty() || shows_rest(options));
    if (!deformed) return fail(deformed.error());
    if (shows_rest(options)) {
        auto rest = RestField::create(tissue, *deformed);
        if (!rest) return fail(rest.error());
        result.rest = std::move(*rest);
    }
    result.deformed = std::move(*deformed);
    result.hash = hash_volume(result.deformed.volume) ^ tissue.hash();
    bar->show(0.5);
    const auto no_state = [](const std::filesystem::path&) -> Status { return Ok{}; };
    const auto& last = std::get<PushOption>(options.actions.back());
    if (const Status s = write_outputs(options, tissue, result, last, no_state, outputs, *bar);
        !s.ok())
        return fail(s.error());
    bar.reset();
    if (!is_standard_output(options.report)) std::fputs(report_text(result).c_str(), stdout);
    return kExitOk;
}

}  // namespace pliant::app
