// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A way for the endoscope from 3D Slicer (.mrk.json), and the flight along it.

#include "../../apps/pliant/camera_path.h"
#include "fuzz/fuzz.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = fuzz::write_anew("p.mrk.json", fuzz::text_of(data, size));
    const auto points = app::read_camera_path(file.string());
    if (!points.ok()) {
        fuzz::expect_one_line(points.error().message);
        return 0;
    }
    for (const app::CameraPose& pose : app::fly(*points, 1.0)) {
        fuzz::expect(is_finite(pose.eye_mm) && is_finite(pose.look) && is_finite(pose.up),
                     "finite poses");
    }
    return 0;
}
