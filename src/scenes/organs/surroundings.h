// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Surroundings of the organs: fat, muscle and wall, without air. They hold the organs in place, and
// the organs slide on them.

#pragma once

#include <pliant/models/organs.h>

#include <span>

namespace pliant {

/// A body of tetrahedra that fills a box around the organs, without the organs and the air. Its
/// nodes on the box's faces are held.
/// @param tetrahedra  approximate number
Result<Organ> make_surroundings(std::span<const Organ> organs, const Volume& scan,
                                double thickness_mm, std::int64_t tetrahedra,
                                const TaskArena& arena);

}  // namespace pliant
