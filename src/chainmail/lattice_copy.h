// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A lattice as it is now, for those who look at it for longer than its owner can wait: all that
// moved, and all that was cut or carved. It costs a copy of the bricks that moved.

#pragma once

#include <memory>

#include "chainmail/lattice.h"

#pragma GCC visibility push(default)  // for other components
namespace pliant {

/// Keeps a reference to the volume, which is the lattice's own. Displacements and edits are those
/// of the original; materials of its bricks are not filled in, so nobody can push it.
std::unique_ptr<const Lattice> copy_of(const Lattice& lattice, const Volume& volume);

}  // namespace pliant
#pragma GCC visibility pop
