// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes the page that compares ChainMail with its papers:
//
//   results_chainmail FOLDER SCANS [PART…]
//
// FOLDER gets README.md and its pictures; SCANS has the head of figure 5.9 (optional) and the real
// scans of the drag; parts are gibson, cubes, passages, timings and drags, by default all. Pictures
// and counts are reproducible; times are not.

#include <pliant/core/tasks.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "figures.h"

namespace {

void add_introduction(pliant::results::Page& page) {
    using namespace pliant::results;
    page.heading(1, "ChainMail beside its papers");
    page.paragraph(
        "Each figure and table of [Gibson1996] (1 to 3, 5 to 8) and of chapters 5 and 6 of "
        "[Draeger2005], "
        "and what Pliant does on the same set-up. The algorithm is described in "
        "[chainmail.md](../../method/chainmail.md). The papers' own pictures are not repeated "
        "here: "
        "the text says what they show.");
    page.origin("./dev results chainmail");
}

void add_differences(pliant::results::Page& page) {
    page.heading(2, "What differs from the papers, and why");
    page.paragraph(
        "* **Data.** The thesis's CT of a head and the papers' pictures are not at hand: the noses "
        "are those of another head and of a phantom, and the comparison is with the texts.\n"
        "* **Unnamed parameters.** Gibson's limits and motions, the thesis's angular vector (5.4), "
        "its movement limit (5.5), the sizes of its cubes and whether its tool pushes in or pulls "
        "out are not in the texts. Those chosen here are named with each figure.\n"
        "* **Relaxation.** Gibson's pictures are relaxed after each move; here that is shown for "
        "figure 5, and the other figures show the propagation alone.\n"
        "* **Two materials (5.7, 5.8).** The surface that is seen agrees with the thesis: the "
        "softer half has the deeper and wider dent, of larger volume at −100 HU only. Which half "
        "has the steeper flank depends on the threshold, which the thesis does not name. Without "
        "resampling the stiff half's dent is the wider one.\n"
        "* **The law.** The thesis's text divides values by 4096; Pliant by 4095, so that the "
        "hardest value has no play at all. The numbers of its table 6.2 fit links of the plain "
        "offset, without any factor for the value, and a z-scale of 2.22 to 2.25.\n"
        "* **The bump (5.12).** Air as a material of its own saves what hangs over a gap. A bump "
        "that only stands out of the wall goes down with it where the tool sticks, as the "
        "thesis's does; off a tool that it slides off it is bent to a side.\n"
        "* **The multi-move.** The thesis cuts its object along the grabbed cell, and says that "
        "links across the cuts may end up outside their limits (3.13). The exact solution has no "
        "such links.\n"
        "* **Cubicles (6.1).** A brick of Pliant is a few arrays, not a net of linked objects, "
        "so there is next to nothing to load; the two columns show what making it costs.");
}

}  // namespace

int main(int argc, char** argv) {
    using namespace pliant::results;
    if (argc < 3) {
        std::fprintf(
            stderr, "results: expected a folder to write to, the folder of the scans, and parts\n");
        return 2;
    }
    const pliant::TaskArena arena;
    const std::pair<std::string_view, std::function<void(Page&)>> parts[] = {
        {"gibson", [&](Page& page) { add_gibson(page, arena); }},
        {"cubes", [&](Page& page) { add_cubes(page, arena); }},
        {"passages", [&](Page& page) { add_passages(page, argv[2], arena); }},
        {"timings", [&](Page& page) { add_timings(page, arena); }},
        {"drags", [&](Page& page) { add_drags(page, argv[2], arena); }}};
    const std::vector<std::string_view> wanted(argv + 3, argv + argc);
    Page page{argv[1]};
    add_introduction(page);
    for (const auto& [name, add] : parts)
        if (wanted.empty() || std::count(wanted.begin(), wanted.end(), name) > 0) add(page);
    add_differences(page);
    if (const pliant::Status status = page.finish(); !status.ok()) {
        std::fprintf(stderr, "results: %s\n", status.error().message.c_str());
        return 1;
    }
}
