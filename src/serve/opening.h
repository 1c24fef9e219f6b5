// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// From files that came in to a scene: which of them is the scan, and whether it may be read.

#pragma once

#include <pliant/tasks.h>

#include <span>
#include <string>
#include <variant>
#include <vector>

#include "serve/hub.h"
#include "serve/upload.h"
#include "volume/dicom_series.h"

namespace pliant::serve {

/// A scene; or the series of a folder of DICOM slices, where there are several and none is named.
using Opened = std::variant<NewScene, std::vector<DicomSeries>>;

/// Reads the scan, makes its scene, and keeps the files if a session needs them. On a thread that
/// has time; the arena is the scene's later on, and isn't used here.
/// @param series   UID of the DICOM series that is meant; may be empty
/// @param give_up  asked now and then while the scan is read; may be empty
/// @returns one line that names the file as the client does
Result<Opened> open_upload(Upload& upload, const std::string& series, const TaskArena& arena,
                           const std::function<bool()>& give_up = {});

/// The series that there are, as JSON.
std::string series_text(std::span<const DicomSeries> list);

}  // namespace pliant::serve
