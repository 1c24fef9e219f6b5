// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pliant in a program of one's own: makes a phantom, pushes it, and prints how much moved.
//
//   consumer            prints
//   consumer --check    and exits with 1 if the numbers are not what they must be

#include <pliant/chainmail.h>
#include <pliant/phantom.h>

#include <cstdio>
#include <string_view>

int main(int argc, char** argv) {
    const pliant::TaskArena arena;
    const auto phantom = pliant::make_phantom({.name = "cube", .size = {48, 48, 48}}, arena);
    if (!phantom) {
        std::fprintf(stderr, "consumer: %s\n", phantom.error().message.c_str());
        return 1;
    }
    // The cube has 1000 HU, which would be bone at the default threshold.
    auto tissue = pliant::ChainMail::create(phantom->volume, {.bone_threshold_hu = 3000}, arena);
    if (!tissue) {
        std::fprintf(stderr, "consumer: %s\n", tissue.error().message.c_str());
        return 1;
    }
    const auto report = tissue->push({.point_mm = {0, 0, 0}, .push_mm = {0, 3, 0}});
    if (!report) {
        std::fprintf(stderr, "consumer: %s\n", report.error().message.c_str());
        return 1;
    }
    const auto state = tissue->state();
    std::printf("%lld elements moved, the farthest by %.3f mm\n",
                static_cast<long long>(state.moved_elements), state.max_movement_mm);
    const bool check = argc > 1 && std::string_view(argv[1]) == "--check";
    const bool as_expected = report->status == pliant::PushStatus::Applied &&
                             state.moved_elements > 8 && state.max_violation_mm <= 0 &&
                             state.max_movement_mm > 2.999 && state.max_movement_mm < 3.001;
    if (check && !as_expected) std::fprintf(stderr, "consumer: expected a push of 3 mm\n");
    return check && !as_expected ? 1 : 0;
}
