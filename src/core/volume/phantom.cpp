// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// make_phantom: checks the settings, places the grid, samples the shapes, writes the landmarks into
// the key/value pairs.

#include <pliant/volume.h>

#include "base/errors.h"
#include "base/text.h"
#include "volume/layer_stack.h"

#include <array>
#include <cmath>
#include <new>

namespace pliant {
namespace {

constexpr std::array<std::string_view, 6> kNames = {"cube",  "layers", "airway",
                                                    "sinus", "vessel", "knee"};
using MakeModel = phantom::Model (*)();
constexpr std::array<MakeModel, 6> kModels = {
    phantom::make_cube_model,  phantom::make_layers_model, phantom::make_airway_model,
    phantom::make_sinus_model, phantom::make_vessel_model, phantom::make_knee_model};

constexpr Setting<PhantomSettings> kRows[] = {
    setting<&PhantomSettings::name>({.name = "name",
                                     .choices = "cube|layers|airway|sinus|vessel|knee",
                                     .text = "shapes of the phantom"}),
    setting<&PhantomSettings::spacing_mm>({.name = "spacing_mm",
                                           .unit = "mm",
                                           .range = {0, 1000},
                                           .text = "between voxels, at least 0.001; 0: the "
                                                   "phantom's extent divided by the size"}),
};

constexpr std::int32_t kMinSize = 2, kGreatestSize = 4096;
constexpr double kMinSpacing_mm = 1e-3, kGreatestSpacing_mm = 1e3;
constexpr std::size_t kGreatestCount = std::size_t(1) << 30;  // 2 GiB of voxels
constexpr double kDirectionTolerance = 1e-4;
constexpr char kAxis[] = "xyz";

/// Fixed decimals, without a sign before a zero.
std::string landmark_text(double value, int decimals) {
    std::string text = fixed_text(value, decimals);
    if (text.starts_with('-') && text.find_first_not_of("-0.") == text.npos) text.erase(0, 1);
    return text;
}
std::string landmark_text(Vec3d v, int decimals) {
    return landmark_text(v.x, decimals) + "," + landmark_text(v.y, decimals) + "," +
           landmark_text(v.z, decimals);
}

Status check_size(const PhantomSettings& settings) {
    for (int a = 0; a < 3; ++a)
        if (settings.size[a] < kMinSize || settings.size[a] > kGreatestSize)
            return invalid(std::string("phantom size.") + kAxis[a] + ": found " +
                           std::to_string(settings.size[a]) + ", expected 2 to 4096 voxels");
    const std::size_t count =
        std::size_t(settings.size.x) * std::size_t(settings.size.y) * std::size_t(settings.size.z);
    if (count > kGreatestCount)
        return Error{ErrorCode::LimitExceeded,
                     "phantom size: found " + std::to_string(settings.size.x) + "x" +
                         std::to_string(settings.size.y) + "x" + std::to_string(settings.size.z) +
                         " = " + std::to_string(count) + " voxels, expected at most " +
                         std::to_string(kGreatestCount)};
    return Ok{};
}

Status check_spacing(const PhantomSettings& settings) {
    for (int a = 0; a < 3; ++a) {
        const double h = settings.spacing_mm[a];
        if (h == 0 || (h >= kMinSpacing_mm && h <= kGreatestSpacing_mm)) continue;
        return invalid(std::string("phantom spacing_mm.") + kAxis[a] + ": found " + text_of(h) +
                       ", expected 0.001 to 1000 mm, or 0 for the phantom's own");
    }
    return Ok{};
}

Status check_direction(const PhantomSettings& settings) {
    const auto& c = settings.direction.columns;
    for (int a = 0; a < 3; ++a) {
        const double length = norm(c[a]);
        if (!(std::abs(length - 1) <= kDirectionTolerance))
            return invalid("phantom direction: column " + std::to_string(a + 1) + " has length " +
                           text_of(length) + ", expected a unit vector");
    }
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3;
        const double along = dot(c[a], c[b]);
        if (!(std::abs(along) <= kDirectionTolerance))
            return invalid("phantom direction: columns " + std::to_string(std::min(a, b) + 1) +
                           " and " + std::to_string(std::max(a, b) + 1) + " have the product " +
                           text_of(along) + ", expected perpendicular columns");
    }
    return Ok{};
}

Grid centred_grid(const PhantomSettings& settings, Vec3d extent_mm) {
    Grid grid;
    grid.size = settings.size;
    grid.direction = settings.direction;
    Vec3d half;
    for (int a = 0; a < 3; ++a) {
        const double h = settings.spacing_mm[a];
        grid.spacing_mm[a] = h > 0 ? h : extent_mm[a] / settings.size[a];
        half[a] = 0.5 * (settings.size[a] - 1) * grid.spacing_mm[a];
    }
    grid.origin_mm = -(grid.direction * half);
    return grid;
}

bool is_in(const Grid& grid, Vec3d point_mm) {
    const Vec3d ijk = voxel_from_world(grid, point_mm);
    for (int a = 0; a < 3; ++a)
        if (!(ijk[a] >= 0 && ijk[a] <= grid.size[a] - 1)) return false;
    return true;
}

void note_landmarks(const std::vector<PhantomLandmark>& landmarks, KeyValues& key_values) {
    for (const PhantomLandmark& l : landmarks)
        key_values.emplace_back("landmark " + l.name, "push " + landmark_text(l.push_point_mm, 2) +
                                                          ":" + landmark_text(l.push_mm, 2) +
                                                          " eye " + landmark_text(l.eye_mm, 2) +
                                                          " look " + landmark_text(l.look, 3));
}

}  // namespace

SettingRows<PhantomSettings> phantom_rows() noexcept {
    return kRows;
}

std::span<const std::string_view> phantom_names() {
    return kNames;
}

Result<Phantom> make_phantom(const PhantomSettings& settings, const TaskArena& arena,
                             const Progress& progress) {
    std::size_t which = 0;
    while (which < kNames.size() && kNames[which] != settings.name) ++which;
    for (const auto check_field : {check_size, check_spacing, check_direction})
        if (const Status status = check_field(settings); !status.ok()) return status.error();
    if (const Status status = check(settings, phantom_rows()); !status.ok())
        return invalid("phantom " + status.error().message);

    try {
        phantom::Model model = kModels[which]();
        Phantom phantom;
        phantom.volume.grid = centred_grid(settings, model.extent_mm);
        VoxelArray<std::int16_t> voxels(voxel_count(phantom.volume.grid));
        phantom::sample_layers(model.stack, phantom.volume.grid, arena, progress,
                               {voxels.data(), voxels.size()});
        voxels.freeze();
        phantom.volume.voxels = std::move(voxels);
        for (PhantomLandmark& landmark : model.landmarks)  // a small scan has a part of them
            if (is_in(phantom.volume.grid, landmark.push_point_mm))
                phantom.landmarks.push_back(std::move(landmark));
        phantom.volume.key_values.emplace_back("phantom", settings.name);
        for (auto& pair : model.key_values) phantom.volume.key_values.push_back(std::move(pair));
        note_landmarks(phantom.landmarks, phantom.volume.key_values);
        return phantom;
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, "phantom size: no memory for " +
                                                   std::to_string(settings.size.x) + "x" +
                                                   std::to_string(settings.size.y) + "x" +
                                                   std::to_string(settings.size.z) + " voxels"};
    }
}

}  // namespace pliant
