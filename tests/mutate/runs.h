// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One run: a damaged file, a command line, what came of it.

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mutate/child.h"
#include "mutate/input.h"

namespace pliant::mutate {

struct Options {
    Sources sources;
    std::uint64_t seed = 1;
    std::filesystem::path keep;  ///< folder for the inputs of faults; empty: none
    bool limit_memory = true;    ///< not with sanitizers, which need a large address space
};

struct Outcome {
    std::string command;
    Ended ended;
    std::vector<std::string> faults;
};

/// The undamaged files of a seed, with one of its command lines.
Outcome run_good(const Options& options, const Format& format, const Seed& seed,
                 const std::string& command);
/// Run n of a format: seed, command line and damage depend on the seed, the format and n alone.
Outcome run_damaged(const Options& options, const Format& format, int n);

}  // namespace pliant::mutate
