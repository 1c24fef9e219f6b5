// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rows of settings in messages: those of the models, and the server's own.

#pragma once

#include <pliant/core/record.h>
#include <pliant/tissue.h>

#include "protocol/commands.h"

namespace pliant::serve {

/// Rows of a control lattice, beside spring_rows().
SettingRows<TissueChoice> tissue_rows() noexcept;
/// Rows of the visible surface.
SettingRows<IsoCommand> iso_rows() noexcept;
/// Rows of the depth that forces reach.
SettingRows<DepthCommand> depth_rows() noexcept;
/// Rows of the hand's motion.
SettingRows<DriveCommand> drive_rows() noexcept;

}  // namespace pliant::serve
