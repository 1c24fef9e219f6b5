// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Positions of a haptic device, recorded, to be played back as a device.

#include <pliant/view/haptics.h>

#include "fuzz/fuzz.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = fuzz::write_anew("r.txt", fuzz::text_of(data, size));
    const auto device = open_haptic_device("replay:" + file.string());
    if (!device.ok()) {
        fuzz::expect_one_line(device.error().message);
        return 0;
    }
    const Vec3d room = (*device)->limits().workspace_mm;
    for (int n = 0; n < 20; ++n) {
        HapticReading reading;
        fuzz::expect((*device)->read(reading), "a position");
        for (int a = 0; a < 3; ++a)
            fuzz::expect(2 * std::abs(reading.position_mm[a]) <= room[a],
                         "a position in its workspace");
        fuzz::expect(std::abs(reading.roll_rad) <= 4, "a roll");
    }
    return 0;
}
