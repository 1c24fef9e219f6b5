// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The chest around the airway: skin, fat, muscle, ribs, spine, heart and great vessels, lungs with
// their vessels, liver. A small chest: it must fit the airway's cube with the airway at full size.

#pragma once

#include "volume/layer_stack.h"
#include "volume/phantom_tubes.h"

namespace pliant::phantom {

/// Adds everything except the airway.
/// @param airway_outer  distance to the outside of the airway's wall
void add_chest(LayerStack& stack, const ScalarField& airway_outer);

}  // namespace pliant::phantom
