// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The model of a scene's tissue, and its settings.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/tissue.h>
#include <pliant/vec.h>

namespace pliant::serve {

enum class TissueModel { ChainMail, Springs, Vessel, Own };

struct TissueChoice {
    TissueModel model = TissueModel::ChainMail;
    // Springs: number of nodes of the control lattice along each axis,
    // limited by the size of the scan.
    Vec3d centre_mm{0, 0, 0};
    int nodes = 20;
    bool depth_by_time = false;  ///< the server adapts the depth of forces to time and lines
    SpringDeformationSettings springs{};

    friend bool operator==(const TissueChoice&, const TissueChoice&) = default;
};

constexpr const char* name_of(TissueModel model) {
    constexpr const char* kNames[] = {"chainmail", "springs", "vessel", "own"};
    return kNames[int(model)];
}

}  // namespace pliant::serve
