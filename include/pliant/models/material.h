// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Materials of a ChainMail: the limits that elements set for the links around them, by voxel value,
// by label, or by direction.
//
// @code
//   ChainMailSettings settings;
//   settings.labels = std::make_shared<const Volume>(label_map);  // same grid as the scan
//   settings.label_materials = {{.values = {7}, .law = LabelLaw::Immobile},
//                               {.values = {3, 4}, .factor = {1, 0.2, 0.2}}};
// @endcode

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/vec.h>
#include <pliant/data/scan_values.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Moduli of a linear elastic solid.
struct ElasticPair {
    double young_modulus_kpa = 0;  ///< above 0
    double poisson_ratio = 0;      ///< 0 ≤ ν < 0.5
    friend bool operator==(const ElasticPair&, const ElasticPair&) = default;
};

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

/// Limits by voxel value, rounded to a whole number. ChainMail::create evaluates it for
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
    std::optional<ElasticPair> elastic{};     ///< not of ChainMail: of springs and the elastic scan
    Vec3d factor{1, 1, 1};                    ///< of all limits along i, j, k, 0…100
    // Constant: of a link along i, j, k, as a fraction of its length
    Vec3d compress{0, 0, 0};  ///< 0…1, also after multiplication by the factor
    Vec3d stretch{0, 0, 0};   ///< 0…100
    Vec3d shear{0, 0, 0};     ///< 0…100
    /// The three numbers of factor and limits refer to the lattice axis nearest to the direction
    /// field at the element and to the two axes after it, instead of to i, j, k.
    bool along_direction = false;

    friend bool operator==(const LabelMaterial&, const LabelMaterial&) = default;
};

/// Rows of a [[label]] table.
SettingRows<LabelMaterial> label_rows() noexcept;

/// Whether the limits alone rule out folds (docs/method/chainmail.md): they do if the number is
/// below 1. The number is the factor by which all limits could be divided to reach that bound.
struct FoldCertificate {
    bool certified = false;  ///< all < 1, and no link is outside of its limits
    double all = 0;          ///< over all materials
    double tissue = 0;       ///< over all materials except air
};

/// Algorithms that find the minimal move. All give the same bits.
enum class ChainMailSolver {
    Sweep,       ///< brick-wise sweeps, parallel, vectorised
    Heap,        ///< ordered propagation, one element at a time: the readable reference
    PlainSweep,  ///< the sweep in scalar code
};

struct ChainMailSettings {
    // [material]
    std::string law = "draeger";  ///< "draeger", the only named law; see draeger_law
    /// Values that the law maps to w = 0 (softest) and w = 1 (rigid): low < high. Those of float
    /// scans are resolved to 1/4095 of it, except in the default range, which rounds to whole HU.
    ValueSpan range{-1000, 3095};
    /// Instead of the range: percentiles of the scan's values, 0…100.
    std::optional<ValueSpan> range_percent{};
    double offset = 0.2;    ///< size of the chain regions, fraction of a link, 0 (rigid)…1
    Vec3d factor{1, 1, 1};  ///< of all limits along i, j, k, 0…100; not of air and labels
    double bone_threshold_hu = 300;  ///< bone, elements with a larger value, doesn't move
    /// Face-connected pieces above the threshold of less than this volume, not cut by the scan's
    /// border, are no bone, but stiff and movable; 0: each element is bone, as in [Draeger2005].
    double smallest_bone_mm3 = 100;
    double max_movement_mm = 20;  ///< movement limit of the softest element, 0…500
    LinkLimits limits = LinkLimits::Box;
    double yield = 0;  ///< strain beyond this fraction of the limits remains; 0: none remains
    // [push]
    double scale = 1;  ///< factor of every push
    // [lattice]
    int brick_size = 8;    ///< elements along a brick's edge, 2…32
    bool bounded = false;  ///< the lattice ends at the scan's border; else it continues as air
    std::int64_t max_elements = 150'000'000;  ///< a push that needs more (about 4 GB) is refused
    // [air]
    bool air_enabled = true;         ///< air is a separate material outside of the law
    double air_threshold_hu = -500;  ///< smaller values are air, which a sphere doesn't grab
    double air_compress = 0.98;      ///< fraction of its length that a link can lose, 0…1
    double air_stretch = 50;         ///< fraction that it can gain, 0…500
    double air_shear = 50;           ///< sideways slack as a fraction of its length, 0…500
    // [[label]]
    std::vector<LabelMaterial> label_materials{};
    std::shared_ptr<const Volume> labels{};           ///< on the scan's grid (labels_on);
                                                      ///< required by label_materials
    std::shared_ptr<const VectorField> directions{};  ///< on the scan's grid; required by
                                                      ///< along_direction
    // [history]
    int history_max_steps = 200;  ///< number of steps that can be undone, 0…100000; 0 disables the
                                  ///< history
    int history_max_mb = 256;     ///< memory for these steps, 10⁶ bytes; the oldest are forgotten
                                  ///< first

    std::size_t history_max_bytes() const { return std::size_t(history_max_mb) * 1'000'000; }

    ChainMailSolver solver = ChainMailSolver::Sweep;
    MaterialLaw custom_law{};  ///< if set, replaces the named law and air
};

/// Rows of all settings that a file can have, except those of [[label]] tables.
SettingRows<ChainMailSettings> chainmail_rows() noexcept;
/// Rows of [material] and [air], which set_materials() can change.
SettingRows<ChainMailSettings> chainmail_material_rows() noexcept;

/// Reads TOML with the tables above, or the key=value lines of Divod's configuration [Draeger2005,
/// 4.6].
/// @param[out] notes  keys of Divod without a meaning here, one line each; may be null
/// @returns Error with file, key, found and expected value
Result<ChainMailSettings> read_chainmail_settings(const std::filesystem::path& path,
                                                  std::vector<std::string>* notes = nullptr);

/// Law of [Draeger2005, 3.5.5 and 3.6.2]. With w = clamp((v − low)/(high − low), 0, 1) over the
/// range, all limits are offset·(1 − w²)·factor, and the movement limit is
/// (1 − w²)·max_movement_mm. range_percent is ignored.
MaterialLaw draeger_law(const ChainMailSettings& settings);

/// Sets range, thresholds and air to those that suit a scan; nothing changes for CT in HU.
void suit_materials(const ValueDefaults& values, ChainMailSettings& settings);
/// Sets the thresholds and air to those that suit a scan with the settings' range.
void suit_thresholds(const ValueDefaults& values, ChainMailSettings& settings);

/// Reads a settings file for a scan: settings that the file doesn't name suit the scan's values.
/// @param limits  of a TOML file that names none; a file of Divod has those of a box, and each
///                voxel above the threshold is bone, as in the thesis
Result<ChainMailSettings> read_chainmail_settings(const std::filesystem::path& path,
                                                  const ValueDefaults& values,
                                                  std::vector<std::string>* notes = nullptr,
                                                  LinkLimits limits = LinkLimits::Box);

}  // namespace pliant
#pragma GCC visibility pop
