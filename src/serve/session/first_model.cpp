// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/first_model.h"

#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "session/near_elements.h"

namespace pliant::serve {
namespace {

constexpr int kPictures = 9;          ///< after the first one, which places the windows
constexpr double kHopeless_ms = 400;  ///< one such picture ends the measurement
constexpr double kRadiusVoxels = 3;   ///< of the ball
constexpr int kPlaces = 8;            ///< where a push is tried
constexpr int kSamples = 32;          ///< along each axis, for these places
constexpr std::uint32_t kTool = 1;

/// Whether a voxel is neither void nor held: its modulus, linear between entries, is above 0.
bool is_movable(double value, const ElasticScanSettings& settings) {
    const auto& moduli = settings.moduli_kpa;
    if (value > settings.held_above_hu || moduli.empty()) return false;
    const auto above =
        std::ranges::upper_bound(moduli, value, {}, &ElasticScanSettings::Modulus::value);
    const bool is_between = above != moduli.begin() && above != moduli.end();
    const auto& first = above == moduli.begin() ? moduli.front() : *std::prev(above);
    return first.kpa > 0 || (is_between && value > first.value && above->kpa > 0);
}

/// Places in tissue that moves, the nearest to the middle of the scan first [mm, LPS].
std::vector<Vec3d> places_in_tissue(const LoadedScan& loaded) {
    const Grid& grid = loaded.volume.grid;
    std::vector<std::pair<double, Vec3d>> found;
    const auto at = [](int n, int size) { return (2 * n + 1) * size / (2 * kSamples); };
    for (int k = 0; k < kSamples; ++k)
        for (int j = 0; j < kSamples; ++j)
            for (int i = 0; i < kSamples; ++i) {
                const Vec3i voxel{at(i, grid.size.x), at(j, grid.size.y), at(k, grid.size.z)};
                if (!is_movable(double(loaded.volume.at(voxel)), loaded.elastic)) continue;
                const double half = 0.5 * kSamples - 0.5;
                found.emplace_back(
                    norm(Vec3d{i - half, j - half, k - half}),
                    world_from_voxel(grid, {double(voxel.x), double(voxel.y), double(voxel.z)}));
            }
    std::ranges::stable_sort(found, {}, [](const auto& place) { return place.first; });
    std::vector<Vec3d> places;
    // Neighbours of a refused place would be refused as well.
    for (std::size_t n = 0; n < found.size() && places.size() < kPlaces; n += 1 + n)
        places.push_back(found[n].second);
    return places;
}

/// Times of pictures while a ball is pushed from a place on [ms]; none if it can't be pushed.
/// @param give_up  polled between pictures; may be empty
Result<std::vector<double>> picture_times(Tissue& tissue, LiveDeformation& live, Vec3d place_mm,
                                          const std::function<bool()>& give_up) {
    const Vec3d& mm = tissue.volume().grid.spacing_mm;
    const Vec3d step{std::min({mm.x, mm.y, mm.z}), 0, 0};
    const double radius_mm = kRadiusVoxels * std::cbrt(mm.x * mm.y * mm.z);
    std::vector<double> times_ms;
    std::int64_t elements = kNearElements;
    for (int n = 0; n <= kPictures; ++n) {
        if (give_up && give_up()) return expected_error("model", "a scan that is wanted", "none");
        const Stopwatch watch;
        const auto push = tissue.push(kTool, {.point_mm = place_mm + double(n) * step,
                                              .push_mm = step,
                                              .sphere_radius_mm = radius_mm});
        if (!push.ok()) return push.error();
        if (push->status == PushStatus::Rejected || push->grabbed_elements == 0) break;
        if (const auto swept = tissue.sweep(); !swept.ok()) return swept.error();
        const auto update = live.approach(elements);
        if (!update.ok()) return update.error();
        elements = near_elements(elements, *update);
        const bool is_hopeless = watch.ms() > kHopeless_ms;
        if (n > 0 || is_hopeless) times_ms.push_back(watch.ms());
        if (is_hopeless) break;
    }
    tissue.release(kTool);
    return times_ms;
}

std::string rate_text(double rate_hz) {
    return std::to_string(std::lround(rate_hz));
}

}  // namespace

Result<double> measure_elastic(const LoadedScan& loaded, const TaskArena& arena,
                               const std::function<bool()>& give_up) {
    auto tissue = make_elastic(loaded.volume, loaded.elastic, arena);
    if (!tissue.ok()) return tissue.error();
    auto live = LiveDeformation::create(**tissue);
    if (!live.ok()) return live.error();
    for (const Vec3d& place_mm : places_in_tissue(loaded)) {
        auto times_ms = picture_times(**tissue, *live, place_mm, give_up);
        if (!times_ms.ok()) return times_ms.error();
        if (times_ms->empty()) continue;
        const auto middle = times_ms->begin() + std::ptrdiff_t(times_ms->size() / 2);
        std::nth_element(times_ms->begin(), middle, times_ms->end());
        return 1000 / *middle;
    }
    return expected_error("model", "tissue that moves", "none");
}

FirstModel choose_model(const LoadedScan& loaded, const TaskArena& arena,
                        const std::function<bool()>& give_up) {
    if (loaded.has_chainmail_settings)
        return {"chainmail", "ChainMail, whose settings are given (--model elastic: another one)"};
    const auto rate_hz = measure_elastic(loaded, arena, give_up);
    if (!rate_hz.ok())
        return {"chainmail",
                "ChainMail: the elastic scan can't be used: " + rate_hz.error().message};
    const std::string measured =
        "the elastic scan makes " + rate_text(*rate_hz) + " pictures a second here";
    if (*rate_hz >= kElasticRate_hz)
        return {"elastic", "Elastic tissue: " + measured + " (--model chainmail: another one)"};
    return {"chainmail", "ChainMail: " + measured + ", expected " + rate_text(kElasticRate_hz) +
                             " (--model elastic: nevertheless)"};
}

}  // namespace pliant::serve
