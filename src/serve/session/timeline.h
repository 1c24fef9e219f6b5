// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Times of a session's records, for its time line.

#pragma once

#include <span>
#include <vector>

#include "protocol/messages.h"
#include "session/session_log.h"

namespace pliant::serve {

/// Times of the records, ascending, and the session's length as the last entry [ms]. Records
/// between two SessionWait are spread evenly over at most kSpread_ms. A session without them has
/// one record every kUntimed_ms.
std::vector<double> times_of(std::span<const SessionRecord> records);
inline constexpr double kSpread_ms = 100, kUntimed_ms = 1000.0 / 60;

/// Begins of strokes, and other commands to the scene.
/// @param times  times_of(records)
std::vector<TimelineMark> marks_of(std::span<const SessionRecord> records,
                                   std::span<const double> times);

}  // namespace pliant::serve
