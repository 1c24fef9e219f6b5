// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Draeger2005], figure 5.9: an endoscope advances through the nose and pushes the walls aside. In
// a CT of a head, and in a phantom.

#include <pliant/chainmail.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cmath>

#include "figures.h"
#include "setups.h"

namespace pliant::results {
namespace {

constexpr int kSide_px = 300;
constexpr double kColourOf_mm = 3;  ///< displacement of the darkest colour

/// Position of the endoscope, and its push of a wall.
struct Step {
    Vec3d eye_mm, target_mm;
    Vec3d aim_mm;   ///< the wall's point is on the ray from the eye to here
    Vec3d push_mm;  ///< none: only a view
};
struct Way {
    double iso_hu, bone_hu, tool_mm, field_of_view_deg;
    std::vector<Step> steps;
};

/// Path through a real nose. Voxels of 3.2 × 3.2 × 1.5 mm close the passage at −500 HU, so the
/// threshold is −200 HU. Thin bone is averaged with its mucosa, so bone begins at 1000 HU.
Way way_through_head() {
    return {-200,
            1000,
            4,
            80,
            {{{99.2, 53.6, 82.8}, {99.4, 63.6, 83.4}, {}, {}},
             {{99.2, 53.6, 82.8}, {99.4, 63.6, 83.4}, {103, 62.6, 81}, {3, 1, 0}},
             {{99.2, 56.6, 83.1}, {99.4, 66.6, 83.4}, {103, 64.6, 85}, {3, 1, 1}},
             {{99.4, 60.6, 83.4}, {99.4, 70.6, 83.2}, {95, 66.6, 83}, {-4, 1, 0}}}};
}
Way way_through_phantom() {
    return {-500,
            600,
            3,
            75,
            {{{4.6, -44, -9}, {4.6, -30, -9.6}, {}, {}},
             {{4.6, -44, -9}, {4.6, -30, -9.6}, {0, -34, -8}, {-2.5, 0.8, 0}},
             {{4.6, -40, -9}, {4.6, -26, -9.6}, {0, -28, -10}, {-2.5, 0.8, 0}},
             {{4.6, -36, -9}, {4.6, -22, -9.6}, {9, -26, -10}, {3, 2, 0}}}};
}

struct Passage {
    Image picture;
    std::vector<PushReport> reports;
};

/// The visible surface, coloured by displacement.
Image displacement_view(const RayCaster& caster, const Endoscope& camera, const Image& view,
                        const LiveDeformation& live) {
    const Grid& grid = live.volume().grid;
    VoxelArray<float> moved_mm(voxel_count(grid));
    live.displacement_mm({{0, 0, 0}, grid.size}, moved_mm);
    const Volume field{grid, std::move(moved_mm), {}};
    Plot plot(view);
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const auto hit = caster.pick(camera, view.width, view.height, x + 0.5, y + 0.5);
            if (!hit) continue;
            const double moved = sample_linear(field, voxel_from_world(grid, hit->point_mm));
            if (moved > 0.05)
                plot.dab(x, y, shade_of(moved / kColourOf_mm),
                         0.35 + 0.5 * std::min(1.0, moved / kColourOf_mm));
        }
    return plot.image();
}

Passage advance(Volume scan, const Way& way, bool air, const TaskArena& arena) {
    ChainMailSettings settings;
    settings.scale = 1.2;
    settings.bone_threshold_hu = way.bone_hu;
    settings.air_enabled = air;
    settings.air_threshold_hu = way.iso_hu;
    Scenario s = make_scenario(std::move(scan), settings, arena);
    LiveDeformation live = LiveDeformation::create(*s.tissue).value();
    (void)live.update();
    live.keep_sources(true);
    const RayCaster rest(*s.scan, arena);
    RayCaster now(live.volume(), arena);
    std::vector<Image> before, after, moved;
    for (const Step& step : way.steps) {
        if (norm(step.push_mm) > 0) {
            const Vec3d ray = normalized(step.aim_mm - step.eye_mm);
            const auto hit = now.first_hit(step.eye_mm, ray, way.iso_hu, Polarity::Rising);
            if (!hit) continue;
            constexpr double kInside_mm = 0.6;
            s.push({hit->point_mm + kInside_mm * ray, step.push_mm, way.tool_mm});
            now.update(live.update().value().boxes);
        }
        Endoscope camera;
        camera.eye_mm = step.eye_mm;
        camera.look = step.target_mm - step.eye_mm;
        camera.field_of_view_deg = way.field_of_view_deg;
        camera.iso_hu = way.iso_hu;
        camera.fog_distance_mm = 60;
        const std::size_t number = after.size();
        const Image view = now.endoscope_view(camera, kSide_px, kSide_px);
        before.push_back(captioned(rest.endoscope_view(camera, kSide_px, kSide_px),
                                   "eye " + std::to_string(number + 1) + ", nothing pushed"));
        after.push_back(captioned(view, number == 0
                                            ? "eye 1, at rest"
                                            : "eye " + std::to_string(number + 1) +
                                                  ", after push " + std::to_string(number)));
        moved.push_back(displacement_view(now, camera, view, live));
    }
    const Image rows[] = {row_of(before, 8), row_of(after, 8), row_of(moved, 8),
                          shade_bar(kColourOf_mm, 0, "displacement of the surface [mm]")};
    return {column_of(rows, 6), s.reports};
}

}  // namespace

void add_nose(Page& page, const std::filesystem::path& scans, const TaskArena& arena) {
    page.heading(3, "Figure 5.9: through the nose");
    page.paragraph(
        "The thesis pushes the endoscope through the nose of a patient towards the sphenoid sinus: "
        "the data at rest; a first collision; a consecutive one; then one on the opposite side. "
        "Its CT is not at hand. Here are the nose of another head (`head_ct_tiny_64.nrrd`, 64 × 64 "
        "× 93 voxels of 3.2 × 3.2 × 1.5 mm) and that of `pliant phantom sinus` (160³ voxels of 0.8 "
        "mm). From left to right the eye moves forward: at rest; one wall pushed aside; the same "
        "wall again, farther in; then the opposite wall. Offset 0.2, scale factor 1.2. First row: "
        "the scan at rest from the same eye; second row: the deformed scan; third row: the same, "
        "coloured by how far the surface has moved.");
    std::vector<std::vector<std::string>> rows;
    const auto add = [&](Volume scan, const Way& way, bool air, const std::string& name,
                         const std::string& picture) {
        const Passage passage = advance(std::move(scan), way, air, arena);
        page.picture(picture, "through the nose of " + name, passage.picture);
        int number = 1;
        for (const PushReport& report : passage.reports)
            rows.push_back({name + ", push " + std::to_string(number++), air ? "on" : "off",
                            fixed_text(report.step_fraction, 3),
                            report.limited_by == LimitedBy::Bone ? "bone" : "–",
                            grouped_text(report.moved_elements)});
    };
    if (auto head = read_volume(scans / "head_ct_tiny_64.nrrd"); head.ok()) {
        page.paragraph(
            "The head, left nasal passage between septum (left in the picture) and turbinate; "
            "surface at −200 HU, bone from 1000 HU, tool: a sphere of 4 mm; air as a material of "
            "its own:");
        add(std::move(head).value(), way_through_head(), true, "the head", "draeger-5-9-head");
    } else {
        page.paragraph("The head is missing from this run: " + head.error().message);
    }
    page.paragraph(
        "The phantom, left nostril between septum (left in the picture) and turbinate; surface at "
        "−500 HU, bone from 600 HU, tool: a sphere of 3 mm. First air as in the thesis, by the law "
        "of its value; then as a material of its own:");
    for (const bool air : {false, true}) {
        PhantomSettings phantom;
        phantom.name = "sinus";
        phantom.size = {160, 160, 160};
        add(must(make_phantom(phantom, arena)).volume, way_through_phantom(), air, "the phantom",
            air ? "draeger-5-9-nose-air" : "draeger-5-9-nose");
    }
    page.table({"push", "air of its own", "done", "limited by", "moved elements"}, rows);
    page.paragraph(
        "The thesis pushes by about a voxel at a time; these pushes are 3 to 5 mm, to show, and "
        "end where the bone behind the mucosa would have to move. With air as a tissue the "
        "opposite wall moves along, as in figure 5.11.");
}

}  // namespace pliant::results
