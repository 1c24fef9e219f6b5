// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Materials of a ChainMail: the limits that elements set for the links around them, by voxel value,
// by label, or by direction.
//
//   auto labels = std::make_shared<const Volume>(…);  // same grid as the scan
//   ChainMailSettings settings;
//   settings.labels = labels;
//   settings.label_materials = {{.values = {7}, .law = LabelLaw::Immobile},
//                               {.values = {3, 4}, .factor = {1, 0.2, 0.2}}};

#pragma once

#include <pliant/record.h>
#include <pliant/vec.h>

#include <functional>
#include <optional>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Limits that one element sets for the links around it. A link takes the mean of its two ends.
struct ElementLimits {
    Vec3d compress{0, 0, 0};  ///< fraction of its length that a link along i, j, k can lose, 0…1
    Vec3d stretch{0, 0, 0};   ///< fraction that it can gain, ≥ 0
    Vec3d shear{0, 0, 0};     ///< sideways slack as a fraction of its length, ≥ 0
    double max_movement_mm = 0;  ///< largest Euclidean distance from the rest position, ≥ 0
    bool fixed = false;          ///< bone: never moves
    /// Strain beyond this fraction of the link's limits stays as an imprint, 0…1; 0: none stays.
    double yield = 0;
};

/// Limits by voxel value [HU, rounded to a whole number]. ChainMail::create evaluates it for
/// −32767…32767, and refuses numbers outside of their ranges.
using MaterialLaw = std::function<ElementLimits(int value_hu)>;

/// How the limits of the links around an element combine.
enum class LinkLimits {
    Box,      ///< each link by itself: a push of homogeneous tissue forms an octahedron
    Rounded,  ///< beside that, an ellipsoid over the links to the neighbours that lead an element
};

enum class LabelLaw {
    ByValue,   ///< the main law with separate numbers
    Constant,  ///< the limits given here, for every value
    Immobile,  ///< never moves
};

/// Material of the elements with certain labels, instead of the main law and of air.
struct LabelMaterial {
    std::vector<int> values{};  ///< of the label volume
    LabelLaw law = LabelLaw::ByValue;
    // ByValue; where empty, as in [material]
    std::optional<double> offset{};             ///< fraction of a link, 0…1
    std::optional<double> bone_threshold_hu{};  ///< values above it don't move
    // ByValue and Constant
    std::optional<double> max_movement_mm{};  ///< 0…500
    std::optional<double> yield{};            ///< fraction of the limits, 0…1
    Vec3d factor{1, 1, 1};                    ///< of all limits along i, j, k, 0…100
    // Constant: of a link along i, j, k, as a fraction of its length
    Vec3d compress{0, 0, 0};  ///< 0…1, also after multiplication by the factor
    Vec3d stretch{0, 0, 0};   ///< 0…100
    Vec3d shear{0, 0, 0};     ///< 0…100
    /// The three numbers of factor and limits refer to the lattice axis nearest to the direction
    /// field at the element and to the two axes after it, instead of to i, j, k.
    bool along_direction = false;
};

/// Rows of a [[label]] table.
SettingRows<LabelMaterial> label_rows() noexcept;

/// Whether the limits alone rule out folds (docs/chainmail.md): they do if the number is below 1.
/// The number is the factor by which all limits could be divided to reach that bound.
struct FoldCertificate {
    bool certified = false;  ///< all < 1, and no link is outside of its limits
    double all = 0;          ///< over all materials
    double tissue = 0;       ///< over all materials except air
};

}  // namespace pliant
#pragma GCC visibility pop
