// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Surroundings of the ways of the phantoms.

#pragma once

#include "volume/layer_stack.h"

namespace pliant::phantom {

/// Adds everything of the chest except the airway.
/// @param airway_outer  distance to the outside of the airway's wall
void add_chest(LayerStack& stack, const ScalarField& airway_outer);

/// Adds everything of the head except the air spaces and the structures in them.
void add_head(LayerStack& stack);

}  // namespace pliant::phantom
