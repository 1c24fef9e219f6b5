// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Writes the page that sets ChainMail beside its papers:
//
//   results_chainmail FOLDER [SCANS]
//
// FOLDER gets README.md and its pictures; SCANS has the real scans of the drag. Pictures and counts
// are the same on each run and each machine; times are not.

#include <pliant/tasks.h>

#include <cstdio>
#include <string>

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
    if (argc < 2 || argc > 3) {
        std::fprintf(stderr,
                     "results: expected a folder to write to, and the folder of the scans\n");
        return 2;
    }
    const pliant::TaskArena arena;
    pliant::results::Page page{argv[1]};
    add_introduction(page);
    add_gibson(page, arena);
    add_cubes(page, arena);
    add_timings(page, arena);
    if (argc == 3) add_drags(page, argv[2], arena);
    if (const pliant::Status status = page.finish(); !status.ok()) {
        std::fprintf(stderr, "results: %s\n", status.error().message.c_str());
        return 1;
    }
}
