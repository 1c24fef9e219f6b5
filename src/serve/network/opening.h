// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Opens a scene from uploaded files: finds the scan and checks that it may be read.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/scan_files.h>

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "hub/hub.h"
#include "network/upload.h"

namespace pliant::serve {

/// Number of a scan's images, from which one must be chosen.
struct ImageCount {
    std::int64_t images = 0;
};
/// A scene; or DICOM series or images to choose from, if none of several was named.
using Opened = std::variant<NewScene, std::vector<DicomSeries>, ImageCount>;

/// The client's choice among several scans.
struct ScanWish {
    std::string series{};                 ///< UID of the DICOM series; may be empty
    std::optional<std::int64_t> frame{};  ///< image, from 0
};

/// Tissue of opened scenes.
struct TissueWish {
    const std::shared_ptr<const MakeTissue>& own_tissue;  ///< null: the model
    const std::string& model;  ///< as SceneSource::model; meshes have a model of their own
};

/// Reads the scan, makes its scene, and keeps the files if a session needs them. Runs on a disk
/// thread. The arena is stored in the scene, and used here to choose its model only.
/// @param give_up  polled while the scan is read; may be empty
/// @returns one line that names the file as the client does
Result<Opened> open_upload(Upload& upload, const ScanWish& wish, const TissueWish& tissue,
                           const TaskArena& arena, const std::function<bool()>& give_up = {});

/// File of an uploaded state of the tissue, in its permanent folder.
struct UploadedState {
    std::filesystem::path file;
    std::string recorded;  ///< its name in the session
};
/// Keeps the state's file if a session needs it. Runs on a disk thread.
Result<UploadedState> keep_state(Upload& upload);
/// Replaces server paths in a message by the client's file names.
std::string plain_message(const std::string& message, const Upload& upload,
                          const std::filesystem::path& file);

/// Reads a label map for a scan's grid. Runs on a disk thread.
/// @param give_up  polled while the map is read; may be empty
/// @returns one line that names the file as the client does
Result<std::shared_ptr<const LabelMap>> open_labels(Upload& upload, const Grid& scan,
                                                    const std::function<bool()>& give_up = {});

}  // namespace pliant::serve
