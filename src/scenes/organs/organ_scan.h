// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan of organs alone: soft tissue in air, so that their surface is at −500 HU, with some 100
// voxels along the longest side. The inside has a faint pattern that moves with the tissue.

#pragma once

#include <pliant/models/organs.h>

#include <span>

namespace pliant {

/// @param contents  closed surfaces inside the organs, drawn with values of their own
Result<Volume> scan_of_organs(std::span<const Organ> organs,
                              std::span<const OrganContents> contents, const TaskArena& arena);

}  // namespace pliant
