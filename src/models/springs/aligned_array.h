// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cache-line-aligned vectors of numbers.

#pragma once

#include "base/aligned_array.h"

namespace pliant {

using AlignedArray = AlignedVector<double>;

}  // namespace pliant
