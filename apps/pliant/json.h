// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// JSON of reports: its keys stay in the order in which they are written.

#pragma once

#include <nlohmann/json.hpp>

namespace pliant::app {

using Json = nlohmann::ordered_json;

}  // namespace pliant::app
