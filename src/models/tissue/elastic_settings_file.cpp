// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings of the elastic scan from a file that may have ChainMail's tables as well.

#include <pliant/core/files.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <string>

#include "base/errors.h"
#include "base/record_toml.h"

namespace pliant {
namespace {

bool is_of_chainmail(const TomlTable& table) {
    const auto has_table = [&](const SettingInfo& row) { return row.table == table.name; };
    return std::ranges::any_of(chainmail_rows(), has_table) ||
           std::ranges::any_of(label_rows(), has_table);
}

Status read_tables(const std::string& text, ElasticScanSettings& settings) {
    const auto tables = parse_toml(text);
    if (!tables) return tables.error();
    for (const TomlTable& table : *tables) {
        if (is_of_chainmail(table)) continue;
        if (table.name != "elastic" || table.number != 0)
            return expected_error(title_of(table), "[elastic], or a table of ChainMail",
                                  "another table");
        if (const Status s = read_table(table, elastic_scan_rows(), settings); !s) return s;
    }
    return Ok{};
}

}  // namespace

Result<ElasticScanSettings> read_elastic_settings(const std::filesystem::path& path,
                                                  const ValueDefaults& values) noexcept {
    return attempt([&]() -> Result<ElasticScanSettings> {
        const Result<std::string> text =
            read_small_file(path, kMaxSmallFileBytes, "a settings file");
        if (!text) return text.error();
        ElasticScanSettings settings;
        suit_elastic(values, settings);
        Status read = read_tables(*text, settings);
        if (read.ok()) read = check_elastic_scan(settings);
        if (!read) return in_one_line(within(path.string(), read.error()));
        return settings;
    });
}

}  // namespace pliant
