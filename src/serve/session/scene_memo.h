// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// State of a resting scene except its tissue: no tissue is held, and no step is open.

#pragma once

#include <pliant/render.h>

#include <cstdint>

#include "protocol/tissue_choice.h"

namespace pliant::serve {

struct SceneMemo {
    double iso_hu = 0;
    Polarity polarity = Polarity::Rising;
    bool relaxing = false, settled = true;
    std::uint32_t last_client = 0;
    std::int64_t steps = 0;  ///< steps of undo made so far, including dropped ones
    TissueChoice tissue{};

    friend bool operator==(const SceneMemo&, const SceneMemo&) = default;
};

}  // namespace pliant::serve
