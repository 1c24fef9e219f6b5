// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Materials by label: a settings file with [[label]] tables for the values of a label volume, plus
// directions; then the tissue is pushed.

#include <pliant/chainmail.h>

#include <cmath>

#include "fuzz/fuzz.h"

using namespace pliant;

namespace {

Volume make_volume(int kind) {
    Volume volume;
    volume.grid.size = {8, 8, 8};
    std::vector<std::int16_t> values;
    for (int n = 0; n < 512; ++n)
        values.push_back(std::int16_t(kind == 0 ? 10 + n % 7 : (n / 64) * 3 - 2));
    volume.voxels = std::move(values);
    return volume;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const TaskArena arena(1);
    static const Volume scan = make_volume(0);
    static const auto labels = std::make_shared<const Volume>(make_volume(1));
    auto settings =
        read_chainmail_settings(fuzz::write_anew("l.toml", fuzz::text_of(data, size)), nullptr);
    if (!settings.ok()) {
        fuzz::expect_one_line(settings.error().message);
        return 0;
    }
    settings->labels = labels;
    auto field = std::make_shared<VectorField>();
    field->grid = scan.grid;
    for (int n = 0; n < 512; ++n)
        field->vectors_mm.push_back({float(n % 3), float(n % 5) - 2, n % 11 == 0 ? NAN : 1.F});
    settings->directions = field;
    settings->max_elements = 1 << 16;
    auto tissue = ChainMail::create(scan, *settings, arena);
    if (!tissue.ok()) {
        fuzz::expect_one_line(tissue.error().message);
        return 0;
    }
    const auto report =
        tissue->push({.point_mm = {3, 3, 3}, .push_mm = {0.7, 2, -1}, .sphere_radius_mm = 1.5});
    if (!report.ok()) fuzz::expect_one_line(report.error().message);
    return 0;
}
