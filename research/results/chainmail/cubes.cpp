// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// [Draeger2005, 5.2]: the cubes. Each picture shows the deformed scan, from outside by ray casting
// or in a section with the deformed lattice.

#include <pliant/chainmail.h>
#include <pliant/resample.h>
#include <pliant/volume.h>

#include <cmath>
#include <numbers>

#include "figures.h"
#include "lit_view.h"
#include "setups.h"

namespace pliant::results {
namespace {

constexpr int kView = 420;  ///< pixels of a picture's side
constexpr double kIso_hu = -500;

struct View {
    Vec3d eye_mm, target_mm;
    double field_of_view_deg = 40;
};

/// The surface of the deformed scan from outside, without an endoscope's distortion.
Image virtual_view(const Volume& volume, const View& view, const TaskArena& arena) {
    Endoscope camera;
    camera.eye_mm = view.eye_mm;
    camera.look = view.target_mm - view.eye_mm;
    camera.field_of_view_deg = view.field_of_view_deg;
    camera.barrel_distortion = 0;
    camera.fog_distance_mm = 0;
    return RayCaster(volume, arena).endoscope_view(camera, kView, kView);
}

/// From above and the left, at a flat angle, so that the light at the camera shows the relief.
View close_view(Vec3d position_mm) {
    return {position_mm + Vec3d{-17, -13, 13}, position_mm, 46};
}

/// Section z = constant or x = constant through a position: the deformed scan, and the lattice.
Image cut_picture(const Scenario& s, Vec3d position_mm, int across, int down, double half_mm,
                  double largest_mm) {
    const Vec3d ijk = voxel_from_world(s.scan->grid, position_mm);
    Slice slice{across, down, 0};
    slice.index = int(std::floor(ijk[slice.third()]));
    const Window window = window_around(slice, s.scan->grid, ijk, half_mm);
    const Point2 middle{ijk[across] * s.scan->grid.spacing_mm[across],
                        ijk[down] * s.scan->grid.spacing_mm[down]};
    Plot plot(kView, kView, {middle.x - half_mm, middle.y - half_mm},
              {middle.x + half_mm, middle.y + half_mm});
    draw_values(plot, deform_volume(*s.tissue).value().volume, slice, 9000, -2500);
    draw_lattice(plot, *s.tissue, slice, window, {largest_mm, 1, 1.6});
    return plot.image();
}

/// Section of the deformed scan in the thesis's style: grey values, the surface (red) and the
/// surface at rest (blue).
Image section_picture(const Scenario& s, Vec3d position_mm, int across, int down, double half_mm) {
    const Grid& grid = s.scan->grid;
    const Vec3d ijk = voxel_from_world(grid, position_mm);
    Slice slice{across, down, 0};
    slice.index = int(std::floor(ijk[slice.third()]));
    const Point2 middle{ijk[across] * grid.spacing_mm[across], ijk[down] * grid.spacing_mm[down]};
    constexpr double kFlat = 0.45;  // ratio of the picture's height to its width
    Plot plot(kView, int(kFlat * kView), {middle.x - half_mm, middle.y - kFlat * half_mm},
              {middle.x + half_mm, middle.y + kFlat * half_mm});
    const Volume deformed = deform_volume(*s.tissue).value().volume;
    draw_values(plot, deformed, slice, 2600, 300);
    const Window window = window_around(slice, grid, ijk, half_mm + 2);
    draw_contour(plot, values_in(*s.scan, slice, window), kIso_hu, {{120, 170, 220}, 1.2, 1});
    draw_contour(plot, values_in(deformed, slice, window), kIso_hu, {{255, 120, 90}, 1.8, 1});
    plot.scale_bar(10, "10 mm", {255, 255, 255});
    return plot.image();
}

/// Contours of the displacement along the push, in a plane perpendicular to it.
Image contour_picture(const Scenario& s, Vec3d position_mm, int across, int down, double half_mm,
                      double push_mm) {
    const Grid& grid = s.scan->grid;
    const Vec3d ijk = voxel_from_world(grid, position_mm);
    Slice slice{across, down, 0};
    slice.index = int(std::floor(ijk[slice.third()]));
    const Window window = window_around(slice, grid, ijk, half_mm);
    const double a = (std::floor(ijk[across]) + 0.5) * grid.spacing_mm[across];
    const double d = (std::floor(ijk[down]) + 0.5) * grid.spacing_mm[down];
    Plot plot(kView, kView, {a - half_mm, d - half_mm}, {a + half_mm, d + half_mm});
    for (int y = window.down_begin; y < window.down_end; ++y)
        for (int x = window.across_begin; x < window.across_end; ++x)
            plot.dot({x * grid.spacing_mm[across], y * grid.spacing_mm[down]}, 1.3, kFaint);
    const auto field = displacement_along(*s.tissue, slice, window, kThesisPush_mm);
    for (int n = 1; n < 10; ++n)
        draw_contour(plot, field, 0.1 * n * push_mm, {shade_of(0.1 * n), n == 5 ? 3.0 : 1.2, 1});
    const double mean = contour_around(field, {a, d}, 0.5 * push_mm).mean_mm;
    std::vector<Point2> circle;
    for (int n = 0; n < 96; ++n)
        circle.push_back(
            {a + mean * std::cos(n * 0.0654498469), d + mean * std::sin(n * 0.0654498469)});
    for (std::size_t n = 0; n < circle.size(); n += 2)
        plot.line(circle[n], circle[n + 1], {kRed, 1.4, 1});
    return plot.image();
}

std::string percent(double share) {
    return fixed_text(100 * share, 1) + " %";
}

/// Extent of a contour along the picture's x and y, from side to side.
double extent(const Contour& c, std::size_t quarter) {
    const std::size_t n = c.radii_mm.size();
    return c.radii_mm[quarter * n / 4] + c.radii_mm[(quarter + 2) * n / 4];
}

void add_z_scale(Page& page, const TaskArena& arena) {
    page.heading(3, "Figures 5.1, 5.2 and 5.3: the cube, and thick slices");
    page.paragraph(
        "The thesis's cube has the value 2000 on its scale (1000 HU) and is pushed by (0, 1, 0) "
        "times the scale factor; here it is 60 mm wide, and pixels are 1 mm. Slices are 2.2 mm "
        "apart, the offset is 0.25, the scale factor 1.2. Left: as the thesis has it without its "
        "z-scale adjustment, limits along z are those along x in millimetres; it says that the "
        "deformation is stretched along z. Middle and right: limits in proportion to the distance "
        "of the "
        "slices, which is what the adjustment restores and what Pliant always does; and the same "
        "with rounded limits, which the thesis does not have. First row: the surface from outside "
        "(5.2). Second and third row: the cutting planes through the tool (5.3), z and x to the "
        "right, the push downwards; red: the surface at −500 HU; blue: the same at rest. Fourth "
        "row: contours of the displacement in the plane perpendicular to the push, x to the right "
        "and z down, at 10 % to 90 % of the push; thick: half of it; red: the circle of the same "
        "mean radius; dots: elements at rest.");
    std::vector<Image> views, sections_z, sections_x, contours;
    std::vector<std::vector<std::string>> rows;
    CubeSettings cube{.offset = 0.25, .z_scale = 2.2, .z_adjusted = false};
    const auto add = [&](const char* name) {
        Scenario s = cube_scenario(cube, arena);
        s.push({kFace_mm, kThesisPush_mm});
        const std::string caption(name);
        views.push_back(captioned(
            virtual_view(deform_volume(*s.tissue).value().volume, close_view(kFace_mm), arena),
            caption));
        sections_z.push_back(
            captioned(section_picture(s, kFace_mm, 2, 1, 18), caption + ": z to the right"));
        sections_x.push_back(
            captioned(section_picture(s, kFace_mm, 0, 1, 18), caption + ": x to the right"));
        contours.push_back(
            captioned(contour_picture(s, kFace_mm, 0, 2, 20, 1.2), caption + ": x, z"));
        const Contour c = roundness_of(s, kFace_mm, 1.2).across_push;
        rows.push_back({name, grouped_text(s.reports[0].moved_elements),
                        fixed_text(extent(c, 0), 2), fixed_text(extent(c, 1), 2),
                        fixed_text(extent(c, 1) / extent(c, 0), 2)});
    };
    add("not adjusted");
    cube.z_adjusted = true;
    add("in proportion");
    cube.limits = LinkLimits::Rounded;
    add("in proportion, rounded");
    page.picture("draeger-5-2-z-scale", "surface: not adjusted, in proportion, rounded",
                 row_of(views));
    const Image cuts[] = {row_of(sections_z), row_of(sections_x)};
    page.picture("draeger-5-3-sections",
                 "cutting planes along z and along x: not adjusted, in proportion, rounded",
                 column_of(cuts));
    page.picture("draeger-5-3-z-scale", "contours: not adjusted, in proportion, rounded",
                 row_of(contours));
    page.table({"limits along z", "moved elements", "extent along x [mm]", "along z [mm]", "z : x"},
               rows);
    page.paragraph(
        "Extents are of the contour at half the push. Without the adjustment the deformation is "
        "stretched, as the thesis says; with it what is left is the size of the grabbed cell, "
        "which "
        "is 2.2 times as long along z. The thesis sees the same rest and explains it by the "
        "discrete steps.");
}

void add_angular(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 5.4: an angular push");
    page.paragraph(
        "The thesis does not name the vector; here it is (0.8, 1, 0), offset 0.2, scale factor "
        "1.2. "
        "Left: the surface; middle: the plane z = 0, tool from above; right: the same with the "
        "straight push (0, 1, 0). The thesis says that the middle moves along with the force, and "
        "that the flank on the pushed side is steeper.");
    Scenario angular = cube_scenario({}, arena), straight = cube_scenario({}, arena);
    angular.push({kFace_mm, {0.8, 1, 0}});
    straight.push({kFace_mm, kThesisPush_mm});
    const Image pictures[] = {
        virtual_view(deform_volume(*angular.tissue).value().volume, close_view(kFace_mm), arena),
        cut_picture(angular, kFace_mm + Vec3d{0, 6, 0}, 0, 1, 13, 1.5),
        cut_picture(straight, kFace_mm + Vec3d{0, 6, 0}, 0, 1, 13, 1.5)};
    page.picture("draeger-5-4-angular", "an angular push and a straight one", row_of(pictures));
    // The face's elements in the row through the tool; slopes are depth over distance.
    const Vec3d ijk = voxel_from_world(angular.scan->grid, kFace_mm);
    double steepest[2] = {0, 0};
    for (int x = 20; x < 80; ++x) {
        const auto place = [&](int n) {
            const Vec3i e{n, int(std::floor(ijk.y)), int(std::floor(ijk.z))};
            const Vec3d u = angular.tissue->displacement_mm(e);
            return Point2{n + u.x, u.y};
        };
        const Point2 a = place(x), b = place(x + 1);
        double& slope = steepest[b.y > a.y ? 0 : 1];
        slope = std::max(slope, std::abs(b.y - a.y) / (b.x - a.x));
    }
    page.paragraph("Steepest slope behind the tool: " + fixed_text(steepest[0], 3) +
                   "; before it, where it pushes: " + fixed_text(steepest[1], 3) +
                   ". The push compresses the links before the tool and stretches those behind it, "
                   "so the flank before it is the steeper one, as in the thesis.");
}

constexpr double kDeepest_mm = 1.5;  ///< depth of the darkest colour in figure 5.5

/// Frontal view of the face with a lamp at its upper left: relief, and depth in colours.
Image relief(const Scenario& s, const std::string& caption, const TaskArena& arena) {
    constexpr double kAway_mm = 60, kAngle_deg = 46;
    const Volume deformed = deform_volume(*s.tissue).value().volume;
    const RayCaster before(*s.scan, arena), after(deformed, arena);
    Endoscope camera;
    camera.eye_mm = {-7, kFace_mm.y - kAway_mm, 4};
    camera.look = {0, 1, 0};
    camera.field_of_view_deg = kAngle_deg;
    camera.barrel_distortion = 0;
    constexpr Vec3d kLamp{-1, -0.45, 1};
    constexpr double kGain = 1.8;
    const auto depth_colour = [&](const RayHit& hit, int x, int y) {
        const auto rest = before.pick(camera, kView, kView, x + 0.5, y + 0.5);
        const double depth = rest ? hit.point_mm.y - rest->point_mm.y : 0;
        return depth > 0.02 ? shade_of(depth / kDeepest_mm) : kSkin;
    };
    Plot seen(lit_view(after, camera, kView, kView, kLamp, kGain));
    const double pixels =
        kView / (2 * kAway_mm * std::tan(0.5 * kAngle_deg * std::numbers::pi / 180));
    seen.scale_bar(10 * pixels, "10 mm");
    const Image parts[] = {
        captioned(seen.image(), caption),
        captioned(lit_view(after, camera, kView, kView, -camera.look, 1, depth_colour),
                  "depth of the surface")};
    return column_of(parts, 6);
}

void add_subsequent(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 5.5: pushes one after the other");
    page.paragraph(
        "Offset 0.1, scale factor 1.2. Left: one push. Right: a second one at the same position "
        "and "
        "two more to the upper left. Upper row: the face from the front, by a lamp at its upper "
        "left; lower row: how deep the surface lies below its position at rest. The thesis does "
        "not name its movement limit; here it is 2 mm, "
        "of which this material gets 1.52.");
    CubeSettings settings{.offset = 0.1, .max_movement_mm = 2};
    Scenario s = cube_scenario(settings, arena);
    s.push({kFace_mm, kThesisPush_mm});
    std::vector<Image> pictures{relief(s, "one push", arena)};
    const std::pair<const char*, Vec3d> positions[] = {{"the middle again", {0, 0, 0}},
                                                       {"upper left", {-7, 0, 7}},
                                                       {"farther to the upper left", {-14, 0, 9}}};
    std::vector<std::vector<std::string>> rows{{"the middle",
                                                fixed_text(s.reports[0].step_fraction, 3),
                                                grouped_text(s.reports[0].moved_elements)}};
    for (const auto& [name, away] : positions) {
        const PushReport& report = s.push({kFace_mm + away + Vec3d{0, 1, 0}, kThesisPush_mm});
        rows.push_back(
            {name, fixed_text(report.step_fraction, 3), grouped_text(report.moved_elements)});
    }
    pictures.push_back(relief(s, "four pushes", arena));
    const Image parts[] = {row_of(pictures), shade_bar(kDeepest_mm, 1, "depth [mm]")};
    page.picture("draeger-5-5-subsequent", "one push, and four", column_of(parts, 6));
    page.table({"push", "done", "moved elements"}, rows);
    page.paragraph(
        "As in the thesis: the second push in the middle is cut short by the movement limit, and "
        "those beside it go farther, because less of the limit is used up there; the outline is "
        "angular.");
}

void add_edge(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 5.6: near an edge");
    page.paragraph(
        "A push 1.5 mm below the cube's upper edge, offset 0.2, scale factor 1.2. Left: along the "
        "push; right: onto the edge.");
    Scenario s = cube_scenario({}, arena);
    const Vec3d place{0, -29.5, 28.5};
    s.push({place, kThesisPush_mm});
    const Volume deformed = deform_volume(*s.tissue).value().volume;
    const Image pictures[] = {
        virtual_view(deformed, {place + Vec3d{0, -30, 0}, place, 44}, arena),
        virtual_view(deformed, {place + Vec3d{-17, -13, 13}, place, 46}, arena)};
    page.picture("draeger-5-6-edge", "a push near the edge, from the front and from above",
                 row_of(pictures));
    page.paragraph(
        "As in the thesis, the edge is drawn along towards the tool: shear carries the motion up "
        "to it and over it.");
}

std::vector<std::string> dent_row(const std::string& name, const std::string& threshold,
                                  const Scenario& s, const Dent& dent) {
    return {name,
            threshold,
            grouped_text(s.reports[0].moved_elements),
            fixed_text(dent.depth_mm, 2),
            fixed_text(dent.volume_mm3, 1),
            fixed_text(dent.half_below_mm, 2) + ", " + fixed_text(dent.half_above_mm, 2),
            fixed_text(dent.slope, 2),
            fixed_text(dent.area_mm2, 0)};
}

/// Pushes in the halves and on the border: pictures, and one row for each threshold.
void add_dents(Page& page, const TaskArena& arena) {
    const struct {
        const char* name;
        Vec3d position_mm;
        StiffHalf stiff;
    } pushes[] = {{"border", kBorder_mm, StiffHalf::Graded},
                  {"soft half", kSoft_mm, StiffHalf::Even},
                  {"stiff half", kStiff_mm, StiffHalf::Even}};
    std::vector<Image> views, contours;
    std::vector<std::vector<std::string>> rows;
    for (const auto& push : pushes) {
        Scenario s = layers_scenario(push.stiff, arena);
        s.push({push.position_mm, kThesisPush_mm});
        views.push_back(captioned(virtual_view(deform_volume(*s.tissue).value().volume,
                                               close_view(push.position_mm), arena),
                                  push.name));
        contours.push_back(
            captioned(contour_picture(s, push.position_mm, 0, 2, 14, 1.2),
                      std::string(push.name) + ": displacement of elements, x and z"));
        for (const double threshold : {kIso_hu, -100.0})
            rows.push_back(dent_row(push.name, fixed_text(threshold, 0), s,
                                    dent_of(s, push.position_mm, threshold, arena)));
    }
    page.picture("draeger-5-7-materials", "border, soft half, stiff half", row_of(views));
    Scenario border = layers_scenario(StiffHalf::Graded, arena);
    border.push({kBorder_mm, kThesisPush_mm});
    Scenario both = layers_scenario(StiffHalf::Even, arena);
    both.push({kSoft_mm, kThesisPush_mm});
    both.push({kStiff_mm, kThesisPush_mm});
    const Image sections[] = {
        captioned(section_picture(border, kBorder_mm, 2, 1, 10), "5.7: the border, z to the right"),
        captioned(section_picture(both, kBorder_mm, 2, 1, 27),
                  "5.8: stiff half (left), soft half (right)")};
    const Image closer[] = {
        captioned(section_picture(both, kStiff_mm, 2, 1, 10), "5.8: the stiff half, closer"),
        captioned(section_picture(both, kSoft_mm, 2, 1, 10), "5.8: the soft half, closer")};
    const Image all[] = {row_of(sections), row_of(closer)};
    page.picture("draeger-5-8-sections", "cutting planes through the dents", column_of(all));
    page.picture("draeger-5-8-materials", "contours at the same positions", row_of(contours));
    page.table({"push in", "surface at [HU]", "moved elements", "depth [mm]", "volume [mm³]",
                "half depth reached towards −z, +z [mm]", "steepest slope", "area dented [mm²]"},
               rows);
}

/// The dents from displacements of the elements, without resampling, in a sentence.
std::string unresampled_dents(const TaskArena& arena) {
    const auto dent = [&](StiffHalf stiff, Vec3d position_mm) {
        Scenario s = layers_scenario(stiff, arena);
        s.push({position_mm, kThesisPush_mm});
        return moved_dent_of(s, position_mm, kIso_hu, arena);
    };
    const Dent border = dent(StiffHalf::Graded, kBorder_mm);
    const Dent soft = dent(StiffHalf::Even, kSoft_mm), stiff = dent(StiffHalf::Even, kStiff_mm);
    return "Without resampling, where the points of the surface at rest (−500 HU) move with the "
           "elements around them, the half widths turn round, " +
           fixed_text(soft.half_above_mm, 2) + " mm in the soft half and " +
           fixed_text(stiff.half_above_mm, 2) + " mm in the stiff one, at the border " +
           fixed_text(border.half_above_mm, 2) + " mm towards the soft half and " +
           fixed_text(border.half_below_mm, 2) + " mm towards the stiff one, and the volumes are " +
           fixed_text(soft.volume_mm3, 1) + " and " + fixed_text(stiff.volume_mm3, 1) +
           " mm³: the volume agrees with the thesis in the resampled scan at −100 HU only.";
}

void add_materials(Page& page, const TaskArena& arena) {
    page.heading(3, "Figures 5.7 and 5.8: two materials");
    page.paragraph(
        "A cuboid with the value 1000 in its upper half (thesis scale; 0 HU) and a higher one in "
        "its lower half, offset 0.2, scale factor 1.2. First a push on the border to values of "
        "2000 to 2500 (5.7); then one push in the soft half and one in a stiff half of 2000 (5.8). "
        "Upper row: the surface from outside. Below: the cutting planes through the tool, z to the "
        "right and the push downwards; red: the surface at −500 HU; blue: the same at rest. Last "
        "row: contours of the elements' displacement, z down.");
    add_dents(page, arena);
    page.paragraph(
        "The thesis looks at the surface that the ray caster shows, so this table measures that "
        "surface: the first crossing of a threshold along the push, in the scan at rest and in the "
        "deformed one. At the border the dent reaches farther into the soft half (+z) than into "
        "the stiff one, as the thesis says (5.7). The softer half's dent is the deeper one, and "
        "wider at half of its depth, at "
        "either threshold (5.8); its volume is clearly larger at −100 HU, and the same within a "
        "few percent at −500 HU. It "
        "is also the "
        "steeper one at a threshold near the soft material's own value (−100 HU), which is what "
        "the thesis describes; at −500 HU the stiff half has the steeper flank. The *elements* "
        "tell another story: the stiff material moves more of them, because its smaller play "
        "carries the motion farther, as in the thesis's table 6.2; so the foot of its dent (the "
        "area deeper than " +
        fixed_text(kDented_mm, 1) +
        " mm) is the wider one. The surface differs from the elements because the ray caster sees "
        "the resampled scan: its crossing lies between the outermost tissue and air, whose "
        "elements are soft and follow less, at a position that depends on the threshold. " +
        unresampled_dents(arena));
}

void add_stages(Page& page, const TaskArena& arena) {
    page.heading(3, "Figure 5.10: stages");
    page.paragraph(
        "A large push with a large offset: 0.25, scale factor 2.5. The thesis shows stages between "
        "the moved elements, and blames the cubic chain regions. Left: the surface; middle: the "
        "plane z = 0; right: contours in the plane perpendicular to the push. Upper row: box "
        "limits, as in the thesis; lower row: rounded limits.");
    for (const bool rounded : {false, true}) {
        CubeSettings cube{.offset = 0.25, .scale = 2.5};
        cube.limits = rounded ? LinkLimits::Rounded : LinkLimits::Box;
        Scenario s = cube_scenario(cube, arena);
        s.push({kFace_mm, kThesisPush_mm});
        const Image pictures[] = {
            virtual_view(deform_volume(*s.tissue).value().volume, close_view(kFace_mm), arena),
            cut_picture(s, kFace_mm + Vec3d{0, 8, 0}, 0, 1, 17, 2.5),
            contour_picture(s, kFace_mm, 0, 2, 17, 2.5)};
        page.picture(rounded ? "draeger-5-10-stages-rounded" : "draeger-5-10-stages",
                     rounded ? "rounded limits: surface, section, contours"
                             : "box limits: surface, section, contours",
                     row_of(pictures));
    }
}

void add_roundness(Page& page, const TaskArena& arena) {
    page.heading(3, "How round: figures 5.2, 5.3 and 5.10 in numbers");
    page.paragraph(
        "The contour of half the push around the grabbed cell, in a solid of the cube's material "
        "without a surface. Deviation from a circle: (largest − smallest radius) / mean radius, "
        "over 360 angles. A circle has 0, a square 37 %.");
    std::vector<std::vector<std::string>> rows;
    for (const double z_scale : {1.0, 2.2})
        for (const auto& [offset, scale] : {std::pair{0.25, 1.2}, {0.25, 2.5}, {0.1, 1.2}}) {
            std::vector<std::string> row{fixed_text(z_scale, 1), fixed_text(offset, 2),
                                         fixed_text(scale, 1)};
            for (const LinkLimits limits : {LinkLimits::Box, LinkLimits::Rounded}) {
                Scenario s = solid_scenario(
                    {.offset = offset, .scale = scale, .z_scale = z_scale, .limits = limits},
                    arena);
                s.push({{0, 0, 0}, kThesisPush_mm});
                const Roundness r = roundness_of(s, {0, 0, 0}, scale);
                row.push_back(fixed_text(r.across_push.mean_mm, 2));
                for (const Contour* c : {&r.across_push, &r.along_push, &r.along_push_in_z})
                    row.push_back(percent(c->deviation));
            }
            rows.push_back(row);
        }
    page.table({"z-scale", "offset", "scale", "box: mean radius, xz [mm]", "xz", "xy", "zy",
                "rounded: mean radius, xz [mm]", "xz", "xy", "zy"},
               rows);
    page.paragraph(
        "Box limits stay near the square that they must tend to for long pushes; the shorter the "
        "push, the more the grabbed cell rounds it. What is left with rounded limits comes from "
        "the "
        "grabbed cell's own shape, which with thick slices is 2.2 times as long along z, and from "
        "the one-sided differences of the first steps around it. The thesis soothes the stages "
        "with "
        "a smaller offset, at the price of many more elements; the third and sixth rows show that "
        "the contour does not get rounder by it.");
    page.paragraph(
        "The contours of the fifth row (z-scale 2.2, offset 0.25, scale 2.5) in the planes xz, xy "
        "and zy, box limits above and rounded limits below:");
    for (const LinkLimits limits : {LinkLimits::Box, LinkLimits::Rounded}) {
        Scenario s =
            solid_scenario({.offset = 0.25, .scale = 2.5, .z_scale = 2.2, .limits = limits}, arena);
        s.push({{0, 0, 0}, kThesisPush_mm});
        const Image pictures[] = {contour_picture(s, {0, 0, 0}, 0, 2, 17, 2.5),
                                  contour_picture(s, {0, 0, 0}, 0, 1, 17, 2.5),
                                  contour_picture(s, {0, 0, 0}, 2, 1, 17, 2.5)};
        const bool rounded = limits == LinkLimits::Rounded;
        page.picture(rounded ? "contours-rounded" : "contours-box",
                     rounded ? "rounded limits, three planes" : "box limits, three planes",
                     row_of(pictures));
    }
}

}  // namespace

void add_cubes(Page& page, const TaskArena& arena) {
    page.heading(2, "Dräger 2005, chapter 5: the cubes");
    page.paragraph(
        "[Draeger2005] pushes artificial cubes first. The vector is (0, 1, 0) in voxels, offset "
        "0.2 "
        "and scale factor 1.2 unless stated otherwise; so it is here. Its pictures come from the "
        "cubes' surface at a threshold; here the threshold is −500 HU. The tool pushes into the "
        "cube's face. Below, grid lines and dots are links and elements, pale at rest and dark "
        "where they moved farthest.");
    add_z_scale(page, arena);
    add_angular(page, arena);
    add_subsequent(page, arena);
    add_edge(page, arena);
    add_materials(page, arena);
    add_stages(page, arena);
    add_roundness(page, arena);
}

}  // namespace pliant::results
