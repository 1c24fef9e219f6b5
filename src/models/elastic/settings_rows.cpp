// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/elastic_scan.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/errors.h"
#include "base/text.h"

namespace pliant {
namespace {

using E = ElasticScanSettings;

constexpr Setting<E> kModuli = {
    {.name = "moduli_kpa",
     .unit = "value, kPa",
     .text = "Young's modulus by voxel value, 0: void; without it, moduli that suit the scan",
     .kind = SettingKind::Pairs},
    [](const E& e) -> SettingValue {
        std::vector<NumberPair> pairs;
        for (const E::Modulus& m : e.moduli_kpa) pairs.push_back({m.value, m.kpa});
        return pairs;
    },
    [](E& e, const SettingValue& value) {
        e.moduli_kpa.clear();
        for (const auto& [of_value, kpa] : *std::get_if<std::vector<NumberPair>>(&value))
            e.moduli_kpa.push_back({of_value, kpa});
    }};

constexpr auto kRows = in_table<E>(
    "elastic",
    {
        kModuli,
        setting<&E::poisson_ratio>({.name = "poisson_ratio",
                                    .range = {0, 0.495},
                                    .text = "Poisson's ratio of tissue; voids have 0"}),
        setting<&E::held_above_hu>({.name = "held_above_hu",
                                    .unit = "HU",
                                    .text = "larger values are bone, which never moves"}),
        setting<&E::held_sides>({.name = "held_sides",
                                 .choices = "-x|+x|-y|+y|-z|+z",
                                 .text = "sides of the scan, along its axes, that never move; "
                                         "without it, all that cut tissue"}),
        setting<&E::friction>({.name = "friction",
                               .range = {0, 5},
                               .text = "coefficient of friction of a sphere that slides"}),
        setting<&E::return_s>({.name = "return_s",
                               .unit = "s",
                               .range = {1e-3, 1e3},
                               .text = "time in which released tissue returns to 1/e"}),
        setting<&E::window_cells>({.name = "window_cells",
                                   .unit = "cells",
                                   .range = {8, 512},
                                   .text = "edge of the finer lattices around a tool; even"}),
    });

Status check_moduli(const std::vector<E::Modulus>& moduli) {
    double largest = 0;
    for (std::size_t n = 0; n < moduli.size(); ++n) {
        const auto& [value, kpa] = moduli[n];
        if (!(std::abs(value) <= 1e9) || !(kpa >= 0 && kpa <= 1e8))
            return expected_error("[elastic] moduli_kpa", "values and moduli of 0 to 1e8 kPa",
                                  text_of(value) + ", " + text_of(kpa));
        if (n > 0 && !(value > moduli[n - 1].value))
            return expected_error("[elastic] moduli_kpa", "ascending values",
                                  text_of(value) + " after " + text_of(moduli[n - 1].value));
        largest = std::max(largest, kpa);
    }
    if (!moduli.empty() && largest == 0)
        return expected_error("[elastic] moduli_kpa", "a modulus above 0 kPa", "0 kPa everywhere");
    return Ok{};
}

}  // namespace

SettingRows<ElasticScanSettings> elastic_scan_rows() noexcept {
    return kRows;
}

Status check_elastic_scan(const ElasticScanSettings& settings) noexcept {
    return attempt([&]() -> Status {
        if (const Status s = check(settings, elastic_scan_rows()); !s.ok()) return s.error();
        if (settings.window_cells % 2 != 0)
            return expected_error("[elastic] window_cells", "an even number",
                                  std::to_string(settings.window_cells));
        return check_moduli(settings.moduli_kpa);
    });
}

void suit_elastic(const ValueDefaults& values, ElasticScanSettings& settings) {
    settings.held_above_hu = values.bone_threshold;  // of scans without bone, the highest value
    if (values.kind == ValueKind::Hounsfield) {
        settings.moduli_kpa = {{-1000, 0}, {-950, 0}, {-900, 1.5}, {-500, 2}, {-150, 3},
                               {-30, 3},   {20, 8},   {60, 10},    {150, 20}, {300, 100}};
        return;
    }
    constexpr double kTissueKpa = 5;
    settings.moduli_kpa = {{values.range.low, kTissueKpa}};
    if (values.has_air)
        settings.moduli_kpa = {
            {values.air_threshold, 0},
            {values.air_threshold + 0.01 * (values.range.high - values.range.low), kTissueKpa}};
}

}  // namespace pliant
