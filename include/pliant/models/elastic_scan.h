// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings of the elastic scan: linear elasticity on the scan's own voxels, with large rotations.
// make_elastic (tissues.h) makes the tissue; docs/method/elastic.md has the method.

#pragma once

#include <pliant/core/record.h>
#include <pliant/data/scan_values.h>
#include <pliant/models/material.h>
#include <pliant/result.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct ElasticScanSettings {
    struct Modulus {
        double value = 0;  ///< of a voxel
        double kpa = 0;    ///< Young's modulus; 0: void
        friend bool operator==(const Modulus&, const Modulus&) = default;
    };
    /// Young's modulus by voxel value: linear between values, constant beyond them. Ascending
    /// values. Empty: those of suit_elastic() for CT.
    std::vector<Modulus> moduli_kpa{};
    double poisson_ratio = 0.45;  ///< 0 … 0.495
    double held_above_hu = 300;   ///< voxels above it never move
    /// Sides of the scan that never move: "-x", "+x", … along its axes i, j, k. None: all sides
    /// that cut tissue.
    std::optional<std::vector<std::string>> held_sides{};
    double friction = 0;    ///< coefficient of a sphere along which tissue slides
    double return_s = 0.3;  ///< time in which released tissue returns to 1/e of its displacement
    /// Cells along the edge of each finer lattice around the tool.
    std::int32_t window_cells = 30;
    /// Tissues by label: the modulus of `elastic` and law Immobile have an effect, and
    /// bone_threshold_hu as held_above_hu. Voxels of law Constant aren't held by their value.
    std::vector<LabelMaterial> label_materials{};
    std::shared_ptr<const Volume> labels{};  ///< on the scan's grid; required by label_materials

    friend bool operator==(const ElasticScanSettings&, const ElasticScanSettings&) = default;
};
/// Rows of these settings, the table [elastic] of a settings file, except labels.
SettingRows<ElasticScanSettings> elastic_scan_rows() noexcept;

/// Checks the settings, for a table of moduli that may be empty.
/// @returns InvalidArgument that names the setting
Status check_elastic_scan(const ElasticScanSettings& settings) noexcept;

/// Sets the moduli and the threshold of bone for a scan's kind of values.
///
/// CT [HU → kPa]: air is void; lung 1.5 [LaiFook1981]; fat 3 [Samani2007]; muscle and parenchyma 8
/// to 10 [Arda2011]; above 150 HU, where contrast medium, cartilage and partial volume meet, up to
/// 100.
/// Other scans don't tell stiffness by value: 5 kPa, and void below the threshold of air.
void suit_elastic(const ValueDefaults& values, ElasticScanSettings& settings);

}  // namespace pliant
#pragma GCC visibility pop
