// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "serve/source.h"

#include <pliant/resample.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

namespace pliant::serve {
namespace {

/// Undo is to go back as far as its memory allows.
constexpr int kHistorySteps = 100'000;

std::string value_of(const KeyValues& pairs, const std::string& key) {
    for (const auto& [name, value] : pairs)
        if (name == key) return value;
    return {};
}

std::optional<double> number_of(const KeyValues& pairs, const std::string& key) {
    const std::string text = value_of(pairs, key);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (text.empty() || error != std::errc{} || !std::isfinite(number)) return {};
    return number;
}

template <class Values>
void find_range(const Values& values, VolumeInfo& info) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    info.lowest_hu = double(*low);
    info.highest_hu = double(*high);
}

}  // namespace

Result<LoadedScan> load_scan(const SceneSource& source, const TaskArena& arena) {
    LoadedScan loaded;
    if (source.file.empty()) {
        auto phantom = make_phantom({.name = source.phantom, .size = source.phantom_size}, arena);
        if (!phantom.ok()) return phantom.error();
        loaded.volume = std::move(phantom->volume);
        loaded.info.landmarks = std::move(phantom->landmarks);
        loaded.info.name = source.phantom + " phantom";
    } else {
        auto volume = read_volume(source.file, {source.series});
        if (!volume.ok()) return volume.error();
        loaded.volume = std::move(*volume);
        loaded.info.name = std::filesystem::path(source.file).filename().string();
    }
    const Vec3i size = loaded.volume.grid.size;
    if (std::max({size.x, size.y, size.z}) > 65535)
        return Error{ErrorCode::LimitExceeded,
                     loaded.info.name + ": expected up to 65535 voxels along an axis, found " +
                         std::to_string(std::max({size.x, size.y, size.z}))};
    loaded.info.grid = loaded.volume.grid;
    std::visit([&](const auto& values) { find_range(values, loaded.info); }, loaded.volume.voxels);
    // Scans may say how they want to be looked at, as our phantoms do.
    const KeyValues& keys = loaded.volume.key_values;
    loaded.iso_hu = std::clamp(number_of(keys, "iso_hu").value_or(-500), -32768.0, 32767.0);
    if (value_of(keys, "polarity") == "falling") loaded.polarity = Polarity::Falling;
    if (const auto bone = number_of(keys, "bone_threshold_hu"))
        loaded.settings.bone_threshold_hu = std::clamp(*bone, -32768.0, 32768.0);
    loaded.settings.history_max_steps = kHistorySteps;
    if (!loaded.info.landmarks.empty())
        loaded.info.start = Endoscope{.eye_mm = loaded.info.landmarks[0].eye_mm,
                                      .look = loaded.info.landmarks[0].look};
    else
        loaded.info.start = find_endoscope(loaded.volume, loaded.iso_hu, loaded.polarity, arena);
    loaded.hash = hash_volume(loaded.volume);
    return loaded;
}

}  // namespace pliant::serve
