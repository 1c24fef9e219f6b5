// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Figure 13: scans deformed through a control lattice of springs.

#include <pliant/phantom.h>
#include <pliant/spring_deformation.h>

#include <algorithm>
#include <cmath>

#include "figures.h"

namespace pliant::results {
namespace {

constexpr int kSide = 360;
constexpr std::int64_t kMostSteps = 4000;

/// One scan, one push, and how it is looked at.
struct Case {
    std::string name;
    Push push;
    SpringDeformationSettings settings;
    Vec3d middle_mm;  ///< of what the camera sees
    Vec3d look;
    double away_mm;
    double width_mm;  ///< of the section
};

struct Found {
    Image picture;
    std::vector<std::string> row;
};

Image pictures_of(const Volume& volume, const Case& c, const TaskArena& arena) {
    const Section section{.orientation = Orientation::Sagittal,
                          .point_mm = {c.push.point_mm.x, c.middle_mm.y, c.middle_mm.z},
                          .window_hu = 1200,
                          .level_hu = 100,
                          .width_mm = c.width_mm,
                          .crosshair = false};
    const Endoscope camera{.eye_mm = c.middle_mm - c.away_mm * c.look,
                           .look = c.look,
                           .up = {0, 0, 1},
                           .field_of_view_deg = 50,
                           .barrel_distortion = 0,
                           .fog_distance_mm = 0};
    const TransferFunction transfer{.window_hu = 700, .level_hu = 250, .opacity_per_mm = 0.3};
    const RayCaster caster(volume, arena);
    return side_by_side(section_view(volume, section, kSide, kSide, arena),
                        caster.blended_view(camera, transfer, kSide, kSide));
}

/// Largest movement of voxels above the value that holds nodes [mm].
double hard_movement_mm(const SpringDeformation& tissue) {
    const Grid& grid = tissue.volume().grid;
    const FieldSlices slices = displacement_slices(tissue).value();
    std::vector<Vec3f> slice(std::size_t(grid.size.x) * std::size_t(grid.size.y));
    double largest = 0;
    for (int z = 0; z < grid.size.z; ++z) {
        std::fill(slice.begin(), slice.end(), Vec3f{0, 0, 0});
        slices(z, slice);
        for (int y = 0; y < grid.size.y; ++y)
            for (int x = 0; x < grid.size.x; ++x) {
                if (tissue.volume().at({x, y, z}) <= tissue.settings().fixed_above_hu) continue;
                const Vec3f u = slice[std::size_t(x + grid.size.x * y)];
                largest = std::max(largest, std::sqrt(double(u.x * u.x + u.y * u.y + u.z * u.z)));
            }
    }
    return largest;
}

Found deform(const Volume& volume, const Case& c, const TaskArena& arena) {
    const auto tissue = value_of(SpringDeformation::create(volume, c.settings, arena));
    const PushReport pushed = value_of(tissue->push(1, c.push));
    SpringMotion motion;
    double solve_ms = pushed.solve_ms;
    std::int64_t steps = 0;
    for (; steps < kMostSteps && !motion.settled; steps += motion.steps) {
        motion = value_of(tissue->step(20));
        solve_ms += motion.solve_ms;
        if (motion.steps == 0) break;
    }
    const Deformed deformed = deform_volume(*tissue).value();
    const Vec3i nodes = tissue->control().grid().size;
    return {
        side_by_side(pictures_of(volume, c, arena), pictures_of(deformed.volume, c, arena)),
        {c.name,
         std::to_string(nodes.x) + " × " + std::to_string(nodes.y) + " × " +
             std::to_string(nodes.z),
         text_of(norm(pushed.step_fraction * c.push.push_mm), 1), text_of(steps),
         text_of(std::int64_t(motion.active_nodes)), text_of(solve_ms, 0),
         text_of(deformed.resample_ms, 1), text_of(deformed.written_voxels),
         text_of(state_of(*tissue).value().folded_cells), text_of(hard_movement_mm(*tissue), 2)}};
}

}  // namespace

void add_scans(Page& page, const std::filesystem::path& scans, const TaskArena& arena) {
    page.heading(2, "Figure 13: deformed scans");
    page.paragraph(
        "The paper shows a knee and a head, deformed through a control lattice of 10 × 10 × 10 "
        "nodes: voxels hang in its cells by trilinear weights, and nodes in hard tissue don't "
        "move. Here a phantom of a knee (`pliant phantom knee`) and a real abdomen, pushed from "
        "in front by a sphere, until all is at rest. From left to right: sagittal section and "
        "blended view at rest, the same deformed.");
    const Phantom knee = value_of(make_phantom({.name = "knee", .size = {160, 160, 200}}, arena));
    const PhantomLandmark& thigh = *std::find_if(knee.landmarks.begin(), knee.landmarks.end(),
                                                 [](const auto& l) { return l.name == "thigh"; });
    const Case knee_case{
        .name = "knee",
        .push = {.point_mm = thigh.push_point_mm, .push_mm = thigh.push_mm, .sphere_radius_mm = 16},
        .settings = {.cell_mm = 16},
        .middle_mm = {0, 0, 20},
        .look = normalized({0.8, 0.6, 0}),
        .away_mm = 210,
        .width_mm = 170};
    std::vector<std::vector<std::string>> rows;
    const auto add = [&](const Volume& volume, const Case& c, const char* file, const char* text) {
        Found found = deform(volume, c, arena);
        page.picture(file, text, found.picture);
        rows.push_back(std::move(found.row));
    };
    add(knee.volume, knee_case, "choi-13-knee", "a knee, at rest and pushed above the patella");
    if (const auto abdomen = read_volume(scans / "abdomen_ct_3mm.nii.gz"); abdomen.ok()) {
        const Case abdomen_case{
            .name = "abdomen",
            .push = {.point_mm = {0, -262, 260}, .push_mm = {0, 25, 0}, .sphere_radius_mm = 30},
            .settings = {.cell_mm = 15},
            .middle_mm = {0, -170, 260},
            .look = {1, 0, 0},
            .away_mm = 420,
            .width_mm = 300};
        add(*abdomen, abdomen_case, "choi-13-abdomen", "an abdomen, at rest and pushed in");
    } else {
        page.paragraph("The abdomen is missing from this run: " + abdomen.error().message);
    }
    page.table({"scan", "control nodes", "push [mm]", "steps", "moving nodes", "solve [ms]",
                "resample [ms]", "voxels written", "folded cells", "hard voxels moved [mm]"},
               rows);
    page.paragraph(
        "A node is fixed where the mean value around it is above 300 HU, and so are the eight "
        "nodes "
        "of a cell of which more than 5 % of the voxels are: bone that is thinner than a cell, "
        "such "
        "as the edge of the patella or a rib, would be carried along otherwise. The last column is "
        "the largest movement of any voxel above 300 HU; those that move are single ones in cells "
        "of soft tissue.");
}

}  // namespace pliant::results
