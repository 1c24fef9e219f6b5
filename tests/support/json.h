// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json.hpp>

namespace pliant::test {

using Json = nlohmann::json;

}  // namespace pliant::test
