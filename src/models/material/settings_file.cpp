// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings from a file, and their text in a saved state.

#include <algorithm>
#include <set>
#include <sstream>

#include "base/errors.h"
#include "base/record_toml.h"
#include "base/text.h"
#include "material/settings.h"

namespace pliant {
namespace {

Status read_label(const TomlTable& table, ChainMailSettings& settings) {
    if (table.number == 0)
        return expected_error("[label]", "[[label]], one for each material", "[label]");
    return read_table(table, label_rows(), settings.label_materials.emplace_back());
}

/// Names the successor of a key of older files.
Status refuse_elastic(const TomlTable& table) {
    const auto is_elastic = [](const NamedValue& value) { return value.name == "elastic"; };
    if (table.name != "material" || std::ranges::none_of(table.values, is_elastic)) return Ok{};
    return expected_error("[material] elastic",
                          "[elastic] moduli_kpa and --model elastic, which replace it",
                          "a setting that ChainMail no longer has");
}

Status read_tables(const std::vector<TomlTable>& tables, ChainMailSettings& settings) {
    for (const TomlTable& table : tables) {
        if (table.name == "elastic") continue;  // of read_elastic_settings()
        if (table.name == "label") {
            if (const Status s = read_label(table, settings); !s) return s;
            continue;
        }
        if (const Status s = refuse_elastic(table); !s) return s;
        if (const Status s = read_table(table, chainmail_rows(), settings); !s) return s;
    }
    return Ok{};
}

/// TOML has tables, or keys with a dot before the '='; Divod's lines have neither.
bool looks_like_toml(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const std::string_view content = trimmed(line);
        if (content.empty() || content.front() == '#') continue;
        if (content.front() == '[') return true;
        const auto equals = content.find('=');
        return equals != std::string_view::npos &&
               content.substr(0, equals).find('.') != std::string_view::npos;
    }
    return true;
}

Result<ChainMailSettings> read_toml(const std::string& text, ChainMailSettings settings = {}) {
    const auto tables = parse_toml(text);
    if (!tables) return tables.error();
    if (const Status s = read_tables(*tables, settings); !s) return s.error();
    return settings;
}

/// Same as read_toml, for a text of settings_text.
Result<ChainMailSettings> read_own_toml(const std::string& text) {
    ChainMailSettings settings;
    settings.smallest_bone_mm3 = 0;  // the value of older states, without this key
    const ChainMailSettings older = settings;
    const auto tables = parse_plain_toml(text);
    if (!tables.empty() && read_tables(tables, settings).ok()) return settings;
    return read_toml(text, older);
}

/// Consistent settings, or an error that names the file.
Result<ChainMailSettings> checked(const std::string& file, Result<ChainMailSettings> read) {
    const Status valid = read ? check_settings(*read) : Status(read.error());
    if (!valid) return in_one_line(within(file, valid.error()));
    return read;
}

/// TOML over settings that suit the scan's values, in the range that the file gives.
Result<ChainMailSettings> read_toml_for(const std::string& text, const ValueDefaults& values,
                                        LinkLimits limits) {
    ChainMailSettings settings;
    settings.limits = limits;
    suit_materials(values, settings);
    const ValueSpan range = settings.range;
    auto read = read_toml(text, settings);
    if (!read || read->range == range) return read;
    settings.range = read->range;
    suit_thresholds(values, settings);
    return read_toml(text, settings);
}

Result<ChainMailSettings> read_settings(const std::filesystem::path& path,
                                        const ValueDefaults& values,
                                        std::vector<std::string>* notes, LinkLimits limits) {
    const Result<std::string> text = read_small_file(path, kMaxSmallFileBytes, "a settings file");
    if (!text) return text.error();
    if (looks_like_toml(*text)) return checked(path.string(), read_toml_for(*text, values, limits));
    std::vector<std::string> own_notes;
    ChainMailSettings settings;
    settings.smallest_bone_mm3 = 0;  // each voxel, as in the thesis
    suit_materials(values, settings);
    const Status read = read_divod(*text, settings, own_notes);
    auto result = checked(path.string(), read ? Result(settings) : read.error());
    if (result && notes) notes->insert(notes->end(), own_notes.begin(), own_notes.end());
    return result;
}

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

std::string settings_text(const ChainMailSettings& settings) {
    return toml_text(settings, chainmail_rows());
}

Result<ChainMailSettings> parse_settings(const std::string& name, const std::string& toml) {
    return checked(name, read_own_toml(toml));
}

Result<ChainMailSettings> read_chainmail_settings(const std::filesystem::path& path,
                                                  std::vector<std::string>* notes) {
    return attempt([&] { return read_settings(path, {}, notes, LinkLimits::Box); });
}

Result<ChainMailSettings> read_chainmail_settings(const std::filesystem::path& path,
                                                  const ValueDefaults& values,
                                                  std::vector<std::string>* notes,
                                                  LinkLimits limits) {
    return attempt([&] { return read_settings(path, values, notes, limits); });
}

void suit_thresholds(const ValueDefaults& values, ChainMailSettings& settings) {
    if (values.kind == ValueKind::Hounsfield) return;
    // Thresholds keep their relative positions in the range; none becomes bone where nothing is.
    const double scale =
        (settings.range.high - settings.range.low) / (values.range.high - values.range.low);
    const auto place = [&](double value) {
        return settings.range.low + scale * (value - values.range.low);
    };
    settings.air_enabled = values.has_air;
    settings.air_threshold_hu = place(values.air_threshold);
    settings.bone_threshold_hu = values.has_bone
                                     ? place(values.bone_threshold)
                                     : std::max(values.bone_threshold, settings.range.high);
}

void suit_materials(const ValueDefaults& values, ChainMailSettings& settings) {
    if (values.kind == ValueKind::Hounsfield) return;
    settings.range = values.range;
    suit_thresholds(values, settings);
}

// Rules between settings; their ranges are in settings_rows.cpp.

Status check_settings(const ChainMailSettings& s) {
    if (const Status table = check(s, chainmail_rows()); !table) return table;
    if (const Status range = check_range_of_values(s); !range) return range;
    if (const Status air = check_air(s); !air) return air;
    return check_label_materials(s);
}

}  // namespace pliant
