// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rules between settings; their ranges are in settings_rows.cpp.

#include "material/settings.h"

#include <set>
#include <utility>

#include "base/errors.h"
#include "base/text.h"

namespace pliant {
namespace {

/// The lattice continues beyond the scan as air. If that yields by almost nothing, a push reaches
/// as far as memory lasts.
Status check_air(const ChainMailSettings& s) {
    constexpr double kMin = 0.01;
    if (!s.air_enabled || s.bounded) return Ok{};
    for (const auto& [name, found] : {std::pair("air_compress", s.air_compress),
                                      {"air_stretch", s.air_stretch},
                                      {"air_shear", s.air_shear}})
        if (found < kMin)
            return expected_error(title_of(*find_setting(name, chainmail_rows())),
                                  "0.01 or more, or [lattice] bounded = true", text_of(found));
    return Ok{};
}

Status check_range_of_values(const ChainMailSettings& s) {
    const auto check = [](std::string_view name, ValueSpan span) -> Status {
        if (span.low < span.high) return Ok{};
        return expected_error(title_of(*find_setting(name, chainmail_rows())),
                              "a lower and a higher value",
                              text_of(span.low) + ", " + text_of(span.high));
    };
    if (const Status range = check("range", s.range); !range) return range;
    return s.range_percent ? check("range_percent", *s.range_percent) : Ok{};
}

Status check_elastic(const std::string& title, const std::optional<ElasticPair>& elastic) {
    if (!elastic || (elastic->young_modulus_kpa > 0 && elastic->poisson_ratio >= 0 &&
                     elastic->poisson_ratio < 0.5))
        return Ok{};
    return expected_error(
        title, "a modulus above 0 kPa, and a Poisson's ratio from 0, below 0.5",
        text_of(elastic->young_modulus_kpa) + ", " + text_of(elastic->poisson_ratio));
}

Status check_label_materials(const ChainMailSettings& s) {
    std::set<int> taken;
    for (std::size_t n = 0; n < s.label_materials.size(); ++n) {
        const LabelMaterial& material = s.label_materials[n];
        const auto title = [&](std::string_view key) {
            return "[[label]] " + std::to_string(n + 1) + " " + std::string(key);
        };
        if (material.values.empty())
            return expected_error(title("values"), "one label or more", "none");
        for (const auto& field : label_rows())
            if (const Status status = check_range(field, field.get(material)); !status)
                return expected_error(title(field.key_in_file()), status.error().expected,
                                      status.error().found);
        if (const Status status = check_elastic(title("elastic"), material.elastic); !status)
            return status;
        for (const int value : material.values)
            if (!taken.insert(value).second)
                return expected_error(title("values"), "each label once", std::to_string(value));
    }
    return Ok{};
}

}  // namespace

Status check_settings(const ChainMailSettings& s) {
    if (const Status table = check(s, chainmail_rows()); !table) return table;
    if (const Status range = check_range_of_values(s); !range) return range;
    if (const Status air = check_air(s); !air) return air;
    if (const Status elastic = check_elastic("[material] elastic", s.elastic); !elastic)
        return elastic;
    return check_label_materials(s);
}

}  // namespace pliant
