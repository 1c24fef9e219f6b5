// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Options of `pliant fit`, on the command line and as a TOML file with the same names.

#pragma once

#include "options.h"

namespace CLI {
class App;
}

namespace pliant::app {

/// The file is read after the command line, whose options take precedence.
/// @throws CLI::Error from parsing, whose line names the option, or the file and its setting
void add_fit(CLI::App& app, FitOptions& options);

}  // namespace pliant::app
