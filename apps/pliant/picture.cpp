// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "picture.h"

#include <pliant/view/surface_view.h>

#include <algorithm>

#include "look.h"
#include "scan_defaults.h"

namespace pliant::app {
namespace {

constexpr int kPictureSide = 800;  ///< pixels of each of the two four-ups

}  // namespace

Status check_picture(const PictureOptions& o) {
    if (o.look && !(norm(*o.look) > 0))
        return Error{ErrorCode::InvalidArgument, "--look: expected a direction, found 0,0,0"};
    return Ok{};
}

PushOption middle_of_deformation(const MovingScan& scan) {
    const Grid& grid = scan.volume().grid;
    Box3i box = scan.deformation().moved_box();
    if (is_empty(box)) box = {{0, 0, 0}, grid.size};
    const Vec3i sum = box.begin + box.end;
    return {world_from_voxel(grid, {0.5 * sum.x, 0.5 * sum.y, 0.5 * sum.z}), {0, 0, 1}};
}

Image before_and_after(const PictureOptions& o, const MovingScan& scan, const Volume& after,
                       const RestField& rest, const ValueDefaults& values, const PushOption& place,
                       const ShownTool& tool) {
    const Volume& before = scan.volume();
    const TaskArena& arena = scan.arena();
    const double iso_hu = o.iso_hu.value_or(values.iso);
    const Polarity polarity = polarity_of(o.polarity, values);
    FourUp view;
    view.endoscope.polarity = polarity;
    view.section.window_hu = o.window_hu.value_or(values.window);
    view.section.level_hu = o.level_hu.value_or(values.level);
    if (o.eye_mm) {
        view.endoscope.eye_mm = *o.eye_mm;
        view.endoscope.look = o.look.value_or(place.point_mm - *o.eye_mm);
        // An eye in bright contrast agent looks at a darker wall.
        const Vec3d eye_ijk = voxel_from_world(before.grid, *o.eye_mm);
        if (!o.polarity && values.kind == ValueKind::Hounsfield &&
            sample_linear(before, eye_ijk) >= iso_hu)
            view.endoscope.polarity = Polarity::Falling;
    } else {
        view.endoscope =
            aim_endoscope(before, place.point_mm, place.push_mm, iso_hu, polarity, arena);
        if (o.look) view.endoscope.look = *o.look;
    }
    view.endoscope.iso_hu = iso_hu;
    set_look(o.look_of, view.endoscope);
    view.section.point_mm = place.point_mm;
    const double scale = length_scale(before.grid);
    view.endoscope.fog_distance_mm = scale * Endoscope{}.fog_distance_mm;
    // Zoom such that the push is at least a tenth of the picture.
    const double width_mm = before.grid.size.x * before.grid.spacing_mm.x;
    view.section.width_mm = std::min(width_mm, std::max(80 * scale, 10 * norm(place.push_mm)));
    view.caption = "before";
    const auto picture_of = [&](const Volume& volume, const std::optional<Vec3d>& tool_mm) {
        Image image = four_up_view(volume, view, kPictureSide, kPictureSide, arena);
        if (tool_mm) outline_tool(image, volume, view, *tool_mm, tool.radius_mm);
        return image;
    };
    const Image left = picture_of(before, tool.before_mm);
    // Most pages are shared with the other scan and would count twice.
    std::visit([](const auto& voxels) { voxels.let_go(); }, before.voxels);
    view.caption = "after";
    view.endoscope.rest = &rest;
    return side_by_side(left, picture_of(after, tool.after_mm));
}

}  // namespace pliant::app
