// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Frames of an endoscope, and flow against a search of its own: it finds the rest point of tissue
// by bisection of the forward displacements, cell by cell, and the pixel by bisection of the rays.
// Covers: gym/endoscope_scope.cpp.

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "gym/lumen.h"

namespace pliant::test {
namespace {

constexpr int kWidth = 40, kHeight = 32;

/// Forward displacements of one moment, copied.
class Forward {
  public:
    explicit Forward(const Deformation& deformation)
        : m_grid(deformation.grid()), m_box(deformation.moved_box()) {
        for (int k = m_box.begin.z; k < m_box.end.z; ++k)
            for (int j = m_box.begin.y; j < m_box.end.y; ++j)
                for (int i = m_box.begin.x; i < m_box.end.x; ++i)
                    m_u.push_back(deformation.displacement_mm({i, j, k}));
        for (const Vec3d& u : m_u) m_reach_mm = std::max(m_reach_mm, norm(u));
    }

    Vec3d element(Vec3i e) const {
        Vec3d u{0, 0, 0};
        if (contains(m_box, e)) {
            const Vec3i p = e - m_box.begin, n = m_box.end - m_box.begin;
            u = m_u[std::size_t(p.x + n.x * (p.y + n.y * p.z))];
        }
        return world_from_voxel(m_grid, {double(e.x), double(e.y), double(e.z)}) + u;
    }

    /// Place of a material point [voxels at rest].
    Vec3d at(Vec3d rest) const {
        const Vec3i cell{int(std::floor(rest.x)), int(std::floor(rest.y)), int(std::floor(rest.z))};
        const Vec3d t = rest - Vec3d{double(cell.x), double(cell.y), double(cell.z)};
        Vec3d sum{0, 0, 0};
        for (int c = 0; c < 8; ++c) {
            const double w =
                (c & 1 ? t.x : 1 - t.x) * (c >> 1 & 1 ? t.y : 1 - t.y) * (c >> 2 ? t.z : 1 - t.z);
            sum = sum + w * element(cell + Vec3i{c & 1, c >> 1 & 1, c >> 2});
        }
        return sum;
    }

    /// All material points at a position.
    std::vector<Vec3d> rest_points(Vec3d place_mm) const {
        std::vector<Vec3d> found;
        const Vec3d middle = voxel_from_world(m_grid, place_mm);
        Vec3i low, high;
        for (int a = 0; a < 3; ++a) {
            const double reach = m_reach_mm / m_grid.spacing_mm[a] + 1e-6;
            low[a] = int(std::floor(middle[a] - reach));
            high[a] = int(std::floor(middle[a] + reach));
        }
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x)
                    halve({double(x), double(y), double(z)}, 1, place_mm, found);
        return found;
    }

  private:
    /// A part of a cell lies in the convex hull of its corners, so in the box around them.
    void halve(Vec3d low, double size, Vec3d place_mm, std::vector<Vec3d>& found) const {
        constexpr double kInside = 1e-7;  // from the corner: floor() must find the cell
        Vec3d least{1e9, 1e9, 1e9}, most{-1e9, -1e9, -1e9};
        for (int c = 0; c < 8; ++c) {
            const auto part = [&](int bit) { return c >> bit & 1 ? size * (1 - kInside) : 0; };
            const Vec3d p = at(low + Vec3d{part(0), part(1), part(2)});
            for (int a = 0; a < 3; ++a) {
                least[a] = std::min(least[a], p[a]);
                most[a] = std::max(most[a], p[a]);
            }
        }
        for (int a = 0; a < 3; ++a)
            if (place_mm[a] < least[a] - 1e-6 || place_mm[a] > most[a] + 1e-6) return;
        if (size < 1e-5) {
            found.push_back(low + 0.5 * size * Vec3d{1, 1, 1});
            return;
        }
        for (int c = 0; c < 8; ++c) {
            const double half = 0.5 * size;
            halve(low + half * Vec3d{double(c & 1), double(c >> 1 & 1), double(c >> 2)}, half,
                  place_mm, found);
        }
    }

    Grid m_grid;
    Box3i m_box;
    std::vector<Vec3d> m_u;
    double m_reach_mm = 0;
};

/// Pixel of a point by the camera's definition in render.h, by bisection of the radius.
std::array<double, 2> pixel_of(const Endoscope& e, Vec3d point_mm) {
    const Vec3d look = normalized(e.look), right = normalized(cross(look, e.up));
    const Vec3d up = cross(right, look), d = point_mm - e.eye_mm;
    const double slope = std::tan(e.field_of_view_deg * std::acos(-1.0) / 360);
    const double u = dot(d, right) / dot(d, look) / slope, v = dot(d, up) / dot(d, look) / slope;
    const double bent = std::hypot(u, v);
    double low = 0, high = bent;
    for (int n = 0; n < 200; ++n) {
        const double r = 0.5 * (low + high);
        (r * (1 + e.barrel_distortion * r * r) < bent ? low : high) = r;
    }
    const double share = bent > 0 ? low / bent : 1;
    return {0.5 * kWidth + 0.5 * kHeight * share * u, 0.5 * kHeight - 0.5 * kHeight * share * v};
}

TEST(EndoscopeFrame, AgreesWithTheViewAndSingleRays) {
    const Volume scan = bent_tube();
    const TaskArena threads(2);
    const RayCaster rays(scan, threads);
    for (const Style style : {Style::Plain, Style::Real})
        for (const FieldStop stop : {FieldStop::Round, FieldStop::Full}) {
            Endoscope e{.eye_mm = start_in(scan).eye_mm,
                        .look = {0.3, 0.1, 1},
                        .up = {0, -1, 0.2},
                        .style = style,
                        .field_stop = stop};
            const std::size_t count = kWidth * kHeight;
            std::vector<Rgb8> colour(count);
            std::vector<float> depth(count);
            std::vector<Vec3f> normals(count);
            std::vector<Vec3d> points(count);
            rays.endoscope_frame(e, kWidth, kHeight, {colour, depth, normals, points});
            EXPECT_EQ(colour, rays.endoscope_view(e, kWidth, kHeight).pixels);
            const Vec3d look = normalized(e.look), right = normalized(cross(look, e.up));
            int hits = 0;
            for (int y = 0; y < kHeight; ++y)
                for (int x = 0; x < kWidth; ++x) {
                    const auto n = std::size_t(y * kWidth + x);
                    if (depth[n] == 0) {
                        EXPECT_TRUE(std::isinf(points[n].x));
                        EXPECT_EQ(normals[n], (Vec3f{0, 0, 0}));
                        continue;
                    }
                    ++hits;
                    const auto hit = rays.pick(e, kWidth, kHeight, x + 0.5, y + 0.5);
                    ASSERT_TRUE(hit.has_value());
                    EXPECT_LT(norm(hit->point_mm - points[n]), 1e-4);
                    EXPECT_NEAR(double(depth[n]), dot(hit->point_mm - e.eye_mm, look), 1e-4);
                    EXPECT_NEAR(double(normals[n].x), dot(hit->normal, right), 1e-3);
                    EXPECT_NEAR(double(normals[n].z), dot(hit->normal, look), 1e-3);
                    const auto at = project(e, kWidth, kHeight, points[n]);
                    ASSERT_TRUE(at.has_value());
                    EXPECT_NEAR(at->x, x + 0.5, 1e-6);
                    EXPECT_NEAR(at->y, y + 0.5, 1e-6);
                }
            EXPECT_GT(hits, int(count / 2));
            EXPECT_FALSE(project(e, kWidth, kHeight, e.eye_mm - look).has_value());
        }
}

TEST(SceneFlow, IsThatOfASearchOfItsOwn) {
    const Volume scan = bent_tube();
    const TaskArena threads(2);
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        EndoscopeArenaSettings settings;
        settings.width = kWidth;
        settings.height = kHeight;
        settings.has_colour = false;
        settings.has_flow = true;
        settings.relax_sweeps = 3;
        auto made = EndoscopeArena::create(scan, settings, threads);
        ASSERT_TRUE(made.ok());
        const auto arena = std::move(*made);
        ASSERT_TRUE(arena->place(0, start_in(scan)).ok());
        Random random(seed);
        int checked = 0, moved = 0, ambiguous = 0;
        for (int step = 0; step < 40; ++step) {
            // Tissue in view moves as well.
            const Vec3d ahead = arena->state(0).pose.eye_mm + 9.0 * arena->state(0).pose.look;
            if (step % 3 == 0) (void)arena->push(0, {ahead, random.vector(2), 5});
            std::vector<double> action = random_actions(random, 1);
            ASSERT_TRUE(arena->step(action).ok());
            if (step % 8 != 7) continue;
            const Endoscope camera = arena->camera(0);
            const Forward before(*arena->deformation(0));
            const Volume shown = arena->volume(0);
            const RayCaster rays(shown, threads);
            action[0] = 10;
            const Vec3d near = arena->state(0).pose.eye_mm + 6.0 * arena->state(0).pose.look;
            (void)arena->push(0, {near, random.vector(2), 6});
            ASSERT_TRUE(arena->step(action).ok());
            const Endoscope later = arena->camera(0);
            const Forward after(*arena->deformation(0));
            const EndoscopePictures p = arena->pictures();
            for (int n = 0; n < kWidth * kHeight; n += 7) {
                const int x = n % kWidth, y = n / kWidth;
                const auto hit = rays.pick(camera, kWidth, kHeight, x + 0.5, y + 0.5);
                if (!hit) {
                    EXPECT_EQ(p.visibility[std::size_t(n)], FlowVisibility::None);
                    continue;
                }
                const std::vector<Vec3d> rest = before.rest_points(hit->point_mm);
                ASSERT_FALSE(rest.empty());
                double least = 1e9, least_mm = 1e9;
                bool is_behind = false;
                for (const Vec3d& r : rest) {
                    const Vec3d q = after.at(r);
                    const Vec3f given = p.scene_flow_mm[std::size_t(n)];
                    const Vec3d flow_mm{double(given.x), double(given.y), double(given.z)};
                    const double off_mm = norm(q - hit->point_mm - flow_mm);
                    least_mm = std::min(least_mm, off_mm);
                    if (dot(q - later.eye_mm, later.look) <= 1e-3) {
                        is_behind = true;
                        continue;
                    }
                    const auto [u, v] = pixel_of(later, q);
                    least = std::min(
                        least, std::hypot(u - x - 0.5 - double(p.flow[std::size_t(2 * n)]),
                                          v - y - 0.5 - double(p.flow[std::size_t(2 * n + 1)])));
                }
                EXPECT_LT(least_mm, 1e-3) << "pixel " << x << ", " << y;
                if (!is_behind) {
                    EXPECT_LT(least, 0.01) << "pixel " << x << ", " << y;
                }
                ++checked;
                moved += norm(hit->point_mm - world_from_voxel(scan.grid, rest[0])) > 0.05;
                for (const Vec3d& r : rest) ambiguous += norm(r - rest[0]) > 0.01;
            }
        }
        EXPECT_GT(checked, 500);
        EXPECT_GT(moved, 50);
        RecordProperty("ambiguous", ambiguous);
        std::printf("seed %d: %d pixels, %d on moved tissue, %d with another solution\n", int(seed),
                    checked, moved, ambiguous);
    }
}

TEST(SceneFlow, TellsWhatIsSeenHiddenAndOutside) {
    const Volume scan = bent_tube();
    const TaskArena threads(1);
    EndoscopeArenaSettings settings;
    settings.width = kWidth;
    settings.height = kHeight;
    settings.has_flow = true;
    settings.deforms = false;
    auto made = EndoscopeArena::create(scan, settings, threads);
    ASSERT_TRUE(made.ok());
    const auto arena = std::move(*made);
    ASSERT_TRUE(arena->place(0, start_in(scan)).ok());
    ASSERT_TRUE(arena->look().ok());
    ASSERT_TRUE(arena->step(std::vector<double>{0, 0, 0, 0}).ok());
    const auto visibility = arena->pictures().visibility;
    const auto count = [&](FlowVisibility v) {
        return std::count(visibility.begin(), visibility.end(), v);
    };
    // Nothing moved: all walls are seen where they were.
    EXPECT_EQ(count(FlowVisibility::Hidden), 0);
    EXPECT_EQ(count(FlowVisibility::Outside), 0);
    EXPECT_GT(count(FlowVisibility::Seen), kWidth * kHeight / 2);
    for (const float f : arena->pictures().flow) EXPECT_LT(std::abs(f), 1e-4F);
    ASSERT_TRUE(arena->step(std::vector<double>{0, 0, 0, 6}).ok());
    EXPECT_GT(count(FlowVisibility::Outside), kWidth * kHeight / 10);
    EXPECT_EQ(count(FlowVisibility::Hidden), 0);
}

}  // namespace
}  // namespace pliant::test
