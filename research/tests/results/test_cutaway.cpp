// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vessels that are cut open, and the catheter's tip that loses volume without its constraints.
// Covers: results_pbd/cutaway.cpp.

#include "cutaway.h"

#include <gtest/gtest.h>
#include <pliant/core/tasks.h>

#include <cmath>

#include "pressed.h"
#include "tube_mesh.h"

namespace pliant::results {
namespace {

constexpr Rgb8 kPurple{120, 10, 200};
constexpr Camera kEnd{.right = 0, .up = 1, .low = {-10, -10}, .high = {10, 10}, .px_per_mm = 20};

bool is_purple(Rgb8 p) {
    return p.r + 40 < p.b && p.g + 40 < p.r;
}

/// Pixels of a cut that is coloured purple, as an area [mm²].
double purple_mm2(const Image& image, double px_per_mm) {
    double count = 0;
    for (const Rgb8 p : image.pixels) count += is_purple(p);
    return count / (px_per_mm * px_per_mm);
}

Image cut_of(const TetMesh& mesh, Camera camera) {
    Cutaway cutaway(camera);
    cutaway.wall(mesh, mesh.nodes_mm, displacements_of(mesh, mesh.nodes_mm),
                 [](double) { return kPurple; });
    return cutaway.image("");
}

TEST(Cutaway, ACutAcrossATubeIsARingOfItsArea) {
    const bench::Tube tube{.around = 64};
    Camera camera = kEnd;
    camera.cut_mm = 0.51 * tube.length;
    const double ring = 3.14159 * (tube.outer * tube.outer - tube.inner * tube.inner);
    EXPECT_NEAR(purple_mm2(cut_of(bench::tube_mesh(tube), camera), camera.px_per_mm), ring,
                0.07 * ring);
}

TEST(Cutaway, APlaneThroughNodesLeavesNothingOutsideOfTheWall) {
    const bench::Tube tube{};
    const Camera camera{
        .right = 2, .up = 0, .low = {-5, -12}, .high = {85, 12}, .px_per_mm = 4, .cut_mm = 0};
    const Image image = cut_of(bench::tube_mesh(tube), camera);
    // From the image's own frame: margins of 46 pixels on the left and 30 above.
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const double along = (x + 0.5 - 46) / 4 - 5, up = 12 - (y + 0.5 - 30) / 4;
            const bool inside =
                along > -0.3 && along < tube.length + 0.3 && std::abs(up) < tube.outer + 0.3;
            const Rgb8 pixel =
                image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
            EXPECT_TRUE(inside || !is_purple(pixel)) << along << " " << up;
        }
}

TEST(Cutaway, ValuesAreDisplacementsAndChangesOfVolume) {
    const TetMesh mesh = bench::tube_mesh({.around = 8, .across = 1, .along = 2});
    std::vector<Vec3d> positions = mesh.nodes_mm;
    for (Vec3d& p : positions) p = 1.1 * p;
    for (const auto& values : volume_changes_of(mesh, positions))
        for (const double v : values) EXPECT_NEAR(v, 0.331, 1e-9);
    const CornerValues moved = displacements_of(mesh, positions);
    for (std::size_t c = 0; c < moved.size(); ++c)
        for (std::size_t n = 0; n < 4; ++n)
            EXPECT_NEAR(moved[c][n], 0.1 * norm(mesh.nodes_mm[std::size_t(mesh.cells[c][n])]),
                        1e-9);
    EXPECT_EQ(shaded_to(1)(std::nan("")).r, kHeld.r);
}

TEST(Pressed, WithoutVolumeConstraintsTheWallUnderTheTipIsLost) {
    const TaskArena arena(1);
    const PressedVessel vessel = pressed_vessel();
    ASSERT_TRUE(check_wall(vessel.wall, 4).ok());
    const PressedRun with = run_pressed(vessel, true, 120, arena, 1200);
    const PressedRun without = run_pressed(vessel, false, 120, arena, 1200);
    EXPECT_GT(without.mean_near_tip, 3 * with.mean_near_tip);
    EXPECT_LT(without.thinnest_mm, 0.7 * with.thinnest_mm);
    EXPECT_GT(with.moved_mm, 0.5);
    EXPECT_EQ(with.inverted, 0);
}

}  // namespace
}  // namespace pliant::results
