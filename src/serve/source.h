// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Where a scene's scan comes from: a file, or a phantom that is made.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/tasks.h>
#include <pliant/volume.h>

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
    std::uint64_t hash = 0;  ///< hash_volume
};

Result<LoadedScan> load_scan(const SceneSource& source, const TaskArena& arena);

}  // namespace pliant::serve
