// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The log of a hand on a catheter (`pliant vessel --record`), for a replay.

#include "../../apps/pliant/vessel_outputs.h"
#include "fuzz/fuzz.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = fuzz::write_anew("h.log", fuzz::text_of(data, size));
    const auto log = app::read_log(file.string());
    if (!log.ok()) {
        fuzz::expect_one_line(log.error().message);
        return 0;
    }
    for (std::size_t n = 0; n < log->lines.size(); ++n) {
        const CatheterCommand& c = log->lines[n].command;
        fuzz::expect(n == 0 || log->lines[n - 1].step < log->lines[n].step, "rising steps");
        fuzz::expect(std::isfinite(c.insert_mm_s) && std::isfinite(c.rotate_deg_s) &&
                         std::isfinite(c.bend_first_deg) && std::isfinite(c.bend_second_deg),
                     "numbers");
    }
    const auto written = fuzz::folder() / "again.log";
    fuzz::expect(app::write_log(written.string(), *log).ok(), "a log that can be written");
    const auto again = app::read_log(written.string());
    fuzz::expect(again.ok(), "its own log can be read", again.ok() ? "" : again.error().message);
    fuzz::expect(again->lines.size() == log->lines.size() && again->steps == log->steps &&
                     again->hash == log->hash,
                 "the same log again");
    return 0;
}
