// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What of a scan is neither organ nor air, around the organs: fat, muscle, the wall. It holds the
// organs in place, and they slide on it.

#pragma once

#include <pliant/organs.h>

#include <span>

namespace pliant {

/// A body of tetrahedra that fills a box around the organs, without the organs and the air. Its
/// nodes on the box's faces are held.
/// @param tetrahedra  about so many
Result<Organ> make_surroundings(std::span<const Organ> organs, const Volume& scan,
                                double thickness_mm, std::int64_t tetrahedra,
                                const TaskArena& arena);

}  // namespace pliant
