// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The tissue that a scan opens with if the user names none: the elastic scan where this machine
// makes enough pictures of it, or ChainMail.
//
// The pictures are measured: a ball is pushed voxel by voxel through the middle of the scan. A
// picture is a push, a sweep, and an update of the deformed scan, as the hub makes them while a
// client drags. The measured tissue is dropped. A session records the chosen model, so its replay
// measures nothing.

#pragma once

#include <pliant/core/tasks.h>

#include <functional>
#include <string>

#include "session/source.h"

namespace pliant::serve {

/// SceneSource::model and ServerSettings::model for which the model is chosen.
inline constexpr const char* kChosenModel = "auto";
/// Pictures a second from which on the elastic scan is chosen [Hz].
inline constexpr double kElasticRate_hz = 25;

struct FirstModel {
    std::string model{};   ///< empty: the scene's own, or ChainMail
    std::string reason{};  ///< one line; empty: it was named
};

/// Rate of pictures of the elastic scan while a tool pushes it: that of the median picture [Hz].
/// @param give_up  polled between pictures; may be empty
/// @returns an error if it can't be made, or nothing in it moves
Result<double> measure_elastic(const LoadedScan& loaded, const TaskArena& arena,
                               const std::function<bool()>& give_up = {});

/// Chooses the model of a scan without a tissue of its own.
FirstModel choose_model(const LoadedScan& loaded, const TaskArena& arena,
                        const std::function<bool()>& give_up = {});

}  // namespace pliant::serve
