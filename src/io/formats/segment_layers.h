// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pliant/volume.h>

#include <cstdint>

namespace pliant {

/// Keeps the keys of the segments in one layer of 3D Slicer's, which becomes layer 0. Segments
/// without a layer stay.
void keep_layer(KeyValues& keys, std::int64_t layer);

}  // namespace pliant
