// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The whole pipeline, for every model: read, push, let time pass, resample, draw. Outputs appear
// together at the end.

#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/tissue.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "deform_models.h"
#include "deform_outputs.h"
#include "picture.h"
#include "scan_defaults.h"
#include "setting_options.h"
#include "standard_output.h"

namespace pliant::app {
namespace {

constexpr std::int64_t kMaxSteps = 100'000;  ///< limit to come to rest

bool has_one_slice(const Grid& grid) {
    return std::min({grid.size.x, grid.size.y, grid.size.z}) == 1;
}

/// Number of an action's tool. Tissue that moves by itself would leave a tool that lets go, so each
/// push has a tool of its own; else the last one stays.
std::uint32_t tool_of(std::size_t action, const Tissue& tissue) {
    return tissue.traits().moves_by_itself ? std::uint32_t(action + 1) : 1;
}

/// Tool of the last push or slide. Cuts and carvings have none.
std::optional<std::uint32_t> last_tool(const DeformOptions& o, const Tissue& tissue) {
    for (std::size_t n = o.actions.size(); n-- > 0;)
        if (std::holds_alternative<PushOption>(o.actions[n]) ||
            std::holds_alternative<SlideOption>(o.actions[n]))
            return tool_of(n, tissue);
    return {};
}

/// Values that are tissue for a sphere that slides: those of the tissue's own settings, or those
/// that suit the scan.
TissueValues tissue_values_of(const Tissue& tissue, const ValueDefaults& scan) {
    TissueValues values{.threshold_hu = scan.air_threshold};
    if (const auto* threshold = find_figure(tissue.settings(), "air_threshold_hu"))
        values.threshold_hu = std::get<double>(*threshold);
    return values;
}

Status apply(const DeformAction& action, std::uint32_t tool, const DeformOptions& o, Tissue& tissue,
             DeformResult& result) {
    if (const auto* option = std::get_if<PushOption>(&action)) {
        const auto report = tissue.push(tool, {.point_mm = option->point_mm,
                                               .push_mm = option->push_mm,
                                               .sphere_radius_mm = o.sphere_radius_mm});
        if (!report.ok()) return named_by_option(report.error());
        result.pushes.push_back(*report);
    } else if (const auto* slide = std::get_if<SlideOption>(&action)) {
        const auto report = tissue.slide(tool,
                                         {.point_mm = slide->point_mm,
                                          .push_mm = slide->way_mm,
                                          .sphere_radius_mm = o.sphere_radius_mm},
                                         tissue_values_of(tissue, result.values));
        if (!report.ok()) return named_by_option(report.error());
        result.slides.push_back(*report);
    } else if (const auto* surface = std::get_if<CutSurface>(&action)) {
        const auto report = tissue.cut(*surface);
        if (!report.ok()) return named_by_option(report.error());
        result.edit_ms += report->cut_ms;
    } else if (const auto* carved = std::get_if<CarveTool>(&action)) {
        const auto report = tissue.carve(*carved);
        if (!report.ok()) return named_by_option(report.error());
        result.edit_ms += report->carve_ms;
    }
    return Ok{};
}

Status apply_actions(const DeformOptions& o, Tissue& tissue, DeformResult& result,
                     ProgressBar& bar) {
    for (std::size_t n = 0; n < o.actions.size(); ++n) {
        if (const Status s = apply(o.actions[n], tool_of(n, tissue), o, tissue, result); !s.ok())
            return s;
        bar.show(0.2 + 0.2 * double(n + 1) / double(o.actions.size()));
    }
    return Ok{};
}

/// Layers at most of --depth auto.
constexpr std::int32_t kMostLayers = 64;

Status take_depth(const DeformOptions& o, Tissue& tissue, DeformResult& result) {
    if (!o.depth_within_mm) return Ok{};
    const auto found = tissue.take_depth(*o.depth_within_mm, kMostLayers);
    if (!found.ok()) return named_by_option(found.error());
    result.notes.push_back("depth " + std::to_string(*found) +
                           ": one more layer moves nothing by more than " +
                           toml_text(*o.depth_within_mm) + " mm");
    return Ok{};
}

std::int64_t max_steps_of(const DeformOptions& o, const TissueTraits& traits) {
    const std::optional<double> max_ms = model_of(o).max_ms;
    return max_ms ? std::llround(*max_ms / traits.sweep_ms) : kMaxSteps;
}

/// Tissue that moves by itself comes to rest, other tissue is relaxed on request.
Status let_time_pass(const DeformOptions& o, Tissue& tissue, DeformResult& result) {
    const bool moves = tissue.traits().moves_by_itself;
    if (!moves && !o.relax_ms && !o.relax_sweeps) return Ok{};
    if (o.release)
        for (std::size_t n = 0; n < o.actions.size(); ++n) tissue.release(tool_of(n, tissue));
    Budget budget;
    if (moves) budget.max_steps = o.steps ? *o.steps : max_steps_of(o, tissue.traits());
    if (o.relax_sweeps) budget.max_steps = *o.relax_sweeps;
    if (o.relax_ms) budget.max_ms = *o.relax_ms;
    Advanced advanced;
    advanced.energy_before_mm2 = tissue.energy_mm2();
    auto report = tissue.advance(budget);
    if (!report.ok()) return named_by_option(report.error());
    advanced.energy_after_mm2 = tissue.energy_mm2();
    if (!report->message.empty())
        result.notes.push_back("motion stopped: " + report->message);
    else if (moves && !o.steps && !report->settled)
        result.notes.push_back("still moving after " + std::to_string(report->steps) +
                               " steps; --steps N goes on for longer");
    if (const auto tool = last_tool(o, tissue); moves && tool)
        advanced.force_n = tissue.force_n(*tool);
    advanced.report = std::move(*report);
    result.advanced = std::move(advanced);
    return Ok{};
}

/// Reads the label map that moves with the scan. @param grid  of the scan as it was read
Result<Volume> labels_to_move(const std::string& file, const Grid& grid) {
    if (file.empty())
        return Error{ErrorCode::InvalidArgument,
                     "--labels-out: expected --labels, the map to deform, found none"};
    auto labels = read_labels(file);
    if (labels.ok() && has_one_slice(grid)) labels = with_doubled_slices(*labels);
    if (!labels.ok()) return Error{labels.error().code, "--labels: " + labels.error().message};
    return labels;
}

/// Deforms the labels. @param grid  of the scan as it was read
Result<Volume> moved_labels(const Volume& labels, const Grid& grid, const Tissue& tissue,
                            const Deformed& deformed) {
    auto moved = deform_labels(tissue, deformed, labels);
    if (moved.ok() && has_one_slice(grid)) return with_single_slices(*moved, grid);
    return moved;
}

/// The tissue's figures. Those of every tissue are added where it doesn't give its own.
Result<Record> figures_of(const Tissue& tissue) {
    const TissueTraits traits = tissue.traits();
    Record record = tissue.report();
    if (find_figure(record, "moved_elements")) return record;
    if (record.empty() && traits.sweep_ms > 0) {
        record = tissue.figures();
        record.emplace_back("time_step_ms", traits.sweep_ms);
        for (NamedValue& figure : record)
            figure.name = std::string(traits.model) + '.' + figure.name;
    }
    const Result<DeformationState> state = state_of(tissue);
    if (!state) return state.error();
    add_figures(*state, record);
    return record;
}

/// Returns a push, or a slide as a push at its end; nullopt for other actions.
std::optional<PushOption> pushed_by(const DeformAction& action) {
    if (const auto* push = std::get_if<PushOption>(&action)) return *push;
    if (const auto* slide = std::get_if<SlideOption>(&action))
        return PushOption{slide->point_mm + slide->way_mm, slide->way_mm};
    return std::nullopt;
}

/// Point and direction of the picture: the last push or slide, otherwise the last cut or carving.
PushOption place_of_picture(const DeformOptions& o, const Tissue& tissue) {
    for (auto at = o.actions.rbegin(); at != o.actions.rend(); ++at)
        if (const auto push = pushed_by(*at)) return *push;
    if (o.actions.empty()) return middle_of_deformation(tissue);
    if (const auto* tool = std::get_if<CarveTool>(&o.actions.back()))
        return {tool->to_mm, {0, 0, tool->radius_mm}};
    const auto& surface = std::get<CutSurface>(o.actions.back());
    return {0.5 * (surface.line_mm.front() + surface.line_mm.back() + surface.depth_mm),
            surface.depth_mm};
}

Status check_options(const DeformOptions& o) {
    if (const Status s = check_model(o); !s.ok()) return s;
    if (o.release && !traits_of(o).moves_by_itself && !o.relax_ms && !o.relax_sweeps)
        return Error{ErrorCode::InvalidArgument,
                     "--release: expected --relax or --relax-sweeps too, found neither"};
    if (const Status s = check_picture(o.picture); !s.ok()) return s;
    const bool slides = std::any_of(o.actions.begin(), o.actions.end(), [](const auto& action) {
        return std::holds_alternative<SlideOption>(action);
    });
    if (slides && o.sphere_radius_mm == 0)
        return Error{ErrorCode::InvalidArgument,
                     "--slide: expected --tool sphere:R_MM, found point"};
    const auto push = o.actions.empty() ? std::nullopt : pushed_by(o.actions.back());
    const PictureOptions& picture = o.picture;
    if (push && picture.eye_mm && !picture.look && norm(push->point_mm - *picture.eye_mm) == 0)
        return Error{
            ErrorCode::InvalidArgument,
            "--eye: expected a position other than that of the last --push or --slide, or --look "
            "too"};
    // A state of the elastic scan has displacements only.
    if (!o.load_state.empty() && !o.config.empty() && o.model != "elastic")
        return Error{ErrorCode::InvalidArgument,
                     "--config: expected none beside --load-state, which has its own settings, "
                     "found " +
                         o.config};
    return Ok{};
}

}  // namespace

int deform(const DeformOptions& options, const Prepare& prepare) {
    Outputs outputs;
    if (const Status s = check_options(options); !s.ok()) return bad_input(s.error());
    if (const Status s = stage_outputs(options, outputs); !s.ok()) return bad_input(s.error());
    DeformResult result;
    std::optional<ProgressBar> bar(std::in_place, "deform");
    const auto fail = [&](const Error& error) {
        bar.reset();
        return bad_input(error);
    };
    const TaskArena arena(options.threads);
    const auto source = prepare(result.notes, arena);
    if (!source.ok()) return fail(source.error());
    ReadNotes read_notes;
    auto volume = source->read(read_notes);
    if (!volume.ok()) return fail(volume.error());
    const Grid read_grid = volume->grid;
    if (has_one_slice(read_grid)) {
        volume = with_doubled_slices(*volume);
        if (!volume.ok()) return fail(volume.error());
        read_notes.notes.push_back(
            "one slice, doubled for the deformation; --out has one again, fields have two");
    }
    result.notes.insert(result.notes.end(), read_notes.notes.begin(), read_notes.notes.end());
    result.values = take_values(*volume, read_notes);
    const std::string remark = remark_on(
        result.values, "--window, --level, --iso, --polarity, and --config with [material], [air]");
    if (!remark.empty()) result.notes.push_back(remark);
    bar->show(0.2);
    if (!options.labels_out.empty()) {
        auto labels = labels_to_move(source->labels, read_grid);
        if (!labels.ok()) return fail(labels.error());
        result.labels = std::move(*labels);
    }
    const auto made = source->make(*volume, result.values, arena);
    if (!made.ok()) return fail(named_by_option(made.error()));
    Tissue& tissue = **made;
    if (!options.load_state.empty())
        if (const Status s = tissue.load_state(options.load_state); !s.ok()) return fail(s.error());
    if (const Status s = apply_actions(options, tissue, result, *bar); !s.ok())
        return fail(s.error());
    if (const Status s = take_depth(options, tissue, result); !s.ok()) return fail(s.error());
    if (const Status s = let_time_pass(options, tissue, result); !s.ok()) return fail(s.error());
    auto figures = figures_of(tissue);
    if (!figures.ok()) return fail(figures.error());
    result.figures = std::move(*figures);
    auto deformed = deform_volume(
        tissue, options.mapping == "tetrahedra" ? Mapping::Tetrahedra : Mapping::Cells,
        !options.transform.empty() || !options.labels_out.empty() || shows_rest(options.picture));
    if (!deformed) return fail(deformed.error());
    if (shows_rest(options.picture)) {
        auto rest = RestField::create(tissue, *deformed);
        if (!rest) return fail(rest.error());
        result.rest = std::move(*rest);
    }
    result.deformed = std::move(*deformed);
    result.hash = hash_volume(result.deformed.volume) ^ tissue.hash();
    if (has_one_slice(read_grid)) {
        auto single = with_single_slices(result.deformed.volume, read_grid);
        if (!single.ok()) return fail(single.error());
        result.single = std::move(*single);
    }
    if (!options.labels_out.empty()) {
        auto moved = moved_labels(result.labels, read_grid, tissue, result.deformed);
        if (!moved.ok()) return fail(named_by_option(moved.error()));
        result.labels = std::move(*moved);
    }
    bar->show(0.5);
    const OwnOutputs own{
        .save_state = [&](const std::filesystem::path& path) { return tissue.save_state(path); },
        .write_mesh = source->write_mesh};
    if (const Status s = write_outputs(options, tissue, result, place_of_picture(options, tissue),
                                       own, outputs, *bar);
        !s.ok())
        return fail(s.error());
    bar.reset();
    if (is_standard_output(options.report)) return kExitOk;
    if (!remark.empty()) std::printf("%s\n", remark.c_str());
    std::fputs(report_text(options, result).c_str(), stdout);
    return kExitOk;
}

int run_deform(const DeformOptions& options) {
    return deform(options,
                  [&](std::vector<std::string>& notes, const TaskArena&) -> Result<DeformSource> {
                      auto make = model_of(options).prepare(options, notes);
                      if (!make.ok()) return make.error();
                      return DeformSource{.read =
                                              [&](ReadNotes& read) {
                                                  return read_volume(options.file,
                                                                     options.scan.options(), &read);
                                              },
                                          .make = std::move(*make),
                                          .write_mesh = {},
                                          .labels = options.labels};
                  });
}

}  // namespace pliant::app
