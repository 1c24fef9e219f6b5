// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Source of a scene's scan: a file or a generated phantom. A file may also be a vessel's scene
// (docs/howto/vessel.md) or one of organs (docs/howto/organs.md), with or without a scan, or an
// organ's mesh.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/core/tasks.h>
#include <pliant/models/catheter.h>
#include <pliant/models/scene_files.h>
#include <pliant/own_tissue.h>
#include <pliant/volume.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/messages.h"
#include "session/label_map.h"

namespace pliant::serve {

struct SceneSource {
    std::string file{};  ///< or folder; absolute. Empty: a phantom
    std::string series{};
    // Settings of ChainMail and the elastic scan, and the files of ChainMail's label materials;
    // absolute, may be empty.
    std::string config{}, labels{}, directions{};
    /// Of the tissue at first; empty: its own, or ChainMail; "auto": its own, or choose_model().
    std::string model{};
    std::string network{};  ///< file of a network that moves the scan; absolute, may be empty
    std::string phantom = "airway";
    Vec3i phantom_size{128, 128, 128};
    std::shared_ptr<const MakeTissue> own_tissue{};  ///< null: ChainMail, or the vessel
    std::optional<std::int64_t> frame{};             ///< of a 4-D image
    bool straighten = false;                         ///< ReadOptions
    std::optional<Vec3d> spacing_mm{};               ///< likewise
    std::string units{};                             ///< of ServerSettings
    /// Labels of `labels` of which bodies are made; empty: of all organs. None: no bodies.
    std::optional<std::vector<int>> bodies{};
    std::string label_names{};  ///< file of the bodies' names; absolute, may be empty

    /// Whether two sources name the same scan. Names of labels don't count.
    friend bool operator==(const SceneSource& a, const SceneSource& b) {
        return a.file == b.file && a.series == b.series && a.config == b.config &&
               a.model == b.model && a.labels == b.labels && a.directions == b.directions &&
               a.network == b.network && a.phantom == b.phantom &&
               a.phantom_size == b.phantom_size && a.frame == b.frame &&
               a.straighten == b.straighten && a.spacing_mm == b.spacing_mm && a.units == b.units &&
               a.bodies == b.bodies;
    }
};

struct LoadedScan {
    Volume volume;
    ChainMailSettings settings;
    ElasticScanSettings elastic{};
    bool has_chainmail_settings = false;  ///< the settings file has tables of ChainMail
    VolumeInfo info;
    double iso_hu = -500;  ///< initial threshold
    Polarity polarity = Polarity::Rising;
    /// hash_volume, combined with the hashes of the vessel or organ and of materials from files
    std::uint64_t hash = 0;
    std::shared_ptr<const MadeVessel> vessel{};  ///< set for a vessel's scene
    /// Tissues that only this scene has: "vessel", or "own". The last one is the initial one.
    std::map<std::string, MakeTissue> own_tissues{};
    std::shared_ptr<const LabelMap> bodies{};  ///< at rest; null unless there are several
};

/// Whether a file is a vessel's scene, by its extension.
bool is_vessel_scene(const std::filesystem::path& file);

/// @param give_up  polled while a scan is read; may be empty
Result<LoadedScan> load_scan(const SceneSource& source, const TaskArena& arena,
                             const std::function<bool()>& give_up = {});

}  // namespace pliant::serve
