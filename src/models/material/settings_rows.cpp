// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The tables of ChainMail's settings. The order is that of a settings file.

#include <pliant/models/material.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "field/field.h"
#include "material/limit_units.h"

namespace pliant {
namespace {

using S = ChainMailSettings;
using L = LabelMaterial;

std::vector<double> numbers_of(ValueSpan span) {
    return {span.low, span.high};
}
ValueSpan span_of(const SettingValue& value) {
    const auto& numbers = *std::get_if<std::vector<double>>(&value);
    return {numbers[0], numbers[1]};
}

constexpr Setting<S> kRange = {{.name = "range",
                                .count = 2,
                                .text = "values of the softest and of the hardest element",
                                .kind = SettingKind::Numbers},
                               [](const S& s) -> SettingValue { return numbers_of(s.range); },
                               [](S& s, const SettingValue& value) { s.range = span_of(value); }};
constexpr Setting<S> kRangePercent = {
    {.name = "range_percent",
     .range = {0, 100},
     .count = 2,
     .text = "instead of range: percentiles of the scan's values",
     .kind = SettingKind::Numbers,
     .is_optional = true},
    [](const S& s) -> SettingValue {
        return s.range_percent ? SettingValue(numbers_of(*s.range_percent)) : SettingValue();
    },
    [](S& s, const SettingValue& value) { s.range_percent = span_of(value); }};

constexpr Setting<S> kMaterialRows[] = {
    setting<&S::law>(
        {.name = "law", .choices = "draeger", .text = "how limits follow from the voxel value"}),
    kRange,
    kRangePercent,
    setting<&S::offset>(
        {.name = "offset",
         .range = {0, 1},
         .text = "slack of the softest link, as a fraction of its length; 0: rigid"}),
    setting<&S::factor>({.name = "factor",
                         .range = {0, 100},
                         .text = "factor of all limits; one number, or three for i, j, k"}),
    setting<&S::bone_threshold_hu>({.name = "bone_threshold_hu",
                                    .unit = "HU",
                                    .text = "bone, elements with a larger value, doesn't move"}),
    setting<&S::smallest_bone_mm3>(
        {.name = "smallest_bone_mm3",
         .unit = "mm³",
         .range = {.low = 0},
         .text = "smaller pieces above the threshold are stiff and movable; 0: all is bone"}),
    setting<&S::max_movement_mm>(
        {.name = "max_movement_mm",
         .unit = "mm",
         .range = {0, kMaxMovementMm},
         .text = "largest distance from the rest position, for the softest element"}),
    setting<&S::yield>({.name = "yield",
                        .range = {0, 1},
                        .text = "strain beyond this fraction of the limits stays; 0: none stays"}),
    setting<&S::limits>({.name = "limits",
                         .choices = "box|rounded",
                         .text = "how the limits of the links around an element combine; rounded: "
                                 "round contours"}),
};
constexpr Setting<S> kPushRows[] = {
    setting<&S::scale>(
        {.name = "scale", .range = {0, 1000}, .above_low = true, .text = "factor of each push"}),
};
constexpr Setting<S> kLatticeRows[] = {
    setting<&S::brick_size>({.name = "brick_size",
                             .unit = "elements",
                             .range = {2, kMaxBrickSize},
                             .text = "edge of a brick"}),
    setting<&S::bounded>({.name = "bounded",
                          .text = "the lattice ends at the scan's border; else it goes on in air"}),
    setting<&S::max_elements>({.name = "max_elements",
                               .unit = "elements",
                               .range = {.low = 1},
                               .text = "a push that would need more (about 4 GB) is refused"}),
};
constexpr Setting<S> kHistoryRows[] = {
    setting<&S::history_max_steps>({.key = "max_steps",
                                    .name = "history_max_steps",
                                    .unit = "steps",
                                    .range = {0, 100'000},
                                    .text = "number of steps that can be undone"}),
    setting<&S::history_max_mb>({.key = "max_mb",
                                 .name = "history_max_mb",
                                 .unit = "MB",
                                 .range = {0, 1'000'000},
                                 .text = "memory for these steps; the oldest are forgotten first"}),
};
constexpr Setting<S> kAirRows[] = {
    setting<&S::air_enabled>(
        {.key = "enabled", .name = "air_enabled", .text = "air is a material of its own"}),
    setting<&S::air_threshold_hu>({.key = "threshold_hu",
                                   .name = "air_threshold_hu",
                                   .unit = "HU",
                                   .text = "values below it are air; a sphere does not grab them"}),
    setting<&S::air_compress>({.key = "compress",
                               .name = "air_compress",
                               .range = {0, 1},
                               .text = "fraction of its length that a link in air can lose"}),
    setting<&S::air_stretch>({.key = "stretch",
                              .name = "air_stretch",
                              .range = {0, 500},
                              .text = "fraction of its length that a link in air can gain"}),
    setting<&S::air_shear>(
        {.key = "shear",
         .name = "air_shear",
         .range = {0, 500},
         .text = "sideways slack of a link in air, as a fraction of its length"}),
};
constexpr auto kSettings = joined(in_table("material", kMaterialRows), in_table("push", kPushRows),
                                  in_table("lattice", kLatticeRows),
                                  in_table("history", kHistoryRows), in_table("air", kAirRows));

constexpr Setting<L> kLabelRows[] = {
    setting<&L::values>({.name = "values",
                         .range = {-32768, 65535},
                         .text = "labels that have this material; one or a list"}),
    setting<&L::law>({.name = "law",
                      .choices = "draeger|constant|fixed",
                      .text = "by value, the limits given here, or immobile"}),
    setting<&L::offset>(
        {.name = "offset", .range = {0, 1}, .text = "as in [material], for law \"draeger\""}),
    setting<&L::bone_threshold_hu>({.name = "bone_threshold_hu",
                                    .unit = "HU",
                                    .text = "as in [material], for law \"draeger\""}),
    setting<&L::max_movement_mm>({.name = "max_movement_mm",
                                  .unit = "mm",
                                  .range = {0, kMaxMovementMm},
                                  .text = "as in [material]"}),
    setting<&L::yield>({.name = "yield", .range = {0, 1}, .text = "as in [material]"}),
    {{.name = "elastic",
      .range = {.low = 0},
      .count = 2,
      .text = "of springs and the elastic scan: Young's modulus [kPa], Poisson's ratio",
      .kind = SettingKind::Numbers,
      .is_optional = true},
     [](const L& label) -> SettingValue {
         if (!label.elastic) return {};
         return std::vector{label.elastic->young_modulus_kpa, label.elastic->poisson_ratio};
     },
     [](L& label, const SettingValue& value) {
         const auto& numbers = *std::get_if<std::vector<double>>(&value);
         label.elastic = {numbers[0], numbers[1]};
     }},
    setting<&L::factor>({.name = "factor",
                         .range = {0, 100},
                         .text = "factor of all limits; one number, or three for i, j, k"}),
    setting<&L::compress>({.name = "compress",
                           .range = {0, 1},
                           .text = "for law \"constant\": fraction of its length that a link can "
                                   "lose, also times factor; one number or three"}),
    setting<&L::stretch>({.name = "stretch",
                          .range = {0, 100},
                          .text = "for law \"constant\": fraction that it can gain"}),
    setting<&L::shear>(
        {.name = "shear", .range = {0, 100}, .text = "for law \"constant\": sideways slack"}),
    setting<&L::along_direction>({.key = "frame",
                                  .name = "along_direction",
                                  .choices = "lattice|direction",
                                  .text = "axes of the three numbers: i, j, k, or along and across "
                                          "the direction field"}),
};
constexpr auto kLabel = in_table("label", kLabelRows);

constexpr bool is_of_materials(const SettingInfo& row) {
    return row.table == "material" || row.table == "air";
}
constexpr auto kMaterials = [] {
    std::array<Setting<S>, std::size_t(std::ranges::count_if(kSettings, is_of_materials))> rows;
    std::ranges::copy_if(kSettings, rows.begin(), is_of_materials);
    return rows;
}();

}  // namespace

SettingRows<ChainMailSettings> chainmail_rows() noexcept {
    return kSettings;
}

SettingRows<ChainMailSettings> chainmail_material_rows() noexcept {
    return kMaterials;
}

SettingRows<LabelMaterial> label_rows() noexcept {
    return kLabel;
}

}  // namespace pliant
