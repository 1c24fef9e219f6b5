// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The command lines of the documents. A block that is fenced as `sh` runs as it stands; one that is
// fenced as `bash` doesn't, and the comment on the line before it gives the reason:
//
//   <!-- not run: needs a browser -->

#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace pliant::test {

struct CommandBlock {
    int line = 0;             ///< of its fence, from 1
    std::string text{};       ///< the lines between the fences
    std::string exemption{};  ///< reason not to run it; empty if it runs
};

struct CommandBlocks {
    std::vector<CommandBlock> blocks{};
    std::vector<std::string> faults{};  ///< "12: expected …, found …"
};

/// Blocks of command lines in a document. Faults are command lines outside of such blocks and
/// exemptions without a reason.
CommandBlocks command_blocks(std::string_view document);

/// Runs the blocks in their order by one shell in `folder`, where `scenes` are the repository's.
/// @returns faults: a command that failed, and a `pliant deform` whose volume or picture shows no
///          difference to the undeformed one, or to the volume of another command
std::vector<std::string> faults_of_run(const std::filesystem::path& folder,
                                       const std::vector<CommandBlock>& blocks);

}  // namespace pliant::test
