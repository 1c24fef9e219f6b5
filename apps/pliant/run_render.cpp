// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/chainmail.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/view/png.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>

#include "camera_path.h"
#include "keyframes.h"
#include "look.h"
#include "movie.h"
#include "options.h"
#include "output_names.h"
#include "progress.h"
#include "scan_defaults.h"

namespace pliant::app {
namespace {

/// Parses "R,G,B", each 0…255.
std::optional<Rgb8> parse_colour(const std::string& text) {
    std::array<std::uint8_t, 3> parts{};
    const char* at = text.data();
    const char* const end = at + text.size();
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (i > 0 && (at == end || *at++ != ',')) return std::nullopt;
        while (at != end && *at == ' ') ++at;
        const auto [next, error] = std::from_chars(at, end, parts[i]);
        if (error != std::errc{}) return std::nullopt;
        at = next;
    }
    if (at != end) return std::nullopt;
    return Rgb8{parts[0], parts[1], parts[2]};
}

Vec3d volume_centre_mm(const Grid& g) {
    return world_from_voxel(g, {0.5 * (g.size.x - 1), 0.5 * (g.size.y - 1), 0.5 * (g.size.z - 1)});
}

/// Builds the endoscope of the options; open parameters are found in the scan.
/// @returns InvalidArgument if there is no lumen at the user's threshold
Result<Endoscope> place_endoscope(const RenderOptions& o, const Volume& volume, Endoscope e,
                                  const TaskArena& arena) {
    if (!o.eye_mm) {
        const auto found = find_endoscope(volume, e.iso_hu, e.polarity, arena);
        // A threshold that the user gave must have a lumen; the blended view needs none.
        if (!found && o.iso_hu && o.view != "blended")
            return Error{ErrorCode::InvalidArgument,
                         o.file + ": no lumen at --iso; expected --eye X,Y,Z or another threshold"};
        const Endoscope view = found ? *found : view_of_whole(volume);
        e.eye_mm = view.eye_mm;
        e.look = view.look;
        if (!found && !o.fog_distance_mm) e.fog_distance_mm = 0;
    } else {
        e.eye_mm = *o.eye_mm;
    }
    if (o.look) {
        e.look = *o.look;
    } else if (o.eye_mm) {
        const Vec3d to_centre = volume_centre_mm(volume.grid) - e.eye_mm;
        if (const auto free = find_look(volume, e.eye_mm, e.iso_hu, e.polarity, arena))
            e.look = *free;
        else if (norm(to_centre) > 0)
            e.look = to_centre;
    }
    e.up = o.up.value_or(Vec3d{0, 0, 0});
    return e;
}

/// A deformed scan, with rest positions for the style real.
struct LoadedState {
    Deformed deformed;
    RestField rest;
};

/// Deforms the scan by the state of --load-state. @returns a fault of the state; LimitExceeded
Result<LoadedState> load_state(const RenderOptions& o, const Volume& scan, const TaskArena& arena) {
    auto tissue = ChainMail::create(scan, {}, arena);
    if (!tissue) return tissue.error();
    if (const Status s = tissue->load_state(o.load_state); !s.ok()) return s.error();
    const bool real = o.look_of.style == "real";
    auto deformed = deform_volume(*tissue, Mapping::Cells, real);
    if (!deformed) return deformed.error();
    LoadedState loaded;
    if (real) {
        auto rest = RestField::create(*tissue, *deformed);
        if (!rest) return rest.error();
        loaded.rest = std::move(*rest);
    }
    loaded.deformed = std::move(*deformed);
    return loaded;
}

/// @returns fault of the options, or an empty text
std::string check(const RenderOptions& o) {
    const std::pair<const char*, double> numbers[] = {
        {"--iso", o.iso_hu.value_or(0)},       {"--fov", o.field_of_view_deg},
        {"--barrel", o.barrel_distortion},     {"--fog", o.fog_distance_mm.value_or(0)},
        {"--window", o.window_hu.value_or(0)}, {"--level", o.level_hu.value_or(0)}};
    for (const auto& [name, value] : numbers)
        if (!std::isfinite(value)) return std::string(name) + ": expected a finite number";
    if (o.look && !(norm(*o.look) > 0)) return "--look: expected a direction, found 0,0,0";
    if (o.up && !(norm(*o.up) > 0)) return "--up: expected a direction, found 0,0,0";
    if (o.up && o.look && norm(cross(*o.up, *o.look)) < 1e-6 * norm(*o.up) * norm(*o.look))
        return "--up: expected a direction that is not parallel to --look";
    if (o.colour && !parse_colour(*o.colour))
        return "--colour: expected R,G,B each 0…255, found '" + *o.colour + "'";
    if (!o.path.empty() && !o.keyframes.empty())
        return "--path and --keyframes: expected one of them";
    if ((o.path.empty() && o.keyframes.empty()) != o.movie.empty())
        return o.keyframes.empty() ? "--path and --movie: expected both or none of them"
                                   : "--keyframes and --movie: expected both or none of them";
    if (o.movie.empty() == o.out.empty()) return "--out: expected it, or --path with --movie";
    if (!o.movie.empty() && (o.view == "axial" || o.view == "coronal" || o.view == "sagittal" ||
                             o.view == "fluoroscopy"))
        return "--view: expected four-up, endoscope or blended for a movie, found '" + o.view + "'";
    return {};
}

Image draw_section(const RenderOptions& o, const Volume& volume, Section section, int width,
                   int height, const TaskArena& arena) {
    section.orientation = o.view == "axial"     ? Orientation::Axial
                          : o.view == "coronal" ? Orientation::Coronal
                                                : Orientation::Sagittal;
    return section_view(volume, section, width, height, arena);
}

/// Draws the fluoroscopy; by default from the front, the whole scan.
Image draw_fluoroscopy(const RenderOptions& o, const Volume& volume, int width, int height,
                       const TaskArena& arena) {
    Fluoroscopy f{.centre_mm = o.at_mm.value_or(volume_centre_mm(volume.grid)),
                  .up = o.up.value_or(Vec3d{0, 0, 0}),
                  .source_mm = o.source_mm,
                  .contrast = o.contrast,
                  .exposure_water_mm = o.exposure_water_mm,
                  .border_mm = o.border_mm,
                  .field_stop = field_stop_of(o.look_of),
                  .noise = o.noise,
                  .seed = o.seed};
    if (o.look) f.look = *o.look;
    const Grid& g = volume.grid;
    double longest_mm = 0;
    for (int a = 0; a < 3; ++a) longest_mm = std::max(longest_mm, g.size[a] * g.spacing_mm[a]);
    f.width_mm = o.width_mm.value_or(longest_mm * std::max(1.0, double(width) / height));
    return fluoroscopy_view(volume, f, width, height, arena);
}

struct Views {
    Endoscope endoscope;  ///< without its position
    Section section;
    TransferFunction transfer;
    int width, height;
};

/// @param scale  of lengths in the scan
Views make_views(const RenderOptions& o, const ValueDefaults& values, double scale) {
    Views v;
    const int side = o.view == "four-up" ? 1024 : 512;
    v.width = o.width > 0 ? o.width : side;
    v.height = o.height > 0 ? o.height : side;
    Endoscope& e = v.endoscope;
    e.field_of_view_deg = o.field_of_view_deg;
    e.barrel_distortion = o.barrel_distortion;
    e.fog_distance_mm = o.fog_distance_mm.value_or(scale * e.fog_distance_mm);
    e.iso_hu = o.iso_hu.value_or(values.iso);
    e.polarity = polarity_of(o.polarity, values);
    if (o.colour) e.surface = *parse_colour(*o.colour);
    set_look(o.look_of, e);
    v.section.window_hu = o.window_hu.value_or(values.window);
    v.section.level_hu = o.level_hu.value_or(values.level);
    v.transfer.window_hu = o.window_hu.value_or(values.blended_window);
    v.transfer.level_hu = o.level_hu.value_or(values.blended_level);
    v.transfer.opacity_per_mm = o.opacity_per_mm.value_or(v.transfer.opacity_per_mm / scale);
    return v;
}

Image draw_four(const RenderOptions& o, const Volume& volume, const Views& v,
                const TaskArena& arena) {
    const std::string name = std::filesystem::path(o.file).filename().string();
    return four_up_view(volume, {v.endoscope, v.section, name}, v.width, v.height, arena);
}

/// @param rest  rest field of a deformed volume, or null
Result<Image> draw(const RenderOptions& o, const ValueDefaults& values, const Volume& volume,
                   const RestField* rest, const TaskArena& arena) {
    const bool section_only = o.view == "axial" || o.view == "coronal" || o.view == "sagittal";
    Views v = make_views(o, values, length_scale(volume.grid));
    v.endoscope.rest = rest;
    if (section_only && (o.at_mm || o.eye_mm)) {
        v.section.point_mm = o.at_mm ? *o.at_mm : *o.eye_mm;
        return draw_section(o, volume, v.section, v.width, v.height, arena);
    }
    if (o.view == "fluoroscopy") return draw_fluoroscopy(o, volume, v.width, v.height, arena);
    const auto placed = place_endoscope(o, volume, v.endoscope, arena);
    // A section can be drawn even if no endoscope fits.
    if (!placed && !section_only) return placed.error();
    v.section.point_mm = o.at_mm  ? *o.at_mm
                         : placed ? placed->eye_mm
                                  : volume_centre_mm(volume.grid);
    if (section_only) return draw_section(o, volume, v.section, v.width, v.height, arena);
    v.endoscope = *placed;
    if (o.view == "four-up") return draw_four(o, volume, v, arena);
    const RayCaster caster(volume, arena);
    if (o.view == "blended") return caster.blended_view(v.endoscope, v.transfer, v.width, v.height);
    return caster.endoscope_view(v.endoscope, v.width, v.height);
}

/// Cameras of a movie, frame by frame: along a path with the options' parameters, or through
/// keyframes with their own.
Result<std::vector<Keyframe>> read_shots(const RenderOptions& o, const Views& v, double scale) {
    constexpr double kSpeed_mm_s = 20;
    std::vector<Keyframe> shots;
    if (!o.keyframes.empty()) {
        const auto frames = read_keyframes(o.keyframes);
        if (!frames) return frames.error();
        const auto count = std::int64_t(frames->back().seconds * kFramesPerSecond + 0.5) + 1;
        for (std::int64_t n = 0; n < count; ++n)
            shots.push_back(shot_at(*frames, double(n) / kFramesPerSecond));
        return shots;
    }
    const auto path = read_camera_path(o.path);
    if (!path) return path.error();
    const bool blended = o.view == "blended";
    const double step_mm = o.speed_mm_s.value_or(scale * kSpeed_mm_s) / kFramesPerSecond;
    for (const CameraPose& pose : fly(*path, step_mm, scale))
        shots.push_back({.eye_mm = pose.eye_mm,
                         .look = pose.look,
                         .up = pose.up,
                         .field_of_view_deg = o.field_of_view_deg,
                         .iso_hu = v.endoscope.iso_hu,
                         .window_hu = blended ? v.transfer.window_hu : v.section.window_hu,
                         .level_hu = blended ? v.transfer.level_hu : v.section.level_hu});
    return shots;
}

/// Draws all frames with one caster.
Status draw_movie(const RenderOptions& o, Views v, const std::vector<Keyframe>& shots,
                  const Volume& volume, const RestField* rest, const TaskArena& arena,
                  ProgressBar& bar) {
    v.endoscope.rest = rest;
    Movie movie;
    if (const Status opened = movie.open(o.movie, v.width, v.height); !opened) return opened;
    const RayCaster caster(volume, arena);
    std::size_t count = 0;
    for (const Keyframe& shot : shots) {
        v.endoscope.eye_mm = v.section.point_mm = shot.eye_mm;
        v.endoscope.look = shot.look;
        v.endoscope.up = shot.up;
        v.endoscope.field_of_view_deg = shot.field_of_view_deg;
        v.endoscope.iso_hu = shot.iso_hu;
        v.section.window_hu = v.transfer.window_hu = shot.window_hu;
        v.section.level_hu = v.transfer.level_hu = shot.level_hu;
        const Image frame = o.view == "four-up" ? draw_four(o, volume, v, arena)
                            : o.view == "blended"
                                ? caster.blended_view(v.endoscope, v.transfer, v.width, v.height)
                                : caster.endoscope_view(v.endoscope, v.width, v.height);
        if (const Status added = movie.add(frame); !added) return added;
        bar.show(double(++count) / double(shots.size()));
    }
    return movie.finish();
}

}  // namespace

int run_render(const RenderOptions& options) {
    if (const std::string wrong = check(options); !wrong.empty()) return bad_input(wrong);
    if (!options.out.empty())
        if (const Status s = check_picture_name("--out", options.out); !s)
            return bad_input(s.error());
    std::optional<ProgressBar> bar(std::in_place, "render");
    const auto fail = [&](const Error& error) {
        bar.reset();
        return bad_input(error);
    };
    ReadNotes notes;
    auto volume = read_volume(options.file, options.scan.options(), &notes);
    if (!volume) return fail(volume.error());
    const ValueDefaults values = take_values(*volume, notes);
    const TaskArena arena(options.threads);
    const Volume* shown = &*volume;
    const RestField* rest = nullptr;
    std::optional<LoadedState> state;
    if (!options.load_state.empty()) {
        auto loaded = load_state(options, *volume, arena);
        if (!loaded) return fail(loaded.error());
        state.emplace(std::move(*loaded));
        shown = &state->deformed.volume;
        rest = &state->rest;
    }
    if (!options.movie.empty()) {
        const double scale = length_scale(volume->grid);
        const Views views = make_views(options, values, scale);
        const auto shots = read_shots(options, views, scale);
        if (!shots) return fail(shots.error());
        const Status done = draw_movie(options, views, *shots, *shown, rest, arena, *bar);
        return done ? kExitOk : fail(done.error());
    }
    const auto image = draw(options, values, *shown, rest, arena);
    bar.reset();
    const std::string remark = remark_on(values, "--window, --level, --iso, --polarity");
    if (!remark.empty()) std::printf("%s\n", remark.c_str());
    if (!image) return bad_input(image.error());
    if (const auto written = write_png(options.out, *image); !written)
        return bad_input(written.error());
    return kExitOk;
}

}  // namespace pliant::app
