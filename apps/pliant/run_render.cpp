// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/render.h>

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <utility>

#include "options.h"

namespace pliant::app {
namespace {

/// "R,G,B", each 0…255.
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

/// The endoscope that the options ask for; what they leave open is found in the scan.
/// @returns InvalidArgument if there is no lumen to start from
Result<Endoscope> place_endoscope(const RenderOptions& o, const Volume& volume, Endoscope e,
                                  const TaskArena& arena) {
    if (!o.eye_mm) {
        const auto found = find_endoscope(volume, e.iso_hu, e.polarity, arena);
        if (!found)
            return Error{ErrorCode::InvalidArgument,
                         o.file + ": no lumen at --iso; expected --eye X,Y,Z or another threshold"};
        e.eye_mm = found->eye_mm;
        e.look = found->look;
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

/// @returns what is wrong with the options, or an empty text
std::string check(const RenderOptions& o) {
    const std::pair<const char*, double> numbers[] = {{"--iso", o.iso_hu},
                                                      {"--fov", o.field_of_view_deg},
                                                      {"--barrel", o.barrel_distortion},
                                                      {"--fog", o.fog_distance_mm},
                                                      {"--window", o.window_hu},
                                                      {"--level", o.level_hu}};
    for (const auto& [name, value] : numbers)
        if (!std::isfinite(value)) return std::string(name) + ": expected a finite number";
    if (o.look && !(norm(*o.look) > 0)) return "--look: expected a direction, found 0,0,0";
    if (o.up && !(norm(*o.up) > 0)) return "--up: expected a direction, found 0,0,0";
    if (o.up && o.look && norm(cross(*o.up, *o.look)) < 1e-6 * norm(*o.up) * norm(*o.look))
        return "--up: expected a direction that is not parallel to --look";
    if (o.colour && !parse_colour(*o.colour))
        return "--colour: expected R,G,B each 0…255, found '" + *o.colour + "'";
    return {};
}

Image draw_section(const RenderOptions& o, const Volume& volume, Section section, int width,
                   int height, const TaskArena& arena) {
    section.orientation = o.view == "axial"     ? Orientation::Axial
                          : o.view == "coronal" ? Orientation::Coronal
                                                : Orientation::Sagittal;
    return section_view(volume, section, width, height, arena);
}

Result<Image> draw(const RenderOptions& o, const Volume& volume, const TaskArena& arena) {
    const bool four = o.view == "four-up", section_only = !four && o.view != "endoscope";
    const int side = four ? 1024 : 512;
    const int width = o.width > 0 ? o.width : side, height = o.height > 0 ? o.height : side;
    Endoscope e;
    e.field_of_view_deg = o.field_of_view_deg;
    e.barrel_distortion = o.barrel_distortion;
    e.fog_distance_mm = o.fog_distance_mm;
    e.iso_hu = o.iso_hu;
    e.polarity = o.polarity == "falling" ? Polarity::Falling : Polarity::Rising;
    if (o.colour) e.surface = *parse_colour(*o.colour);
    Section section;
    section.window_hu = o.window_hu;
    section.level_hu = o.level_hu;
    if (section_only && (o.at_mm || o.eye_mm)) {
        section.point_mm = o.at_mm ? *o.at_mm : *o.eye_mm;
        return draw_section(o, volume, section, width, height, arena);
    }
    const auto placed = place_endoscope(o, volume, e, arena);
    // A section has something to show where no endoscope fits.
    if (!placed && !section_only) return placed.error();
    section.point_mm = o.at_mm ? *o.at_mm : placed ? placed->eye_mm : volume_centre_mm(volume.grid);
    if (section_only) return draw_section(o, volume, section, width, height, arena);
    if (!four) return RayCaster(volume, arena).endoscope_view(*placed, width, height);
    const std::string name = std::filesystem::path(o.file).filename().string();
    return four_up_view(volume, {*placed, section, name}, width, height, arena);
}

}  // namespace

int run_render(const RenderOptions& options) {
    if (const std::string wrong = check(options); !wrong.empty()) return bad_input(wrong);
    const auto volume = read_volume(options.file, {options.series});
    if (!volume) return bad_input(volume.error().message);
    const TaskArena arena(options.threads);
    const auto image = draw(options, *volume, arena);
    if (!image) return bad_input(image.error().message);
    if (const auto written = write_png(options.out, *image); !written)
        return bad_input(written.error().message);
    return kExitOk;
}

}  // namespace pliant::app
