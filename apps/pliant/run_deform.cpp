// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The whole pipeline: read, push, resample, draw. Outputs appear together at the end.

#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "deform_outputs.h"
#include "setting_options.h"
#include "standard_output.h"

namespace pliant::app {
namespace {

Result<ChainMailSettings> settings_of(const DeformOptions& o, std::vector<std::string>& notes) {
    ChainMailSettings settings;
    if (!o.config.empty()) {
        auto read = read_chainmail_settings(o.config, &notes);
        if (!read.ok()) return read.error();
        settings = *read;
    }
    settings.solver = o.solver == "heap" ? ChainMailSolver::Heap : ChainMailSolver::Sweep;
    return settings;
}

/// Reads the label map and the direction field, if requested.
Status read_maps(const DeformOptions& o, ChainMailSettings& settings) {
    if (!o.labels.empty()) {
        auto labels = read_volume(o.labels);
        if (!labels.ok()) return Error{labels.error().code, "--labels: " + labels.error().message};
        settings.labels = std::make_shared<const Volume>(std::move(*labels));
    }
    if (!o.directions.empty()) {
        auto directions = read_vector_field(o.directions);
        if (!directions.ok())
            return Error{directions.error().code, "--directions: " + directions.error().message};
        settings.directions = std::make_shared<const VectorField>(std::move(*directions));
    }
    if (settings.labels && settings.label_materials.empty())
        return Error{ErrorCode::InvalidArgument,
                     "--labels: expected [[label]] tables in --config, found none"};
    return Ok{};
}

/// The last tool during relaxation: the elements that it holds, or its position.
struct LeftTool {
    std::vector<Vec3i> held;
    std::vector<RelaxTool> lying;
};

Status apply(const SlideOption& option, const DeformOptions& o, ChainMail& tissue,
             DeformResult& result, LeftTool& left) {
    const auto report = slide_sphere(tissue, {.point_mm = option.point_mm,
                                              .push_mm = option.way_mm,
                                              .sphere_radius_mm = o.sphere_radius_mm});
    if (!report.ok()) return named_by_option(report.error());
    left = {{}, {{report->end_mm, report->end_mm, o.sphere_radius_mm}}};
    result.slides.push_back(*report);
    return Ok{};
}

Status apply(const DeformAction& action, const DeformOptions& o, ChainMail& tissue,
             DeformResult& result, LeftTool& left) {
    if (const auto* option = std::get_if<PushOption>(&action)) {
        auto grabbed = tissue.elements_at({.point_mm = option->point_mm,
                                           .push_mm = option->push_mm,
                                           .sphere_radius_mm = o.sphere_radius_mm});
        if (!grabbed.ok()) return named_by_option(grabbed.error());
        left = {std::move(*grabbed), {}};
        const auto report = tissue.push_elements(left.held, option->push_mm);
        if (!report.ok()) return named_by_option(report.error());
        result.pushes.push_back(*report);
    } else if (const auto* slide = std::get_if<SlideOption>(&action)) {
        return apply(*slide, o, tissue, result, left);
    } else if (const auto* surface = std::get_if<CutSurface>(&action)) {
        const auto report = tissue.cut(*surface);
        if (!report.ok()) return named_by_option(report.error());
        result.edit_ms += report->cut_ms;
    } else if (const auto* tool = std::get_if<CarveTool>(&action)) {
        const auto report = tissue.carve(*tool);
        if (!report.ok()) return named_by_option(report.error());
        result.edit_ms += report->carve_ms;
    }
    return Ok{};
}

Status apply_actions(const DeformOptions& o, ChainMail& tissue, DeformResult& result,
                     ProgressBar& bar, LeftTool& left) {
    for (std::size_t n = 0; n < o.actions.size(); ++n) {
        if (const Status s = apply(o.actions[n], o, tissue, result, left); !s.ok()) return s;
        bar.show(0.2 + 0.2 * double(n + 1) / double(o.actions.size()));
    }
    return Ok{};
}

Status apply_relaxation(const DeformOptions& o, ChainMail& tissue, LeftTool left,
                        DeformResult& result) {
    if (!o.relax_ms && !o.relax_sweeps) return Ok{};
    RelaxOptions options{.measure_energy = true};
    if (o.relax_ms) options.budget_ms = *o.relax_ms;
    if (o.relax_sweeps) options.max_sweeps = *o.relax_sweeps;
    if (!o.release) {
        options.held = std::move(left.held);
        options.tools = std::move(left.lying);
    }
    const auto report = tissue.relax(options);
    if (!report.ok()) return named_by_option(report.error());
    result.relax = *report;
    return Ok{};
}

/// Returns a push, or a slide as a push at its end; nullopt for other actions.
std::optional<PushOption> pushed_by(const DeformAction& action) {
    if (const auto* push = std::get_if<PushOption>(&action)) return *push;
    if (const auto* slide = std::get_if<SlideOption>(&action))
        return PushOption{slide->point_mm + slide->way_mm, slide->way_mm};
    return std::nullopt;
}

/// Point and direction of the picture: the last push or slide, otherwise the last cut or carving.
PushOption place_of_picture(const DeformOptions& o, const ChainMail& tissue) {
    for (auto at = o.actions.rbegin(); at != o.actions.rend(); ++at)
        if (const auto push = pushed_by(*at)) return *push;
    if (o.actions.empty()) {
        const Box3i box = tissue.moved_box();
        const Vec3i sum = box.begin + box.end;
        return {world_from_voxel(tissue.volume().grid, {0.5 * sum.x, 0.5 * sum.y, 0.5 * sum.z}),
                {0, 0, 1}};
    }
    if (const auto* tool = std::get_if<CarveTool>(&o.actions.back()))
        return {tool->to_mm, {0, 0, tool->radius_mm}};
    const auto& surface = std::get<CutSurface>(o.actions.back());
    return {0.5 * (surface.line_mm.front() + surface.line_mm.back() + surface.depth_mm),
            surface.depth_mm};
}

Status check_options(const DeformOptions& o) {
    const SpringOptions& springs = o.springs;
    std::string given = springs.region_mm ? "--region" : springs.steps ? "--steps" : "";
    if (!springs.settings.empty()) given = option_of(springs.settings.front().name);
    if (!given.empty())
        return Error{ErrorCode::InvalidArgument,
                     given + ": expected --model springs too, found chainmail"};
    if (o.release && !o.relax_ms && !o.relax_sweeps)
        return Error{ErrorCode::InvalidArgument,
                     "--release: expected --relax or --relax-sweeps too, found neither"};
    if (o.look && !(norm(*o.look) > 0))
        return Error{ErrorCode::InvalidArgument, "--look: expected a direction, found 0,0,0"};
    const bool slides = std::any_of(o.actions.begin(), o.actions.end(), [](const auto& action) {
        return std::holds_alternative<SlideOption>(action);
    });
    if (slides && o.sphere_radius_mm == 0)
        return Error{ErrorCode::InvalidArgument,
                     "--slide: expected --tool sphere:R_MM, found point"};
    const auto push = o.actions.empty() ? std::nullopt : pushed_by(o.actions.back());
    if (push && o.eye_mm && !o.look && norm(push->point_mm - *o.eye_mm) == 0)
        return Error{
            ErrorCode::InvalidArgument,
            "--eye: expected a place other than that of the last --push or --slide, or --look "
            "too"};
    if (!o.load_state.empty() && !o.config.empty())
        return Error{ErrorCode::InvalidArgument,
                     "--config: expected none beside --load-state, which has its own settings, "
                     "found " +
                         o.config};
    return Ok{};
}

}  // namespace

int run_deform(const DeformOptions& options) {
    Outputs outputs;
    if (const Status s = check_options(options); !s.ok()) return bad_input(s.error().message);
    if (const Status s = stage_outputs(options, outputs); !s.ok())
        return bad_input(s.error().message);
    DeformResult result;
    auto settings = settings_of(options, result.notes);
    if (!settings.ok()) return bad_input(settings.error().message);
    if (const Status s = read_maps(options, *settings); !s.ok())
        return bad_input(s.error().message);
    std::optional<ProgressBar> bar(std::in_place, "deform");
    const auto fail = [&](const Error& error) {
        bar.reset();
        return bad_input(error.message);
    };
    ReadNotes read_notes;
    const auto volume = read_volume(options.file, {options.series}, &read_notes);
    if (!volume.ok()) return fail(volume.error());
    result.notes.insert(result.notes.end(), read_notes.notes.begin(), read_notes.notes.end());
    bar->show(0.2);
    const TaskArena arena(options.threads);
    auto tissue = ChainMail::create(*volume, *settings, arena);
    if (!tissue.ok()) return fail(named_by_option(tissue.error()));
    if (!options.load_state.empty())
        if (const Status s = tissue->load_state(options.load_state); !s.ok())
            return fail(s.error());
    LeftTool left;
    if (const Status s = apply_actions(options, *tissue, result, *bar, left); !s.ok())
        return fail(s.error());
    if (const Status s = apply_relaxation(options, *tissue, std::move(left), result); !s.ok())
        return fail(s.error());
    result.state = tissue->state();
    result.certificate = tissue->fold_certificate();
    auto deformed = deform_volume(
        *tissue, options.mapping == "tetrahedra" ? Mapping::Tetrahedra : Mapping::Cells,
        !options.transform.empty() || shows_rest(options));
    if (!deformed) return fail(deformed.error());
    if (shows_rest(options)) {
        auto rest = RestField::create(*tissue, *deformed);
        if (!rest) return fail(rest.error());
        result.rest = std::move(*rest);
    }
    result.deformed = std::move(*deformed);
    result.hash = hash_volume(result.deformed.volume) ^ tissue->hash();
    bar->show(0.5);
    const auto save_state = [&](const std::filesystem::path& path) {
        return tissue->save_state(path);
    };
    if (const Status s = write_outputs(options, *tissue, result, place_of_picture(options, *tissue),
                                       save_state, outputs, *bar);
        !s.ok())
        return fail(s.error());
    bar.reset();
    if (!is_standard_output(options.report)) std::fputs(report_text(result).c_str(), stdout);
    return kExitOk;
}

}  // namespace pliant::app
