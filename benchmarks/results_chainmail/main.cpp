// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes the page that sets ChainMail beside its papers:
//
//   results_chainmail FOLDER SCANS [PART…]
//
// FOLDER gets README.md and its pictures; SCANS has the real scans of the drag; parts are gibson,
// cubes, passages, timings and drags, by default all. Pictures and counts are the same on each run
// and each machine; times are not.

#include <pliant/tasks.h>

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
        "Each figure and table of [Gibson1996] (5 to 8) and of chapters 5 and 6 of [Draeger2005], "
        "and what Pliant does on the same set-up. The algorithm is described in "
        "[chainmail.md](../../chainmail.md). The papers' own pictures are not repeated here: the "
        "text says what they show.");
    page.table({"what", "this run"}, {{"command", "`./dev results chainmail`"},
                                      {"date", date_text()},
                                      {"machine", machine_text()},
                                      {"compiler", "`" __VERSION__ "`, release build"}});
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
        {"passages", [&](Page& page) { add_passages(page, arena); }},
        {"timings", [&](Page& page) { add_timings(page, arena); }},
        {"drags", [&](Page& page) { add_drags(page, argv[2], arena); }}};
    const std::vector<std::string_view> wanted(argv + 3, argv + argc);
    Page page{argv[1]};
    add_introduction(page);
    for (const auto& [name, add] : parts)
        if (wanted.empty() || std::count(wanted.begin(), wanted.end(), name) > 0) add(page);
    if (const pliant::Status status = page.finish(); !status.ok()) {
        std::fprintf(stderr, "results: %s\n", status.error().message.c_str());
        return 1;
    }
}
