// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Opens a scene from uploaded files: finds the scan and checks that it may be read.

#pragma once

#include <pliant/tasks.h>

#include <string>
#include <variant>
#include <vector>

#include "formats/dicom_series.h"
#include "network/upload.h"
#include "serve/hub.h"

namespace pliant::serve {

/// A scene; or a list of DICOM series to choose from, if none of several was named.
using Opened = std::variant<NewScene, std::vector<DicomSeries>>;

/// Reads the scan, makes its scene, and keeps the files if a session needs them. Runs on a disk
/// thread. The arena is stored in the scene, but not used here.
/// @param series   UID of the DICOM series; may be empty
/// @param give_up  polled while the scan is read; may be empty
/// @returns one line that names the file as the client does
Result<Opened> open_upload(Upload& upload, const std::string& series,
                           const std::shared_ptr<const MakeTissue>& own_tissue,
                           const TaskArena& arena, const std::function<bool()>& give_up = {});

/// Reads a label map for a scan's grid. Runs on a disk thread.
/// @param give_up  polled while the map is read; may be empty
/// @returns one line that names the file as the client does
Result<std::shared_ptr<const LabelMap>> open_labels(Upload& upload, const Grid& scan,
                                                    const std::function<bool()>& give_up = {});

}  // namespace pliant::serve
