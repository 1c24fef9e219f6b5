// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Figure 13: scans deformed by a control lattice of springs.

#include <pliant/scan_files.h>
#include <pliant/tissues.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "figures.h"
#include "lit_view.h"
#include "plot.h"

namespace pliant::results {
namespace {

constexpr int kSide = 360;
constexpr std::int64_t kMaxSteps = 4000;
constexpr double kSkin_hu = -300;
constexpr int kNodes = 10;  ///< of the control lattice along each axis, as in the paper

/// Skin: from −700 HU up, and opaque within two or three millimetres.
constexpr TransferFunction kSkinTransfer{.window_hu = 1000,
                                         .level_hu = -200,
                                         .opacity_per_mm = 2,
                                         .dim = {206, 130, 106},
                                         .bright = {255, 236, 214}};

/// One scan, one push, and its views.
struct Case {
    std::string name;
    Push push;
    double cell_mm;   ///< rounded to whole voxels
    double width_mm;  ///< of the section around the push
    Vec3d look;       ///< of the camera in front of the push
    double away_mm;
    double darkest_mm;  ///< displacement of the darkest colour
};

struct Found {
    Image picture;
    std::vector<std::string> row;
};

/// A scan in one state, and the displacement of its voxels.
struct State {
    const Volume& shown;
    const Volume& moved_mm;
    double done;  ///< share of the push
};

/// Displacement of the tissue in each voxel [mm].
Volume displacement_of(const MovingScan& tissue) {
    LiveDeformation live = LiveDeformation::create(tissue).value();
    live.update().value();
    live.keep_sources(true);
    const Grid& grid = live.volume().grid;
    VoxelArray<float> moved_mm(voxel_count(grid));
    live.displacement_mm({{0, 0, 0}, grid.size}, moved_mm);
    return {grid, std::move(moved_mm), {}};
}

double value_at(const Volume& volume, Vec3d position_mm) {
    return sample_linear(volume, voxel_from_world(volume.grid, position_mm));
}

/// A sagittal plane around the push, in pixels: y to the right, z upwards.
struct SagittalPlane {
    Vec3d centre_mm;
    double width_mm;
    Vec3d world_from(double x, double y) const {
        const double mm = width_mm / kSide;
        return centre_mm + Vec3d{0, (x - 0.5 * kSide) * mm, (0.5 * kSide - y) * mm};
    }
    Point2 pixel_of(Vec3d position_mm) const {
        const double pixels = kSide / width_mm;
        const Vec3d v = position_mm - centre_mm;
        return {0.5 * kSide + v.y * pixels, 0.5 * kSide - v.z * pixels};
    }
};

enum class Extra { Sphere, Outline, Displacement };

const Ink kArrow{{250, 170, 40}, 3}, kOutline{{250, 170, 40}, 1.5};

void draw_extra(Plot& plot, const SagittalPlane& plane, const Case& c, const State& state,
                const Volume& rest, Extra extra) {
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const Vec3d here = plane.world_from(x + 0.5, y + 0.5);
            if (extra == Extra::Sphere) {
                const double r = norm(here - c.push.point_mm) - c.push.sphere_radius_mm;
                if (std::abs(r) < 0.7 * c.width_mm / kSide) plot.dab(x, y, kOutline.colour, 0.8);
            } else if (extra == Extra::Outline) {
                const bool in = value_at(rest, here) >= kSkin_hu;
                const bool right = value_at(rest, plane.world_from(x + 1.5, y + 0.5)) >= kSkin_hu;
                const bool below = value_at(rest, plane.world_from(x + 0.5, y + 1.5)) >= kSkin_hu;
                if ((in != right || in != below) && (x + y) / 5 % 2 == 0)
                    plot.dab(x, y, kOutline.colour, 1);
            } else if (value_at(state.shown, here) >= kSkin_hu) {
                const double t = value_at(state.moved_mm, here) / c.darkest_mm;
                if (t > 0.02) plot.dab(x, y, shade_of(t), 0.4 + 0.4 * std::min(t, 1.0));
            }
        }
}

/// The sagittal section through the push, with the push as an arrow.
Image section_of(const Case& c, const State& state, const Volume& rest, Extra extra,
                 const TaskArena& arena) {
    const Vec3d point = c.push.point_mm;
    const SagittalPlane plane{point + 0.2 * c.width_mm * normalized(c.push.push_mm), c.width_mm};
    const Section section{.orientation = Orientation::Sagittal,
                          .point_mm = plane.centre_mm,
                          .window_hu = 1200,
                          .level_hu = 100,
                          .width_mm = c.width_mm,
                          .crosshair = false};
    Plot plot(section_view(state.shown, section, kSide, kSide, arena));
    draw_extra(plot, plane, c, state, rest, extra);
    if (extra != Extra::Displacement)
        plot.arrow(plane.pixel_of(point), plane.pixel_of(point + c.push.push_mm), kArrow);
    const double pixels = kSide / c.width_mm;
    plot.scale_bar(20 * pixels, "20 mm", {230, 232, 236});
    return plot.image();
}

Endoscope camera_of(const Case& c) {
    return {.eye_mm = c.push.point_mm - c.away_mm * c.look,
            .look = c.look,
            .up = {0, 0, 1},
            .field_of_view_deg = 50,
            .barrel_distortion = 0,
            .iso_hu = kSkin_hu,
            .fog_distance_mm = 0};
}

Point2 pixel_of(const Endoscope& camera, Vec3d position_mm) {
    const Vec3d look = normalized(camera.look), right = normalized(cross(look, camera.up)),
                up = cross(right, look), v = position_mm - camera.eye_mm;
    const double f =
        0.5 * kSide / std::tan(0.5 * camera.field_of_view_deg * std::numbers::pi / 180);
    return {0.5 * kSide + f * dot(v, right) / dot(v, look),
            0.5 * kSide - f * dot(v, up) / dot(v, look)};
}

/// The skin in front of the camera, lit from above, with the push as an arrow.
Image skin_of(const Case& c, const State& state, bool colours, const TaskArena& arena) {
    const RayCaster caster(state.shown, arena);
    const Endoscope camera = camera_of(c);
    const SurfaceColour colour = [&](const RayHit& hit, int, int) {
        const double t = value_at(state.moved_mm, hit.point_mm) / c.darkest_mm;
        return t > 0.02 ? shade_of(t) : kSkin;
    };
    const Vec3d lamp = Vec3d{0, 0, 1} - 0.6 * c.look;
    Plot plot(lit_view(caster, camera, kSide, kSide, lamp, 1.3, colours ? colour : nullptr));
    const Vec3d tip = c.push.point_mm + state.done * c.push.push_mm;
    if (!colours)
        plot.arrow(pixel_of(camera, tip - c.push.push_mm), pixel_of(camera, tip), {kRed, 3});
    return plot.image();
}

/// @param with_push  draws the push as an arrow
Image blended_of(const Case& c, const State& state, bool with_push, const TaskArena& arena) {
    const Endoscope camera = camera_of(c);
    Plot plot(RayCaster(state.shown, arena).blended_view(camera, kSkinTransfer, kSide, kSide));
    if (with_push) {
        const Vec3d tip = c.push.point_mm;
        plot.arrow(pixel_of(camera, tip - c.push.push_mm), pixel_of(camera, tip), kArrow);
    }
    return plot.image();
}

/// Absolute difference of two pictures: white is zero.
Image difference_of(const Image& a, const Image& b) {
    Image image = a;
    for (std::size_t n = 0; n < image.pixels.size(); ++n) {
        const auto channel = [](int p, int q) {
            constexpr int kGain = 3;
            return std::uint8_t(std::max(0, 255 - kGain * std::abs(p - q)));
        };
        image.pixels[n] = {channel(a.pixels[n].r, b.pixels[n].r),
                           channel(a.pixels[n].g, b.pixels[n].g),
                           channel(a.pixels[n].b, b.pixels[n].b)};
    }
    return image;
}

Image pictures_of(const Case& c, const State& rest, const State& now, const TaskArena& arena) {
    const Image sections[] = {
        captioned(section_of(c, rest, rest.shown, Extra::Sphere, arena), "section at rest, push"),
        captioned(section_of(c, now, rest.shown, Extra::Outline, arena),
                  "deformed; dashed: at rest"),
        captioned(section_of(c, now, rest.shown, Extra::Displacement, arena), "displacement")};
    const Image skins[] = {captioned(skin_of(c, rest, false, arena), "skin at rest, push"),
                           captioned(skin_of(c, now, false, arena), "deformed"),
                           captioned(skin_of(c, now, true, arena), "displacement")};
    const Image before = blended_of(c, rest, false, arena),
                after = blended_of(c, now, false, arena);
    const Image blended[] = {captioned(blended_of(c, rest, true, arena), "blended, at rest, push"),
                             captioned(after, "deformed"),
                             captioned(difference_of(before, after), "difference, threefold")};
    const Image rows[] = {row_of(sections), row_of(skins), row_of(blended),
                          shade_bar(c.darkest_mm, 0, "displacement [mm]")};
    return column_of(rows, 6);
}

/// Largest movement of voxels above the threshold of fixed nodes [mm].
double hard_movement_mm(const Tissue& tissue) {
    const Grid& grid = tissue.volume().grid;
    const FieldSlices slices = displacement_slices(tissue).value();
    std::vector<Vec3f> slice(std::size_t(grid.size.x) * std::size_t(grid.size.y));
    double largest = 0;
    for (int z = 0; z < grid.size.z; ++z) {
        std::fill(slice.begin(), slice.end(), Vec3f{0, 0, 0});
        slices(z, slice);
        for (int y = 0; y < grid.size.y; ++y)
            for (int x = 0; x < grid.size.x; ++x) {
                if (tissue.volume().at({x, y, z}) <= SpringDeformationSettings{}.fixed_hu) continue;
                const Vec3f u = slice[std::size_t(x + grid.size.x * y)];
                largest = std::max(largest, std::sqrt(double(u.x * u.x + u.y * u.y + u.z * u.z)));
            }
    }
    return largest;
}

/// The voxels between kNodes nodes along each axis, around a point as far as the scan allows.
Box3i region_of(const Volume& volume, const Case& c) {
    const Vec3d middle = voxel_from_world(volume.grid, c.push.point_mm);
    Box3i region;
    for (int a = 0; a < 3; ++a) {
        const int cell = int(std::lround(c.cell_mm / volume.grid.spacing_mm[a]));
        const int side = (kNodes - 1) * cell + 1;
        region.begin[a] = std::clamp(int(std::lround(middle[a])) - side / 2, 0,
                                     std::max(0, volume.grid.size[a] - side));
        region.end[a] = region.begin[a] + side;
    }
    return region;
}

Found deform(const Volume& volume, const Case& c, const TaskArena& arena) {
    const auto tissue = value_of(
        make_springs(volume, {.region = region_of(volume, c), .cell_mm = c.cell_mm}, arena));
    const PushReport pushed = value_of(tissue->push(1, c.push));
    AdvanceReport motion;
    double solve_ms = pushed.solve_ms;
    std::int64_t steps = 0;
    for (; steps < kMaxSteps && !motion.settled; steps += motion.steps) {
        motion = value_of(tissue->advance({.max_steps = 20}));
        solve_ms += motion.ms;
        if (motion.steps == 0) break;
    }
    const Deformed deformed = deform_volume(*tissue).value();
    const Record figures = tissue->figures();
    const auto& nodes = std::get<std::vector<double>>(figures[0].value);
    Volume still{volume.grid, VoxelArray<float>(voxel_count(volume.grid)), {}};
    const Volume moved_mm = displacement_of(*tissue);
    return {pictures_of(c, {volume, still, 0}, {deformed.volume, moved_mm, pushed.step_fraction},
                        arena),
            {c.name, fixed_text(c.cell_mm, 0),
             fixed_text(nodes[0], 0) + " × " + fixed_text(nodes[1], 0) + " × " +
                 fixed_text(nodes[2], 0),
             fixed_text(norm(pushed.step_fraction * c.push.push_mm), 1), grouped_text(steps),
             grouped_text(std::get<std::int64_t>(figures[1].value)), fixed_text(solve_ms, 0),
             fixed_text(deformed.resample_ms, 1), grouped_text(deformed.written_voxels),
             grouped_text(state_of(*tissue).value().folded_cells),
             fixed_text(hard_movement_mm(*tissue), 2)}};
}

Case knee_case(const Phantom& knee) {
    const PhantomLandmark& thigh = *std::find_if(knee.landmarks.begin(), knee.landmarks.end(),
                                                 [](const auto& l) { return l.name == "thigh"; });
    return {.name = "knee",
            .push = {.point_mm = thigh.push_point_mm - Vec3d{0, 0, 12},
                     .push_mm = {0, 15, 0},
                     .sphere_radius_mm = 20},
            .cell_mm = 16,
            .width_mm = 130,
            .look = normalized({0.75, 0.65, -0.15}),
            .away_mm = 120,
            .darkest_mm = 15};
}

Case head_case() {
    return {.name = "head",
            .push = {.point_mm = {99, 23.6, 74}, .push_mm = {0, 11, 4}, .sphere_radius_mm = 16},
            .cell_mm = 15,
            .width_mm = 120,
            .look = normalized({0.8, 0.75, -0.1}),
            .away_mm = 110,
            .darkest_mm = 12};
}

Case abdomen_case() {
    return {.name = "abdomen",
            .push = {.point_mm = {0, -262, 260}, .push_mm = {0, 32, 0}, .sphere_radius_mm = 36},
            .cell_mm = 24,
            .width_mm = 240,
            .look = normalized({0.75, 0.65, -0.15}),
            .away_mm = 230,
            .darkest_mm = 32};
}

}  // namespace

void add_scans(Page& page, const std::filesystem::path& scans, const TaskArena& arena) {
    page.heading(2, "Figure 13: deformed scans");
    page.paragraph(
        "The paper shows a knee and a head, deformed through a control lattice of 10 × 10 × 10 "
        "nodes: voxels hang in its cells by trilinear weights, and nodes in hard tissue don't "
        "move. Here a phantom of a knee (`pliant phantom knee`), a real head "
        "(`head_ct_tiny_64.nrrd`) and a real abdomen, pushed by a sphere until all is at rest. "
        "Each lattice has 10 × 10 × 10 nodes too; it lies around the push and not over the whole "
        "scan, since its cells are cubes. "
        "Upper row: sagittal section through the push, with the sphere's outline and the requested "
        "push as an arrow; the same deformed, dashed the surface at rest (−300 HU); how far the "
        "tissue has moved. Middle row: the skin by a lamp from above. Lower row: the blended "
        "view that the paper shows, with the opacity of skin, at rest and deformed, and the "
        "difference of the two, threefold, dark where they differ.");
    const Phantom knee = value_of(make_phantom({.name = "knee", .size = {160, 160, 200}}, arena));
    std::vector<std::vector<std::string>> rows;
    const auto add = [&](const Volume& volume, const Case& c, const char* file, const char* text) {
        Found found = deform(volume, c, arena);
        page.picture(file, text, found.picture);
        rows.push_back(std::move(found.row));
    };
    add(knee.volume, knee_case(knee), "choi-13-knee",
        "a knee, at rest and pushed above the patella");
    const auto add_scan = [&](const char* name, const Case& c, const char* file, const char* text) {
        const auto scan = read_volume(scans / name);
        if (scan.ok())
            add(*scan, c, file, text);
        else
            page.paragraph("The " + c.name + " is missing from this run: " + scan.error().message);
    };
    add_scan("head_ct_tiny_64.nrrd", head_case(), "choi-13-head",
             "a head, at rest and with its nose pushed");
    add_scan("abdomen_ct_3mm.nii.gz", abdomen_case(), "choi-13-abdomen",
             "an abdomen, at rest and pushed in");
    page.table(
        {"scan", "cells [mm]", "control nodes", "push [mm]", "steps", "moving nodes", "solve [ms]",
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
