// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Checksums put right after a change, so that the readers behind them are reached.

#pragma once

#include <string>

#include "mutate/input.h"

namespace pliant::mutate {

/// Length and checksum of a saved state: a lattice (.plst), or a tissue of numbers as checkpoints
/// have it.
void repair_state(std::string& bytes);
/// The checksum at its end, as sessions name it.
std::string checksum_of_state(const std::string& bytes);
/// The chain of a session's lines (.pls); a line without a checksum gets one.
void repair_session(std::string& bytes);

}  // namespace pliant::mutate
