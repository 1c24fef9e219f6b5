// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The example of README.md, as it stands there.

#include "push.h"

#include <pliant/chainmail.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>

#include <cstdio>

/// Pushes a wall of a scan and writes the deformed scan.
pliant::Status push_wall(const char* scan_file, const char* deformed_file, pliant::Push push) {
    const auto scan = pliant::read_volume(scan_file);
    if (!scan) return scan.error();

    const pliant::TaskArena arena;  // all of the machine's threads
    auto tissue = pliant::ChainMail::create(*scan, {.bone_threshold_hu = 300}, arena);
    if (!tissue) return tissue.error();

    const auto report = tissue->push(push);  // may be called again and again
    if (!report) return report.error();
    std::printf("%.0f %% of the push was possible; %lld voxels moved\n",
                100 * report->step_fraction, static_cast<long long>(report->moved_elements));

    const auto deformed = pliant::deform_volume(*tissue);
    if (!deformed) return deformed.error();
    return pliant::write_volume(deformed_file, deformed->volume);
}
