// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "scan_defaults.h"

#include <utility>

#include "setting_options.h"

namespace pliant::app {

ValueDefaults take_values(Volume& volume, const ReadNotes& notes) {
    const ValueDefaults values = value_defaults(volume, notes);
    volume.background = float(values.background);
    return values;
}

Result<ElasticScanSettings> elastic_settings(const std::string& config, const Record& options,
                                             const ValueDefaults& values) {
    ElasticScanSettings settings;
    suit_elastic(values, settings);
    if (!config.empty()) {
        auto read = read_elastic_settings(config, values);
        if (!read.ok()) return read.error();
        settings = std::move(*read);
    }
    for (const NamedValue& given : options)
        if (const Status s = apply({given}, elastic_scan_rows(), settings); !s.ok())
            return renamed(s.error(), option_of(given.name));
    return settings;
}

}  // namespace pliant::app
