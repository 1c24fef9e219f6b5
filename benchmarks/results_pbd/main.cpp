// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes the page that sets position-based vessels beside their paper:
//
//   results_pbd FOLDER
//
// FOLDER gets README.md and its pictures. Pictures and errors are the same on each run; ratios of
// times are not.

#include <pliant/tasks.h>

#include <cstdio>
#include <cstdlib>

#include "figures.h"

int main(int argc, char** argv) {
    using namespace pliant::results;
    if (argc != 3) {
        std::fprintf(stderr, "results: expected a folder to write to and that of the scenes\n");
        return 2;
    }
    const pliant::TaskArena arena(1);
    Page page{argv[1]};
    page.heading(1, "Position-based vessels beside their paper");
    page.paragraph(
        "The vessel of [VesselPbd2016]: distance, bending and volume constraints, and boxes of "
        "which "
        "only those near the catheter move. What could be read of the paper has no figures of its "
        "results, so nothing is repeated here, and the set-ups are ours. The model is described in "
        "[pbd.md](../../pbd.md), which also says more about the published cases 1 to 15.");
    page.origin("./dev results pbd");
    const std::string only = std::getenv("ONLY") ? std::getenv("ONLY") : "cvwr";
    const auto is = [&](char c) { return only.find(c) != std::string::npos; };
    if (is('c')) add_catheters(page, argv[2], arena);
    if (is('v')) add_volumes(page, arena);
    if (is('w')) add_walls(page, argv[2], arena);
    if (is('p')) add_pressure(page, arena);
    if (is('u')) add_push(page, arena);
    if (is('r')) {
        add_pressure(page, arena);
        add_push(page, arena);
        add_published(page);
        add_cantilever(page, arena);
    }
    if (const pliant::Status status = page.finish(); !status.ok()) {
        std::fprintf(stderr, "results: %s\n", status.error().message.c_str());
        return 1;
    }
}
