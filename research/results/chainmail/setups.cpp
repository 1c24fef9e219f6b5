// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "setups.h"

#include <pliant/chainmail.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cmath>

namespace pliant::results {
namespace {

constexpr int kTissue = 0, kFixed = 1;
constexpr int kSoftHu = 50;
/// Value 2000 on the thesis's scale.
constexpr std::int16_t kCubeHu = 1000;

Volume filled(Vec3i size, Vec3d spacing_mm, const std::function<int(Vec3i)>& value) {
    Volume volume;
    volume.grid.size = size;
    volume.grid.spacing_mm = spacing_mm;
    std::vector<std::int16_t> voxels;
    voxels.reserve(voxel_count(volume.grid));
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) voxels.push_back(std::int16_t(value({x, y, z})));
    volume.voxels = std::move(voxels);
    return volume;
}

ElementLimits even_limits(double range, double shear, bool fixed) {
    constexpr double kFar_mm = 500;
    return {{range, range, range}, {range, range, range}, {shear, shear, shear}, kFar_mm, fixed};
}

ChainMailSettings tissue_settings(bool air) {
    ChainMailSettings settings;
    settings.air_enabled = air;
    return settings;
}

}  // namespace

PushReport& Scenario::push(const Push& push) {
    reports.push_back(must(tissue->push(push)));
    return reports.back();
}

PushReport& Scenario::push(const std::vector<Vec3i>& elements, Vec3d push_mm) {
    reports.push_back(must(tissue->push_elements(elements, push_mm)));
    return reports.back();
}

Scenario make_scenario(Volume scan, const ChainMailSettings& settings, const TaskArena& arena) {
    Scenario scenario;
    scenario.scan = std::make_unique<Volume>(std::move(scan));
    scenario.tissue =
        std::make_unique<ChainMail>(must(ChainMail::create(*scenario.scan, settings, arena)));
    return scenario;
}

Scenario gibson_object(const ObjectShape& shape, double range, double shear, const TaskArena& arena,
                       double yield) {
    ChainMailSettings settings;
    settings.max_movement_mm = 500;
    settings.bounded = true;
    settings.custom_law = [=](int value) {
        // The surroundings have almost no resistance: they can be flattened completely.
        constexpr double kFlat = 1, kFree = 1000;
        if (value < kTissue)
            return ElementLimits{.compress = {kFlat, kFlat, kFlat},
                                 .stretch = {kFree, kFree, kFree},
                                 .shear = {kFree, kFree, kFree},
                                 .max_movement_mm = 500};
        ElementLimits limits = even_limits(range, shear, value == kFixed);
        limits.yield = yield;
        return limits;
    };
    return make_scenario(filled(shape.size, {1, 1, 1},
                                [&](Vec3i e) {
                                    if (!shape.inside(e)) return kAirHu;
                                    return shape.fixed && shape.fixed(e) ? kFixed : kTissue;
                                }),
                         settings, arena);
}

Scenario chain_scenario(const TaskArena& arena) {
    return gibson_object({{kChainElements, 1, 1}, [](Vec3i) { return true; }, nullptr}, kChainRange,
                         kChainRange, arena);
}

Recovery recovery_of(double yield, const TaskArena& arena,
                     const std::function<void(const Scenario&)>& seen) {
    const auto is_fixed = [](Vec3i e) { return e.x == 0 || e.x == kRecoverySide - 1; };
    Recovery result{.sheet = gibson_object(
                        {{kRecoverySide, kRecoverySide, 1}, [](Vec3i) { return true; }, is_fixed},
                        0.5, 0.5, arena, yield)};
    ChainMail& tissue = *result.sheet.tissue;
    const std::vector<Vec3i> held{{kRecoverySide / 2, kRecoverySide / 2, 0}};
    result.sheet.push(held, {6, -9, 0});
    must(tissue.relax({.held = held}));
    result.pulled_mm = tissue.state().max_movement_mm;
    if (seen) seen(result.sheet);
    must(tissue.relax({}));
    result.left_mm = tissue.state().max_movement_mm;
    if (seen) seen(result.sheet);
    return result;
}

ChainMailSettings settings_of(const CubeSettings& cube) {
    ChainMailSettings settings;
    settings.offset = cube.offset;
    settings.scale = cube.scale;
    settings.max_movement_mm = cube.max_movement_mm;
    settings.bone_threshold_hu = 1600;
    settings.limits = cube.limits;
    settings.air_enabled = false;  // as in the thesis
    if (cube.z_adjusted) return settings;
    settings.custom_law = [law = draeger_law(settings), z_scale = cube.z_scale](int value) {
        ElementLimits limits = law(value);
        limits.compress.z /= z_scale;
        limits.stretch.z /= z_scale;
        limits.shear.z /= z_scale;
        return limits;
    };
    return settings;
}

Scenario cube_scenario(const CubeSettings& cube, const TaskArena& arena) {
    constexpr int kSide = 100;  // also [mm]
    PhantomSettings phantom;
    phantom.name = "cube";
    phantom.size = {kSide, kSide, 2 * int(std::lround(0.5 * kSide / cube.z_scale))};
    phantom.spacing_mm = {1, 1, cube.z_scale};
    return make_scenario(must(make_phantom(phantom, arena)).volume, settings_of(cube), arena);
}

Scenario solid_scenario(const CubeSettings& cube, const TaskArena& arena) {
    constexpr int kSide = 80;  // also [mm]
    const int slices = 2 * int(std::lround(0.5 * kSide / cube.z_scale));
    Volume volume =
        filled({kSide, kSide, slices}, {1, 1, cube.z_scale}, [](Vec3i) { return int(kCubeHu); });
    volume.grid.origin_mm = {-0.5 * (kSide - 1), -0.5 * (kSide - 1),
                             -0.5 * (slices - 1) * cube.z_scale};
    return make_scenario(std::move(volume), settings_of(cube), arena);
}

Scenario layers_scenario(StiffHalf stiff, const TaskArena& arena) {
    PhantomSettings phantom;
    phantom.name = "layers";
    phantom.size = {100, 100, 100};
    Volume volume = must(make_phantom(phantom, arena)).volume;
    if (stiff == StiffHalf::Graded) return make_scenario(std::move(volume), settings_of({}), arena);
    const Volume graded = volume;
    Volume even = filled(graded.grid.size, graded.grid.spacing_mm,
                         [&](Vec3i e) { return std::min(int(graded.at(e)), int(kCubeHu)); });
    even.grid = graded.grid;
    return make_scenario(std::move(even), settings_of({}), arena);
}

namespace {

/// @param depth  [mm] as a function of the distance from the tool along x and z [mm]
Dent measured_dent(const std::function<double(double x_mm, double z_mm)>& depth) {
    constexpr double kStep_mm = 0.25, kFar_mm = 12;
    constexpr int kSteps = int(kFar_mm / kStep_mm);
    Dent dent;
    std::vector<double> profile;  // through the tool, along z
    for (int z = -kSteps; z <= kSteps; ++z)
        for (int x = -kSteps; x <= kSteps; ++x) {
            const double here = depth(x * kStep_mm, z * kStep_mm);
            dent.depth_mm = std::max(dent.depth_mm, here);
            dent.volume_mm3 += here * kStep_mm * kStep_mm;
            dent.area_mm2 += here > kDented_mm ? kStep_mm * kStep_mm : 0;
            if (x == 0) profile.push_back(here);
        }
    const auto half = [&](int direction) {
        int n = 0;
        while (n < kSteps && profile[std::size_t(kSteps + direction * n)] > 0.5 * dent.depth_mm)
            ++n;
        return n * kStep_mm;
    };
    dent.half_below_mm = half(-1);
    dent.half_above_mm = half(1);
    for (std::size_t n = 4; n < profile.size(); ++n)  // over 1 mm, a voxel
        dent.slope = std::max(dent.slope, std::abs(profile[n] - profile[n - 4]));
    return dent;
}

/// Component of the displacement along +y, trilinear between elements.
double moved_along_y(const ChainMail& tissue, Vec3d position_mm) {
    const Vec3d ijk = voxel_from_world(tissue.volume().grid, position_mm);
    const Vec3i low{int(std::floor(ijk.x)), int(std::floor(ijk.y)), int(std::floor(ijk.z))};
    double moved = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3i step{corner & 1, corner >> 1 & 1, corner >> 2};
        double weight = 1;
        for (int a = 0; a < 3; ++a) weight *= step[a] ? ijk[a] - low[a] : 1 - (ijk[a] - low[a]);
        moved += weight * tissue.displacement_mm(low + step).y;
    }
    return moved;
}

constexpr double kRayStart_mm = 10;  ///< in front of the surface

}  // namespace

Dent dent_of(const Scenario& scenario, Vec3d position_mm, double threshold_hu,
             const TaskArena& arena) {
    const Volume deformed = deform_volume(*scenario.tissue).value().volume;
    const RayCaster before(*scenario.scan, arena), after(deformed, arena);
    return measured_dent([&](double x, double z) {
        const Vec3d from = position_mm + Vec3d{x, -kRayStart_mm, z};
        const auto rest = before.first_hit(from, {0, 1, 0}, threshold_hu, Polarity::Rising);
        const auto now = after.first_hit(from, {0, 1, 0}, threshold_hu, Polarity::Rising);
        return rest && now ? now->distance_mm - rest->distance_mm : 0.0;
    });
}

Dent moved_dent_of(const Scenario& scenario, Vec3d position_mm, double threshold_hu,
                   const TaskArena& arena) {
    const RayCaster before(*scenario.scan, arena);
    return measured_dent([&](double x, double z) {
        const Vec3d from = position_mm + Vec3d{x, -kRayStart_mm, z};
        const auto rest = before.first_hit(from, {0, 1, 0}, threshold_hu, Polarity::Rising);
        return rest ? moved_along_y(*scenario.tissue, rest->point_mm) : 0.0;
    });
}

Roundness roundness_of(const Scenario& scenario, Vec3d grabbed_mm, double push_mm) {
    const Grid& grid = scenario.scan->grid;
    const Vec3d ijk = voxel_from_world(grid, grabbed_mm);
    const auto around = [&](int across, int down) {
        Slice slice{across, down, 0};
        slice.index = int(std::floor(ijk[slice.third()]));
        const auto field = displacement_along(*scenario.tissue, slice,
                                              window_around(slice, grid, ijk, 1e3), kThesisPush_mm);
        // Middle of the grabbed cell, so that the contour is centred.
        const auto middle = [&](int axis) {
            return (std::floor(ijk[axis]) + 0.5) * grid.spacing_mm[axis];
        };
        return contour_around(field, {middle(across), middle(down)}, 0.5 * push_mm);
    };
    return {around(0, 2), around(0, 1), around(2, 1)};
}

std::vector<TimingCase> timing_cases() {
    return {{0.40, 1.0, 56, 110, 100},  {0.20, 1.0, 224, 160, 270},   {0.20, 1.2, 328, 170, 351},
            {0.15, 1.0, 392, 170, 441}, {0.10, 1.0, 1000, 230, 1171}, {0.08, 1.0, 1888, 331, 4757}};
}

Scenario timing_scenario(const TimingCase& timing, int brick_size, const TaskArena& arena) {
    // With slices 2.22 to 2.25 pixels apart, and links of exactly the offset, the numbers of moved
    // elements equal those of the thesis, which states a z-scale of 2.2.
    constexpr double kZScale = 2.23;
    ChainMailSettings settings;
    settings.scale = timing.scale;
    settings.brick_size = brick_size;
    settings.custom_law = [offset = timing.offset](int) {
        return even_limits(offset, offset, false);
    };
    Volume volume = filled({64, 64, 32}, {1, 1, kZScale},
                           [](Vec3i e) { return int(kCubeHu) + (e.x + 2 * e.y + 3 * e.z) % 7; });
    return make_scenario(std::move(volume), settings, arena);
}

Push timing_push(const Scenario& scenario) {
    const Vec3d middle = world_from_voxel(scenario.scan->grid, {31.5, 31.5, 15.5});
    return {.point_mm = middle, .push_mm = kThesisPush_mm};
}

std::int64_t visibly_moved(const ChainMail& tissue) {
    constexpr double kVisible_mm = 1e-3;
    const Box3i box = tissue.moved_box();
    std::int64_t count = 0;
    for (int z = box.begin.z; z < box.end.z; ++z)
        for (int y = box.begin.y; y < box.end.y; ++y)
            for (int x = box.begin.x; x < box.end.x; ++x)
                count += norm(tissue.displacement_mm({x, y, z})) > kVisible_mm;
    return count;
}

Scenario passage_scenario(bool air, const TaskArena& arena) {
    return make_scenario(filled({90, 64, 64}, {1, 1, 1},
                                [](Vec3i e) {
                                    const bool wall = e.x <= kNearWall.x || e.x >= kFarWall.x;
                                    return wall ? kSoftHu : kAirHu;
                                }),
                         tissue_settings(air), arena);
}

std::vector<Vec3i> near_wall_patch() {
    constexpr int kRadius = 4;
    std::vector<Vec3i> patch;
    for (int z = -kRadius; z <= kRadius; ++z)
        for (int y = -kRadius; y <= kRadius; ++y)
            if (y * y + z * z <= kRadius * kRadius) patch.push_back(kNearWall + Vec3i{0, y, z});
    return patch;
}

Scenario bump_scenario(Bump bump, bool air, const TaskArena& arena) {
    const auto column = [](Vec3i e, double half_width, double round) {
        const double side = std::hypot(e.x - kBumpTip.x, e.z - kBumpTip.z);
        const double dx = std::max(side - half_width + round, 0.0);
        const double dy = std::max(kBumpTip.y - 0.5 + round - e.y, 0.0);
        return std::hypot(dx, dy) - round;
    };
    const auto box = [](Vec3i e, Vec3i low, Vec3i high) {
        double outside = -1e9;
        for (int a = 0; a < 3; ++a)
            outside = std::max({outside, double(low[a] - e[a]), double(e[a] - high[a])});
        return outside - 0.5;
    };
    const auto outside_of = [&](Vec3i e) {
        if (bump == Bump::Column) return column(e, 4, 3);
        if (bump == Bump::Finger) return column(e, 1.5, 1.5);
        return std::min(box(e, {28, 22, 29}, {32, 30, 35}), box(e, {28, 19, 29}, {52, 23, 35}));
    };
    const auto value = [&](Vec3i e) {
        if (e.y >= kWallFront) return kSoftHu;
        // Anti-aliased over one voxel.
        const double share = std::clamp(0.5 - outside_of(e), 0.0, 1.0);
        return int(std::lround(kAirHu + share * (kSoftHu - kAirHu)));
    };
    return make_scenario(filled({80, 80, 64}, {1, 1, 1}, value), tissue_settings(air), arena);
}

Push bump_push(Bump bump) {
    const bool overhanging = bump == Bump::Overhang;
    const Vec3i tip = overhanging ? kHeadEnd : kBumpTip;
    return {{double(tip.x), tip.y + 1.0, double(tip.z)}, {0, overhanging ? 6.0 : 8.0, 0}, 2.5};
}

namespace {
constexpr double kAboveFinger_mm = kBumpTip.y - kFingerTool_mm;  ///< contact of the tool with the
                                                                 ///< tip
constexpr double kFingerDepth_mm = 9;
Push finger_path(double from_mm) {
    return {{kBumpTip.x + kBesideFinger_mm, kAboveFinger_mm + from_mm, double(kBumpTip.z)},
            {0, kFingerDepth_mm - from_mm, 0},
            kFingerTool_mm};
}
}  // namespace

void push_finger(Scenario& scenario) {
    scenario.push(finger_path(1));
}

SlideReport slide_off_finger(Scenario& scenario) {
    return must(slide_sphere(*scenario.tissue, finger_path(-0.5)));
}

}  // namespace pliant::results
