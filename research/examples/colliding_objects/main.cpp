// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Objects that collide: pushes them into each other, prints the obstacle of each push and writes a
// picture.
//
//   colliding_objects PICTURE.png            writes the picture
//   colliding_objects PICTURE.png --check    and exits with 1 if something passes through something

#include <pliant/render.h>
#include <pliant/view/png.h>

#include <cstdio>
#include <string>
#include <string_view>

#include "collision.h"

namespace {

int fail(const std::string& message) {
    std::fprintf(stderr, "colliding_objects: %s\n", message.c_str());
    return 1;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return fail("expected a name for the picture");
    const pliant::TaskArena arena;
    const auto frames = collision::play(arena);
    if (!frames) return fail(frames.error().message);
    for (const collision::Frame& frame : *frames) {
        if (frame.pushed < 0) continue;
        const pliant::PushReport& push = frame.report.push;
        std::printf("%-33s %5.1f %% of %4.1f mm, limited by %s\n", frame.title.c_str(),
                    100 * push.step_fraction, norm(frame.push_mm),
                    std::string(name_of(push.limited_by)).c_str());
    }
    const auto written = pliant::write_png(argv[1], collision::picture_of(*frames));
    if (!written) return fail(written.error().message);
    if (argc < 3 || std::string_view(argv[2]) != "--check") return 0;
    const std::string fault = collision::find_fault(*frames);
    return fault.empty() ? 0 : fail(fault);
}
