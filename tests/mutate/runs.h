// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One run: a damaged file, a command line, and the result.

#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
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

/// Takes files: a command line's process, or a server.
class Target {
  public:
    virtual ~Target() = default;
    virtual Outcome take(const Files& files, const std::string& command) = 0;
    /// After the last files. @returns faults
    virtual std::vector<std::string> end() { return {}; }
};

/// A server is started.
std::unique_ptr<Target> target_of(const Options& options, const Format& format);

/// Run n of a format: seed, command line and damage depend on the seed, the format and n alone.
Outcome run_damaged(const Options& options, const Format& format, int n, Target& target);

}  // namespace pliant::mutate
