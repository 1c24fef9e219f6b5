// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes the page of force feedback: results_haptics FOLDER. All of it is in simulated time and
// reproducible.

#include <pliant/core/tasks.h>

#include <cstdio>

#include "figures.h"

int main(int argc, char** argv) {
    using namespace pliant::results;
    if (argc != 2) {
        std::fprintf(stderr, "results: expected a folder to write to\n");
        return 2;
    }
    const pliant::TaskArena arena;
    Page page{argv[1]};
    page.heading(1, "Force feedback on a device that is simulated");
    page.paragraph(
        "A mass with friction and encoder steps, held by a simulated hand, in simulated time; "
        "[haptics.md](../../method/haptics.md) says what the servo does. Nothing here depends on "
        "how "
        "fast the machine is: for that there is `pliant haptics check`.");
    page.origin("./dev results haptics");
    add_stability(page);
    add_taps(page);
    add_energies(page, arena);
    add_depth(page, arena);
    if (const pliant::Status status = page.finish(); !status.ok()) {
        std::fprintf(stderr, "results: %s\n", status.error().message.c_str());
        return 1;
    }
}
