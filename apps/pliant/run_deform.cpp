// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The whole pipeline: read, push, write back to the grid, draw. Outputs appear together at the end.

#include <pliant/chainmail.h>
#include <pliant/chainmail_slide.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/staged_files.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <utility>

#include "options.h"
#include "progress.h"
#include "report.h"

namespace pliant::app {
namespace {

namespace fs = std::filesystem;

constexpr int kPictureSide = 800;  ///< pixels of each of the two four-ups

/// Where each output is written until all are there.
struct Outputs {
    StagedFiles files;
    fs::path out, displacement, transform, jacobian, strain, report, png, state;
};

/// @param endings  none: any name will do
Status check_name(const std::string& option, const fs::path& path,
                  const std::vector<std::string>& endings) {
    std::string expected, found = path.extension().string();
    for (char& c : found) c = char(std::tolower(static_cast<unsigned char>(c)));
    for (const std::string& ending : endings) {
        if (found == ending) return Ok{};
        expected += (expected.empty() ? "" : " or ") + ending;
    }
    if (endings.empty()) return Ok{};
    return Error{ErrorCode::InvalidArgument, option + ": expected a name that ends in " + expected +
                                                 ", found " + path.string()};
}

Status stage_outputs(const DeformOptions& o, Outputs& outputs) {
    struct Item {
        const char* option;
        const std::string& name;
        fs::path& staged;
        std::vector<std::string> endings;
    };
    const Item items[] = {
        {"--out", o.out, outputs.out, {".nrrd", ".nhdr"}},
        {"--displacement", o.displacement, outputs.displacement, {".nrrd", ".nhdr"}},
        {"--transform", o.transform, outputs.transform, {".nrrd", ".nhdr"}},
        {"--jacobian", o.jacobian, outputs.jacobian, {".nrrd", ".nhdr"}},
        {"--strain", o.strain, outputs.strain, {".nrrd", ".nhdr"}},
        {"--report", o.report, outputs.report, {}},
        {"--png", o.png, outputs.png, {".png"}},
        {"--save-state", o.save_state, outputs.state, {".plst"}},
    };
    std::vector<std::pair<std::string, fs::path>> taken = {{"FILE", fs::weakly_canonical(o.file)}};
    for (const Item& item : items) {
        if (item.name.empty()) continue;
        if (const Status status = check_name(item.option, item.name, item.endings); !status.ok())
            return status;
        const fs::path place = fs::weakly_canonical(item.name);
        for (const auto& [option, other] : taken)
            if (place == other)
                return Error{ErrorCode::InvalidArgument,
                             std::string(item.option) + ": expected a file of its own, found " +
                                 item.name + ", which is " + option};
        taken.emplace_back(item.option, place);
        const auto staged = outputs.files.stage(item.name);
        if (!staged.ok()) return staged.error();
        item.staged = *staged;
    }
    return Ok{};
}

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

/// Label map and direction field, where they are asked for.
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

/// The room speaks of labels and directions; a user gave them as options.
Error named_by_option(Error error) {
    for (const char* option : {"labels:", "directions:"})
        if (error.message.starts_with(option)) error.message.insert(0, "--");
    return error;
}

/// What the last tool leaves to the relaxation: the elements that it holds, or where it lies.
struct LeftTool {
    std::vector<Vec3i> held;
    std::vector<RelaxTool> lying;
};

Status apply(const SlideOption& option, const DeformOptions& o, ChainMail& tissue,
             DeformResult& result, LeftTool& left) {
    const auto report = slide_sphere(tissue, {.point_mm = option.point_mm,
                                              .push_mm = option.way_mm,
                                              .sphere_radius_mm = o.sphere_radius_mm});
    if (!report.ok()) return Error{report.error().code, "--" + report.error().message};
    const Vec3d end_mm =
        option.point_mm + report->way_fraction * tissue.settings().scale * option.way_mm;
    left = {{}, {{end_mm, end_mm, o.sphere_radius_mm}}};
    result.slides.push_back(*report);
    return Ok{};
}

Status apply(const DeformAction& action, const DeformOptions& o, ChainMail& tissue,
             DeformResult& result, LeftTool& left) {
    const auto failed = [](const Error& error) -> Status {
        return Error{error.code, "--" + error.message};
    };
    if (const auto* option = std::get_if<PushOption>(&action)) {
        auto grabbed = tissue.elements_at({.point_mm = option->point_mm,
                                           .push_mm = option->push_mm,
                                           .sphere_radius_mm = o.sphere_radius_mm});
        if (!grabbed.ok()) return failed(grabbed.error());
        left = {std::move(*grabbed), {}};
        const auto report = tissue.push_elements(left.held, option->push_mm);
        if (!report.ok()) return failed(report.error());
        result.pushes.push_back(*report);
    } else if (const auto* slide = std::get_if<SlideOption>(&action)) {
        return apply(*slide, o, tissue, result, left);
    } else if (const auto* surface = std::get_if<CutSurface>(&action)) {
        const auto report = tissue.cut(*surface);
        if (!report.ok()) return failed(report.error());
        result.edit_ms += report->cut_ms;
    } else if (const auto* tool = std::get_if<CarveTool>(&action)) {
        const auto report = tissue.carve(*tool);
        if (!report.ok()) return failed(report.error());
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
    if (!report.ok()) return Error{report.error().code, "--" + report.error().message};
    result.relax = *report;
    return Ok{};
}

/// A push, or a slide from where it ends; of other actions none.
std::optional<PushOption> pushed_by(const DeformAction& action) {
    if (const auto* push = std::get_if<PushOption>(&action)) return *push;
    if (const auto* slide = std::get_if<SlideOption>(&action))
        return PushOption{slide->point_mm + slide->way_mm, slide->way_mm};
    return std::nullopt;
}

/// Where the picture looks, and along what: the last push or slide, or the last cut or carving.
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

/// Before and after, with the same camera and the same sections through the place of the push.
Image before_and_after(const DeformOptions& o, const ChainMail& tissue, const Volume& after) {
    const Volume& before = tissue.volume();
    const TaskArena& arena = tissue.arena();
    const PushOption push = place_of_picture(o, tissue);
    const double iso_hu = o.iso_hu.value_or(-500);
    FourUp view;
    if (o.eye_mm) {
        view.endoscope.eye_mm = *o.eye_mm;
        view.endoscope.look = o.look.value_or(push.point_mm - *o.eye_mm);
        // An eye in bright contrast looks at a wall that is darker.
        const Vec3d eye_ijk = voxel_from_world(before.grid, *o.eye_mm);
        if (sample_linear(before, eye_ijk) >= iso_hu) view.endoscope.polarity = Polarity::Falling;
    } else {
        view.endoscope =
            aim_endoscope(before, push.point_mm, push.push_mm, iso_hu, Polarity::Rising, arena);
        if (o.look) view.endoscope.look = *o.look;
    }
    view.endoscope.iso_hu = iso_hu;
    view.section.point_mm = push.point_mm;
    // Near enough to see the wall move: the push is a tenth of the picture, or more.
    const double width_mm = before.grid.size.x * before.grid.spacing_mm.x;
    view.section.width_mm = std::min(width_mm, std::max(80.0, 10 * norm(push.push_mm)));
    view.caption = "before";
    const Image left = four_up_view(before, view, kPictureSide, kPictureSide, arena);
    // Most pages are those of the other scan, too, and would count twice.
    std::visit([](const auto& voxels) { voxels.let_go(); }, before.voxels);
    view.caption = "after";
    return side_by_side(left, four_up_view(after, view, kPictureSide, kPictureSide, arena));
}

Status write_text(const fs::path& path, const std::string& text) {
    std::ofstream stream(path, std::ios::binary);
    stream << text;
    stream.close();
    if (stream) return Ok{};
    return Error{ErrorCode::Unwritable, path.filename().string() + ": can't be written"};
}

Status write_outputs(const DeformOptions& o, const ChainMail& tissue, const DeformResult& result,
                     Outputs& outputs, ProgressBar& bar) {
    const Encoding encoding = o.raw ? Encoding::Raw : Encoding::Gzip;
    const Deformed& deformed = result.deformed;
    if (Status s = write_volume(outputs.out, deformed.volume, encoding); !s.ok()) return s;
    bar.show(0.6);
    if (!outputs.displacement.empty()) {
        Status s = write_vector_field(outputs.displacement, tissue.volume().grid,
                                      FieldKind::Modeling, displacement_slices(tissue), encoding);
        if (!s.ok()) return s;
    }
    bar.show(0.7);
    if (!outputs.transform.empty()) {
        Status s = write_vector_field(outputs.transform, deformed.volume.grid,
                                      FieldKind::Resampling, inverse_slices(deformed), encoding);
        if (!s.ok()) return s;
    }
    bar.show(0.8);
    if (!outputs.jacobian.empty())
        if (Status s = write_volume(outputs.jacobian, jacobian_field(tissue), encoding); !s.ok())
            return s;
    if (!outputs.strain.empty())
        if (Status s = write_volume(outputs.strain, strain_field(tissue), encoding); !s.ok())
            return s;
    if (!outputs.png.empty()) {
        const Image image = before_and_after(o, tissue, deformed.volume);
        if (Status s = write_png(outputs.png, image); !s.ok()) return s;
    }
    if (!outputs.state.empty())
        if (Status s = tissue.save_state(outputs.state); !s.ok()) return s;
    if (!outputs.report.empty())
        if (Status s = write_text(outputs.report, report_json(o, result)); !s.ok()) return s;
    return outputs.files.commit();
}

Status check_options(const DeformOptions& o) {
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
    result.deformed = deform_volume(
        *tissue, options.mapping == "tetrahedra" ? Mapping::Tetrahedra : Mapping::Cells,
        !options.transform.empty());
    result.hash = hash_volume(result.deformed.volume) ^ tissue->hash();
    bar->show(0.5);
    if (const Status s = write_outputs(options, *tissue, result, outputs, *bar); !s.ok())
        return fail(s.error());
    bar.reset();
    std::fputs(report_text(result).c_str(), stdout);
    return kExitOk;
}

}  // namespace pliant::app
