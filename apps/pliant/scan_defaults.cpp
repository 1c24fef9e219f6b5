// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "scan_defaults.h"

namespace pliant::app {

ValueDefaults take_values(Volume& volume, const ReadNotes& notes) {
    const ValueDefaults values = value_defaults(volume, notes);
    volume.background = float(values.background);
    return values;
}

}  // namespace pliant::app
