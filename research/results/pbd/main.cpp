// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes the page that compares position-based vessels with their paper:
//
//   results_pbd FOLDER SCENES [PART…]
//
// FOLDER gets README.md and its pictures, SCENES has the scene files of vessels; parts are
// catheters, models, volumes, pressure, push, vessels, cases and cantilever, by default all.
// Pictures and errors are reproducible; ratios of times are not.

#include <pliant/core/tasks.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "figures.h"

int main(int argc, char** argv) {
    using namespace pliant::results;
    if (argc < 3) {
        std::fprintf(stderr,
                     "results: expected a folder to write to, that of the scenes, and parts\n");
        return 2;
    }
    const pliant::TaskArena arena(1);
    Page page{argv[1]};
    page.heading(1, "Position-based vessels beside their paper");
    page.paragraph(
        "The vessel of [VesselPbd2016]: distance, bending and volume constraints, and boxes of "
        "which only those near the catheter move; and vessels of `pliant vessel`, whose walls are "
        "neo-Hookean tetrahedra unless it is said otherwise ([vessel.md](../../method/vessel.md)). "
        "What could be read of the paper "
        "has no figures of its results, so nothing is repeated here, and the set-ups are ours. The "
        "model is described in [pbd.md](../../method/pbd.md), which also says more about the "
        "published cases 1 to 15. Vessels are drawn cut open, in parallel projection: the cut and "
        "the inner "
        "surface behind it have the colours of the legend. Times were taken beside other work and "
        "vary; the other numbers are the same on each run.");
    page.origin("./dev results pbd");
    const std::string scenes = argv[2];
    const std::pair<std::string_view, std::function<void()>> parts[] = {
        {"catheters", [&] { add_catheters(page, scenes, arena); }},
        {"models", [&] { add_wall_models(page, scenes, arena); }},
        {"volumes", [&] { add_volumes(page, arena); }},
        {"pressure", [&] { add_pressure(page, arena); }},
        {"push", [&] { add_push(page, arena); }},
        {"vessels", [&] { add_walls(page, scenes, arena); }},
        {"cases", [&] { add_published(page); }},
        {"cantilever", [&] { add_cantilever(page, arena); }}};
    const std::vector<std::string_view> wanted(argv + 3, argv + argc);
    for (const auto& [name, add] : parts)
        if (wanted.empty() || std::count(wanted.begin(), wanted.end(), name) > 0) add();
    if (const pliant::Status status = page.finish(); !status.ok()) {
        std::fprintf(stderr, "results: %s\n", status.error().message.c_str());
        return 1;
    }
}
