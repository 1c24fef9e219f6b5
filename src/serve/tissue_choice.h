// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Which model a scene's tissue is, and what it is made with.

#pragma once

#include <pliant/vec.h>

namespace pliant::serve {

struct TissueChoice {
    bool vessel = false;   ///< the scene's own, with a catheter in it
    bool springs = false;  ///< else ChainMail or the vessel, and the rest has no meaning
    // A control lattice of so many nodes along each axis, or as many as the scan has place for.
    Vec3d centre_mm{0, 0, 0};
    int nodes = 20;
    double cell_mm = 8;
    double young_modulus_pa = 15e3;
    double fixed_hu = 300;
    int depth = 10;

    friend bool operator==(const TissueChoice&, const TissueChoice&) = default;
};

constexpr const char* name_of(const TissueChoice& choice) {
    return choice.vessel ? "vessel" : choice.springs ? "springs" : "chainmail";
}

}  // namespace pliant::serve
