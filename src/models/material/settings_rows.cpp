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

constexpr Setting<S> kRange = {{.table = "material",
                                .name = "range",
                                .count = 2,
                                .text = "values of the softest and of the hardest element",
                                .kind = SettingKind::Numbers},
                               [](const S& s) -> SettingValue { return numbers_of(s.range); },
                               [](S& s, const SettingValue& value) { s.range = span_of(value); }};
constexpr Setting<S> kRangePercent = {
    {.table = "material",
     .name = "range_percent",
     .low = 0,
     .high = 100,
     .count = 2,
     .text = "instead of range: percentiles of the scan's values",
     .kind = SettingKind::Numbers,
     .is_optional = true},
    [](const S& s) -> SettingValue {
        return s.range_percent ? SettingValue(numbers_of(*s.range_percent)) : SettingValue();
    },
    [](S& s, const SettingValue& value) { s.range_percent = span_of(value); }};

/// A row of an elastic material, of [material] or of a [[label]].
template <class Owner>
constexpr Setting<Owner> elastic_row(const char* table) {
    return {{.table = table,
             .name = "elastic",
             .low = 0,
             .count = 2,
             .text = "Young's modulus [kPa] and Poisson's ratio that relaxation approximates",
             .kind = SettingKind::Numbers,
             .is_optional = true},
            [](const Owner& owner) -> SettingValue {
                if (!owner.elastic) return {};
                return std::vector{owner.elastic->young_modulus_kpa, owner.elastic->poisson_ratio};
            },
            [](Owner& owner, const SettingValue& value) {
                const auto& numbers = *std::get_if<std::vector<double>>(&value);
                owner.elastic = {numbers[0], numbers[1]};
            }};
}

constexpr Setting<S> kSettings[] = {
    setting<&S::law>({.table = "material",
                      .name = "law",
                      .choices = "draeger",
                      .text = "how limits follow from the voxel value"}),
    kRange,
    kRangePercent,
    setting<&S::offset>(
        {.table = "material",
         .name = "offset",
         .low = 0,
         .high = 1,
         .text = "slack of the softest link, as a fraction of its length; 0: rigid"}),
    setting<&S::factor>({.table = "material",
                         .name = "factor",
                         .low = 0,
                         .high = 100,
                         .text = "factor of all limits; one number, or three for i, j, k"}),
    setting<&S::bone_threshold_hu>({.table = "material",
                                    .name = "bone_threshold_hu",
                                    .unit = "HU",
                                    .text = "elements with a larger value don't move"}),
    setting<&S::max_movement_mm>(
        {.table = "material",
         .name = "max_movement_mm",
         .unit = "mm",
         .low = 0,
         .high = kMaxMovementMm,
         .text = "largest distance from the rest position, for the softest element"}),
    setting<&S::yield>({.table = "material",
                        .name = "yield",
                        .low = 0,
                        .high = 1,
                        .text = "strain beyond this fraction of the limits stays; 0: none stays"}),
    elastic_row<S>("material"),
    setting<&S::limits>({.table = "material",
                         .name = "limits",
                         .choices = "box|rounded",
                         .text = "how the limits of the links around an element combine; rounded: "
                                 "round contours"}),
    setting<&S::scale>({.table = "push",
                        .name = "scale",
                        .low = 0,
                        .high = 1000,
                        .above_low = true,
                        .text = "factor of each push"}),
    setting<&S::brick_size>({.table = "lattice",
                             .name = "brick_size",
                             .unit = "elements",
                             .low = 2,
                             .high = kMaxBrickSize,
                             .text = "edge of a brick"}),
    setting<&S::bounded>({.table = "lattice",
                          .name = "bounded",
                          .text = "the lattice ends at the scan's border; else it goes on in air"}),
    setting<&S::max_elements>({.table = "lattice",
                               .name = "max_elements",
                               .unit = "elements",
                               .low = 1,
                               .text = "a push that would need more (about 4 GB) is refused"}),
    setting<&S::history_max_steps>({.table = "history",
                                    .key = "max_steps",
                                    .name = "history_max_steps",
                                    .unit = "steps",
                                    .low = 0,
                                    .high = 100'000,
                                    .text = "number of steps that can be undone"}),
    setting<&S::history_max_mb>({.table = "history",
                                 .key = "max_mb",
                                 .name = "history_max_mb",
                                 .unit = "MB",
                                 .low = 0,
                                 .high = 1'000'000,
                                 .text = "memory for these steps; the oldest are forgotten first"}),
    setting<&S::air_enabled>({.table = "air",
                              .key = "enabled",
                              .name = "air_enabled",
                              .text = "air is a material of its own"}),
    setting<&S::air_threshold_hu>({.table = "air",
                                   .key = "threshold_hu",
                                   .name = "air_threshold_hu",
                                   .unit = "HU",
                                   .text = "values below it are air; a sphere does not grab them"}),
    setting<&S::air_compress>({.table = "air",
                               .key = "compress",
                               .name = "air_compress",
                               .low = 0,
                               .high = 1,
                               .text = "fraction of its length that a link in air can lose"}),
    setting<&S::air_stretch>({.table = "air",
                              .key = "stretch",
                              .name = "air_stretch",
                              .low = 0,
                              .high = 500,
                              .text = "fraction of its length that a link in air can gain"}),
    setting<&S::air_shear>(
        {.table = "air",
         .key = "shear",
         .name = "air_shear",
         .low = 0,
         .high = 500,
         .text = "sideways slack of a link in air, as a fraction of its length"}),
};

constexpr Setting<L> kLabel[] = {
    setting<&L::values>({.table = "label",
                         .name = "values",
                         .low = -32768,
                         .high = 65535,
                         .text = "labels that have this material; one or a list"}),
    setting<&L::law>({.table = "label",
                      .name = "law",
                      .choices = "draeger|constant|fixed",
                      .text = "by value, the limits given here, or immobile"}),
    setting<&L::offset>({.table = "label",
                         .name = "offset",
                         .low = 0,
                         .high = 1,
                         .text = "as in [material], for law \"draeger\""}),
    setting<&L::bone_threshold_hu>({.table = "label",
                                    .name = "bone_threshold_hu",
                                    .unit = "HU",
                                    .text = "as in [material], for law \"draeger\""}),
    setting<&L::max_movement_mm>({.table = "label",
                                  .name = "max_movement_mm",
                                  .unit = "mm",
                                  .low = 0,
                                  .high = kMaxMovementMm,
                                  .text = "as in [material]"}),
    setting<&L::yield>(
        {.table = "label", .name = "yield", .low = 0, .high = 1, .text = "as in [material]"}),
    elastic_row<L>("label"),
    setting<&L::factor>({.table = "label",
                         .name = "factor",
                         .low = 0,
                         .high = 100,
                         .text = "factor of all limits; one number, or three for i, j, k"}),
    setting<&L::compress>({.table = "label",
                           .name = "compress",
                           .low = 0,
                           .high = 1,
                           .text = "for law \"constant\": fraction of its length that a link can "
                                   "lose, also times factor; one number or three"}),
    setting<&L::stretch>({.table = "label",
                          .name = "stretch",
                          .low = 0,
                          .high = 100,
                          .text = "for law \"constant\": fraction that it can gain"}),
    setting<&L::shear>({.table = "label",
                        .name = "shear",
                        .low = 0,
                        .high = 100,
                        .text = "for law \"constant\": sideways slack"}),
    setting<&L::along_direction>({.table = "label",
                                  .key = "frame",
                                  .name = "along_direction",
                                  .choices = "lattice|direction",
                                  .text = "axes of the three numbers: i, j, k, or along and across "
                                          "the direction field"}),
};

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
