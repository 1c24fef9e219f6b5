// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Device plug-ins, loaded at run time (pliant/view/haptics_device.h).

#pragma once

#include <pliant/view/haptics.h>

namespace pliant {

/// Loads a file, or a library of the system. @returns null; why, unless it says something already
void* load_library(const std::string& name, std::string& why);

Result<std::unique_ptr<HapticDevice>> open_plugin_device(const std::string& library,
                                                         const std::string& which);

}  // namespace pliant
