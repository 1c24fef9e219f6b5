// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// pliant replay: replays a recorded session; a different result is an error.

#include <pliant/serve.h>
#include <pliant/session.h>

#include <cinttypes>
#include <cstdio>
#include <optional>

#include "options.h"
#include "progress.h"

namespace pliant::app {

int run_replay(const ReplayOptions& options) {
    const TaskArena arena(options.threads);
    std::optional<ProgressBar> bar(std::in_place, "replay");
    const auto report = replay_session(
        options.session, arena, [&](double fraction) { bar->show(fraction); },
        options.from_checkpoint);
    bar.reset();
    if (!report.ok()) return bad_input(report.error().message);
    const char* format =
        options.json ? "{\"from_checkpoint\": %d, \"commands\": %" PRId64 ", \"marks\": %" PRId64
                       ", \"cut_off_bytes\": %" PRIu64 ", \"volume_hash\": \"%016" PRIx64
                       "\", \"tissue_hash\": \"%016" PRIx64 "\"}\n"
                     : "from checkpoint %d (0: the start)\n%" PRId64 " commands, %" PRId64
                       " marks met, %" PRIu64 " bytes cut off\nvolume %016" PRIx64
                       "\ntissue %016" PRIx64 "\n";
    std::printf(format, report->from_checkpoint, report->commands, report->marks,
                report->cut_off_bytes, report->volume_hash, report->tissue_hash);
    return kExitOk;
}

}  // namespace pliant::app
