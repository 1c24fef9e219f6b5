// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The unit of a scan's values in pictures and messages.

#pragma once

#include <pliant/volume.h>

namespace pliant {

/// " HU" for CT, whose background is air; else nothing.
inline const char* value_unit(const Volume& volume) {
    return volume.background == float(kAirHu) ? " HU" : "";
}

}  // namespace pliant
