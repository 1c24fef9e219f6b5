// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings checked field by field.

#pragma once

#include <pliant/chainmail.h>

namespace pliant {

/// @returns InvalidArgument that names the key, what was found and what was expected
Status check_settings(const ChainMailSettings& settings);

}  // namespace pliant
