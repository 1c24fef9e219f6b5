// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bodies of the study: blocks, and regions of scans.

#pragma once

#include <filesystem>
#include <vector>

#include "loads.h"

namespace pliant::results {

/// Blocks of 33 × 33 × 25 elements of 1 mm: four Poisson's ratios, layers, an inclusion.
std::vector<Body> blocks();
/// The lowest layer of a block is held, and the four sides if with_sides.
void hold_block(Body& body, bool with_sides);
/// A sphere at the top of a block, or inside, with a push of 0.1 to 0.8 radii.
Load random_block_load(int number);

/// Regions of the abdomen, the thorax and the head, with stiffnesses by label and value. Bone and
/// the outermost nodes are held.
std::vector<Body> scan_regions(const std::filesystem::path& scans);
/// A sphere in a region, away from held nodes.
Load random_scan_load(const Body& body, int number);

}  // namespace pliant::results
