// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The connected components of a network.

#pragma once

#include <pliant/models/springs.h>

namespace pliant {

struct Pieces {
    std::int32_t count = 0;
    std::vector<std::int32_t> piece_of;  ///< [node]; node 0 is in piece 0
};
Pieces pieces_of(const SpringNetwork& network);

}  // namespace pliant
