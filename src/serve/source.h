// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Where a scene's scan comes from: a file, or a phantom that is made. A file may also be the scene
// of a vessel (docs/vessel.md), which names a scan or is given one.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/tasks.h>
#include <pliant/vessel_scene.h>
#include <pliant/volume.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "serve/messages.h"

namespace pliant::serve {

struct SceneSource {
    std::string file{};  ///< or folder; absolute. Empty: a phantom
    std::string series{};
    std::string phantom = "airway";
    Vec3i phantom_size{128, 128, 128};

    friend bool operator==(const SceneSource&, const SceneSource&) = default;
};

struct LoadedScan {
    Volume volume;
    ChainMailSettings settings;
    VolumeInfo info;
    double iso_hu = -500;  ///< to begin with
    Polarity polarity = Polarity::Rising;
    std::uint64_t hash = 0;                      ///< hash_volume, with a vessel also of that
    std::shared_ptr<const MadeVessel> vessel{};  ///< where the file is a vessel's scene
};

/// Whether a file is a vessel's scene, by its name.
bool is_vessel_scene(const std::filesystem::path& file);

/// @param give_up  asked now and then while a scan is read; may be empty
Result<LoadedScan> load_scan(const SceneSource& source, const TaskArena& arena,
                             const std::function<bool()>& give_up = {});

}  // namespace pliant::serve
