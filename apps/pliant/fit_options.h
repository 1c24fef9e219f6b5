// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What `pliant fit` takes, on the command line and as a TOML file of the same names.

#pragma once

#include "options.h"

namespace CLI {
class App;
}

namespace pliant::app {

/// The file is read as the last thing that parsing does, so that what the command line says counts.
/// @throws CLI::Error from parsing, whose line names the option, or the file and its setting
void add_fit(CLI::App& app, FitOptions& options);

}  // namespace pliant::app
