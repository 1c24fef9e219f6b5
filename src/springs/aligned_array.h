// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Numbers that start at a cache line, as vector loads like them.

#pragma once

#include "core/aligned_array.h"

namespace pliant {

using AlignedArray = AlignedVector<double>;

}  // namespace pliant
