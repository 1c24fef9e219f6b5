// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scene files of `pliant vessel`.

#include <pliant/models/catheter.h>

#include "fuzz/fuzz.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = fuzz::write_anew("s.toml", fuzz::text_of(data, size));
    const auto scene = read_vessel_file(file.string());
    if (!scene.ok()) {
        fuzz::expect_one_line(scene.error().message);
        return 0;
    }
    fuzz::expect(scene->max_steps >= 1, "a script with an end");
    fuzz::expect(scene->settings.time_step_s > 0 && scene->settings.sub_steps > 0,
                 "numbers within their bounds");
    return 0;
}
