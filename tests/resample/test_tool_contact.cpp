// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The eye is never in tissue: for any radius of the tip, any spacing and slice thickness, after
// sliding, pushing, releasing and relaxing. The oracle is the resampled scan itself.
// Covers: lattice/tool_touch.cpp, resample/live_deformation.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "chainmail/tissues.h"
#include "support/random.h"
#include "support/search.h"

namespace pliant::test {
namespace {

constexpr double kIso = -500;

float shown_at(const Volume& shown, Vec3d position_mm) {
    return sample_linear(shown, voxel_from_world(shown.grid, position_mm));
}

/// A winding tube of air, with a fold across it and perhaps bone in its wall, in soft tissue.
Volume phantom(Random& random) {
    Volume volume;
    Grid& grid = volume.grid;
    grid.size = {random.whole(10, 24), random.whole(10, 24), random.whole(8, 24)};
    const double h = random.ratio(0.02, 10);
    for (int a = 0; a < 3; ++a)
        grid.spacing_mm[a] = std::clamp(h * random.ratio(0.6, 1.6), 0.02, 10.0);
    if (random.whole(0, 1)) {  // thick slices
        const int axis = random.whole(0, 2);
        grid.spacing_mm[axis] = std::min(10.0, grid.spacing_mm[axis] * random.ratio(2, 8));
    }
    grid.direction = random.rotation(random.whole(0, 1) == 1);
    grid.origin_mm = random.vector(200);
    const int along = random.whole(0, 2), u = (along + 1) % 3, v = (along + 2) % 3;
    const double radius = random.real(1.2, 0.4 * std::min(grid.size[u], grid.size[v]));
    const double bend = random.real(0, 3), turns = random.real(0.1, 0.5);
    const double fold_at = random.real(0.3, 0.7) * grid.size[along];
    const bool has_bone = random.whole(0, 2) == 0;
    std::vector<std::int16_t> voxels;
    for_each_element(grid, [&](Vec3i e) {
        const double x = e[u] - 0.5 * grid.size[u] - bend * std::sin(turns * e[along]);
        const double y = e[v] - 0.5 * grid.size[v] - bend * std::cos(turns * e[along]);
        double depth = std::hypot(x, y) - radius;  // in the wall: above 0 [voxels]
        depth = std::max(depth, std::min(1 - std::abs(e[along] - fold_at), x + 0.3 * radius));
        const double tissue = has_bone && depth > 3 ? 900 : 40;
        voxels.push_back(
            std::int16_t(std::lround(-1000 + (1000 + tissue) * std::clamp(depth + 0.5, 0.0, 1.0))));
    });
    volume.voxels = voxels;
    return volume;
}

/// A position in the lumen.
std::optional<Vec3d> free_place(Random& random, const Volume& volume, float iso = kIso) {
    const Vec3i size = volume.grid.size;
    for (int tries = 0; tries < 2000; ++tries) {
        const Vec3d ijk{random.real(0, size.x - 1), random.real(0, size.y - 1),
                        random.real(0, size.z - 1)};
        if (sample_linear(volume, ijk) < iso - 50) return world_from_voxel(volume.grid, ijk);
    }
    return std::nullopt;
}

Vec3d direction_of(Random& random) {
    for (;;) {
        const Vec3d v = random.vector(1);
        if (norm(v) > 0.1) return normalized(v);
    }
}

bool is_in_scan(const Grid& grid, Vec3d position_mm) {
    const Vec3d ijk = voxel_from_world(grid, position_mm);
    for (int a = 0; a < 3; ++a)
        if (!(ijk[a] >= 0 && ijk[a] <= grid.size[a] - 1)) return false;
    return true;
}

/// Moves an eye through a scan by random slides; after each the tissue relaxes.
/// @returns number of tests of the eye
int follow_eye(const Volume& volume, const ChainMailSettings& settings, Vec3d eye, double radius_mm,
               Random& random, const TaskArena& arena) {
    const Grid& grid = volume.grid;
    const Vec3d h = grid.spacing_mm;
    SCOPED_TRACE("radius " + std::to_string(radius_mm) + " mm, spacing " + std::to_string(h.x) +
                 " x " + std::to_string(h.y) + " x " + std::to_string(h.z) + " mm");
    auto tissue = ChainMail::create(volume, settings, arena);
    EXPECT_TRUE(tissue.ok());
    if (!tissue.ok()) return 0;
    const auto iso = float(settings.air_threshold_hu);
    LiveDeformation live = LiveDeformation::create(*tissue).value();
    int looks = 0;
    const auto look = [&](const char* after) {
        (void)live.update();
        const float value = shown_at(live.volume(), eye);
        EXPECT_LT(value, iso) << after << ", look " << looks;
        ++looks;
        return value < iso;
    };
    for (int n = 0; n < 5; ++n) {
        const double reach = 4 * std::max({h.x, h.y, h.z});
        const Vec3d way = std::min(random.ratio(0.2, 4) * reach, 60.0) * direction_of(random);
        if (is_in_scan(grid, eye + way)) {
            const auto report = slide_sphere(
                *tissue, {.point_mm = eye, .push_mm = way, .sphere_radius_mm = radius_mm});
            EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.error().message);
            if (!report.ok()) return looks;
            EXPECT_FALSE(report->ends_in_tissue);
            eye = report->end_mm;
            if (!look("slide")) return looks;
        }
        const RelaxTool tip{eye, eye, radius_mm};
        for (int sweep = 0; sweep < 4; ++sweep) {
            EXPECT_TRUE(tissue->relax({.max_sweeps = 1 << sweep, .tools = {tip}}).ok());
            if (!look("relax")) return looks;
        }
    }
    return looks;
}

int follow_eye(std::uint64_t seed, const TaskArena& arena) {
    Random random(seed);
    const Volume volume = phantom(random);
    const auto start = free_place(random, volume);
    if (!start) return 0;
    const Vec3d h = volume.grid.spacing_mm;
    // A sphere of many voxels would push far more tissue than the scan has.
    const double most_mm = std::clamp(4 * std::max({h.x, h.y, h.z}), 0.2, 10.0);
    ChainMailSettings settings;
    settings.air_enabled = random.whole(0, 3) > 0;
    SCOPED_TRACE("seed " + std::to_string(seed));
    return follow_eye(volume, settings, *start, random.ratio(0.1, most_mm), random, arena);
}

void expect_looks(const Search& search, int looks) {
    EXPECT_GT(looks, 10 * search.instances);
    std::printf("seeds from %llu: %d looks\n", static_cast<unsigned long long>(search.first_seed),
                looks);
}

TEST(Contact, TheEyeIsNeverInTissue) {
    const TaskArena arena(2);
    const test::Search search(24'000, 40);
    int looks = 0;
    for (int n = 0; n < search.instances; ++n) looks += follow_eye(search.seed(n), arena);
    expect_looks(search, looks);
}

/// Voxels of a scan around a position, as a scan of its own.
Volume cropped(const Volume& scan, Vec3d position_mm, Vec3i size) {
    const Vec3d ijk = voxel_from_world(scan.grid, position_mm);
    Vec3i low;
    for (int a = 0; a < 3; ++a) {
        size[a] = std::min(size[a], scan.grid.size[a]);
        low[a] = std::clamp(int(ijk[a]) - size[a] / 2, 0, scan.grid.size[a] - size[a]);
    }
    Volume crop;
    crop.grid = scan.grid;
    crop.grid.size = size;
    crop.grid.origin_mm =
        world_from_voxel(scan.grid, {double(low.x), double(low.y), double(low.z)});
    std::vector<std::int16_t> voxels;
    for_each_element(
        crop.grid, [&](Vec3i e) { voxels.push_back(std::int16_t(std::lround(scan.at(low + e)))); });
    crop.voxels = voxels;
    return crop;
}

/// A lumen that an eye can pass: neither all air nor all tissue.
bool has_walls(const Volume& volume, float iso) {
    std::int64_t air = 0;
    for_each_element(volume.grid, [&](Vec3i e) { air += volume.at(e) < iso; });
    const std::int64_t all = voxel_count(volume.grid);
    return air > all / 50 && air < all - all / 5;
}

struct RealScan {
    const char* file;
    float iso = kIso;
    double bone = 300;
};

/// Moves eyes through crops of a scan. @returns number of tests of an eye
int follow_eyes(const RealScan& real, const Volume& scan, int crops, Random& random,
                const TaskArena& arena) {
    ChainMailSettings settings;
    settings.air_threshold_hu = real.iso;
    settings.bone_threshold_hu = real.bone;
    int looks = 0;
    for (int tries = 0, n = 0; n < crops && tries < 100 * crops; ++tries) {
        const auto middle = free_place(random, scan, real.iso);
        if (!middle) break;
        const Volume crop = cropped(scan, *middle, {40, 40, 40});
        if (!has_walls(crop, real.iso)) continue;
        const auto eye = free_place(random, crop, real.iso);
        if (!eye) continue;
        ++n;
        settings.air_enabled = random.whole(0, 3) > 0;
        const Vec3d h = crop.grid.spacing_mm;
        const double most_mm = std::clamp(3 * std::max({h.x, h.y, h.z}), 0.2, 10.0);
        SCOPED_TRACE(std::string(real.file) + ", crop " + std::to_string(n));
        looks += follow_eye(crop, settings, *eye, random.ratio(0.1, most_mm), random, arena);
    }
    return looks;
}

TEST(Contact, TheEyeIsNeverInTissueOfRealScans) {
    const TaskArena arena(2);
    const test::Search search(24'900, 12);
    const int crops = search.instances;
    Random random(search.first_seed);
    // The head of the MR is not in HU: air is below 300, and there is no bone.
    for (const RealScan& real :
         {RealScan{"thorax_ct_256.nrrd"}, RealScan{"thorax_ct_airways_crop.nrrd"},
          RealScan{"abdomen_ct_3mm.nii.gz"}, RealScan{"aorta_cta_1p5mm.nii.gz"},
          RealScan{"head_ct_tiny_64.nrrd"}, RealScan{"dicom_thorax_10"},
          RealScan{"mr_head_mni152_2mm.nii.gz", 300, 32'000}}) {
        const std::filesystem::path file = std::filesystem::path(PLIANT_SHARED_DATA) / real.file;
        if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is missing";
        const auto scan = read_volume(file);
        ASSERT_TRUE(scan.ok()) << scan.error().message;
        const int looks = follow_eyes(real, *scan, crops, random, arena);
        EXPECT_GT(looks, 10 * crops) << real.file;
        std::printf("%s: %d looks\n", real.file, looks);
    }
}

TEST(Contact, TheEyeIsNeverInTissueOfAWholeScan) {
    const TaskArena arena(2);
    Random random(24'900);
    constexpr Vec3d kTrachea_mm{-15.5, 132.8, -429.3};
    const std::filesystem::path file =
        std::filesystem::path(PLIANT_SHARED_DATA) / "thorax_ct_256.nrrd";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is missing";
    const auto scan = read_volume(file);
    ASSERT_TRUE(scan.ok());
    ASSERT_LT(shown_at(*scan, kTrachea_mm), kIso);
    for (const double radius_mm : {0.1, 0.7, 2.5})
        EXPECT_GT(follow_eye(*scan, {}, kTrachea_mm, radius_mm, random, arena), 15);
}

/// Another tool pushes tissue, which then returns beside an observing eye, sweep by sweep. An eye
/// that is covered by a push first moves to a free position nearby. @returns number of tests of the
/// eye
int look_on(std::uint64_t seed, const TaskArena& arena) {
    constexpr float kMargin = 1;  // for the position to which an eye moves [HU]
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const Volume volume = phantom(random);
    const auto start = free_place(random, volume);
    if (!start) return 0;
    const Vec3d h = volume.grid.spacing_mm;
    const double reach = 4 * std::max({h.x, h.y, h.z});
    const double most_mm = std::clamp(reach, 0.2, 10.0);
    ChainMailSettings settings;
    settings.air_enabled = random.whole(0, 3) > 0;
    if (random.whole(0, 3) == 0) settings.yield = 0.3;
    auto tissue = ChainMail::create(volume, settings, arena);
    EXPECT_TRUE(tissue.ok());
    if (!tissue.ok()) return 0;
    LiveDeformation live = LiveDeformation::create(*tissue).value();
    Vec3d eye = *start;
    const double radius_mm = random.ratio(0.1, most_mm);
    int looks = 0;
    for (int n = 0; n < 3; ++n) {
        const auto from = free_place(random, volume);
        if (!from) break;
        const Vec3d way = std::min(random.ratio(0.2, 4) * reach, 60.0) * direction_of(random);
        const Push push{*from + 0.3 * way, way, random.ratio(0.1, most_mm)};
        auto held = tissue->elements_at(push);
        if (!held.ok() || held->empty()) continue;
        const auto pushed = tissue->push_elements(*held, way);
        if (!pushed.ok() || pushed->moved_elements == 0) continue;
        const Vec3d end = push.point_mm + pushed->step_fraction * way;
        std::vector<RelaxTool> tools;
        if (random.whole(0, 1))
            tools.push_back({end, end, push.sphere_radius_mm});
        else
            held->clear();  // it lets go
        (void)live.update();
        for (int tries = 0; shown_at(live.volume(), eye) >= kIso - kMargin; ++tries) {
            if (tries == 4000) return looks;  // the lumen is closed
            const Vec3d place = eye + random.ratio(0.02, 2) * reach * direction_of(random);
            if (is_in_scan(volume.grid, place)) eye = place;
        }
        tools.push_back({eye, eye, radius_mm});
        for (int sweep = 0; sweep < 150; ++sweep) {
            const auto relaxed = tissue->relax({.max_sweeps = 1, .tools = tools, .held = *held});
            EXPECT_TRUE(relaxed.ok());
            (void)live.update();
            ++looks;
            const float value = shown_at(live.volume(), eye);
            EXPECT_LT(value, kIso) << "push " << n << ", sweep " << sweep;
            if (!relaxed.ok() || value >= kIso) return looks;
            if (relaxed->settled) break;
        }
    }
    return looks;
}

TEST(Contact, TissueThatReturnsDoesNotFoldOverAnEye) {
    const TaskArena arena(2);
    const test::Search search(1'047, 6);
    int looks = 0;
    for (int n = 0; n < search.instances; ++n) looks += look_on(search.seed(n), arena);
    expect_looks(search, looks);
}

TEST(Contact, RelaxationDoesNotCloseOverAnEye) {
    // A dent of a sphere, in slices of several millimetres; a thin endoscope in it.
    const TaskArena arena(1);
    for (const double slice_mm : {1.0, 5.0}) {
        Volume volume;
        volume.grid.size = {32, 32, 20};
        volume.grid.spacing_mm = {0.8, 0.8, slice_mm};
        std::vector<std::int16_t> voxels;
        for (int n = 0; n < 32 * 32 * 20; ++n) voxels.push_back(n % 32 < 12 ? -1000 : 40);
        volume.voxels = voxels;
        const Vec3d wall = world_from_voxel(volume.grid, {12, 16.5, 10.5});
        for (const double radius_mm : {0.1, 0.5, 2.5, 0.0}) {
            SCOPED_TRACE(testing::Message() << slice_mm << " mm, radius " << radius_mm);
            auto tissue = ChainMail::create(volume, {}, arena);
            ASSERT_TRUE(tissue.ok());
            ASSERT_TRUE(
                tissue->push({.point_mm = wall, .push_mm = {5, 0, 0}, .sphere_radius_mm = 4}).ok());
            const Vec3d eye = wall + Vec3d{1.6, 0, 0};
            ASSERT_LT(shown_at(deform_volume(*tissue).value().volume, eye), kIso) << "in the dent";
            RelaxOptions options;
            if (radius_mm > 0) options.tools = {{eye, eye, radius_mm}};
            const auto relaxed = tissue->relax(options);
            ASSERT_TRUE(relaxed.ok());
            EXPECT_TRUE(relaxed->settled);
            const float value = shown_at(deform_volume(*tissue).value().volume, eye);
            if (radius_mm > 0)
                EXPECT_LT(value, kIso);
            else
                EXPECT_GT(value, kIso) << "without an eye the dent closes";
        }
    }
}

}  // namespace
}  // namespace pliant::test
