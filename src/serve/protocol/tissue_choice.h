// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The model of a scene's tissue, and its settings.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/core/vec.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace pliant::serve {

/// Settings of springs that follow the scan's values unless they are given.
inline constexpr std::array<std::string_view, 2> kFollowing = {"air_threshold_hu", "fixed_hu"};

struct TissueChoice {
    /// As in tissue_models(); "own" is the scene's own tissue, whatever its model.
    std::string model = "chainmail";
    // Springs: number of nodes of the control lattice along each axis,
    // limited by the size of the scan.
    Vec3d centre_mm{0, 0, 0};
    int nodes = 20;
    bool depth_by_time = false;  ///< the server adapts the depth of forces to time and lines
    SpringDeformationSettings springs{};
    std::vector<std::string> given{};  ///< names of kFollowing, in its order
    Record elastic{};  ///< given settings of the elastic scan; the others follow the scan

    bool is_springs() const { return model == "springs"; }
    bool is_elastic() const { return model == "elastic"; }
    friend bool operator==(const TissueChoice&, const TissueChoice&) = default;
};

/// Whether a setting of springs follows the scan, whatever `springs` has.
inline bool follows_scan(const TissueChoice& choice, std::string_view name) {
    return std::find(kFollowing.begin(), kFollowing.end(), name) != kFollowing.end() &&
           std::find(choice.given.begin(), choice.given.end(), name) == choice.given.end();
}

}  // namespace pliant::serve
