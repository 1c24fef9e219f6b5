// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The head around the nose: skin, skull, brain, eyes, jaw, pituitary gland.

#pragma once

#include "volume/layer_stack.h"

namespace pliant::phantom {

/// Adds everything except the air spaces and the structures in them.
void add_head(LayerStack& stack);

}  // namespace pliant::phantom
