// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate/runs.h"

#include <algorithm>
#include <fstream>

#include "base/hash.h"
#include "mutate/formats.h"
#include "mutate/judge.h"
#include "mutate/upload_server.h"
#include "support/temporary_folder.h"

namespace pliant::mutate {
namespace {

Random random_of(const Options& options, const Format& format, int n) {
    Hash64 hash;
    hash.add_word(options.seed);
    hash.add(std::span<const char>(format.name));
    hash.add_word(std::uint64_t(n));
    return Random(hash.value());
}

void keep(const std::filesystem::path& folder, const Files& files, const Outcome& outcome) {
    const auto write = [&](const std::string& name, const std::string& bytes) {
        std::filesystem::create_directories((folder / name).parent_path());
        std::ofstream(folder / name, std::ios::binary) << bytes;
    };
    for (const File& file : files) write(file.name, file.bytes);
    write("command.txt", "pliant " + outcome.command + "\n");
    write("standard_error.txt", outcome.ended.err);
}

/// A process for each damaged file.
class CommandLine : public Target {
  public:
    CommandLine(const Options& options, bool may_be_long)
        : m_options(options), m_may_be_long(may_be_long) {}
    Outcome take(const Files& files, const std::string& command) override;

  private:
    const Options& m_options;
    bool m_may_be_long;
};

Outcome CommandLine::take(const Files& files, const std::string& command) {
    const test::TemporaryFolder folder;
    std::filesystem::create_directory(folder / ".tmp");
    for (const File& file : files) folder.write(file.name, file.bytes);
    Limits limits;
    if (m_may_be_long) limits.cpu_s = 3;
    if (!m_options.limit_memory) limits.memory = 0, limits.cpu_s *= 10, limits.wall_s *= 4;
    const Contents before = contents_of(folder.path());
    Outcome outcome;
    outcome.command = command;
    const std::vector<std::string> words = words_of(command);
    outcome.ended = run_child(m_options.sources.program, words, folder.path(), limits);
    const Rules rules{
        .judge_memory = m_options.limit_memory,
        .may_be_long = m_may_be_long,
        .expects_json = std::find(words.begin(), words.end(), "--json") != words.end()};
    outcome.faults = faults_of(outcome.ended, before, contents_of(folder.path()), rules);
    return outcome;
}

}  // namespace

std::unique_ptr<Target> target_of(const Options& options, const Format& format) {
    if (format.is_uploaded)
        return std::make_unique<UploadServer>(options.sources, options.limit_memory);
    return std::make_unique<CommandLine>(options, format.may_be_long);
}

Outcome run_damaged(const Options& options, const Format& format, int n, Target& target) {
    Random random = random_of(options, format, n);
    const Seed& seed = any_of(format.seeds, random);
    const std::string& command = any_of(seed.commands, random);
    const Files files = damaged_files(seed, format.words, random);
    Outcome outcome = target.take(files, command);
    if (!outcome.faults.empty() && !options.keep.empty())
        keep(options.keep /
                 (format.name + "." + std::to_string(options.seed) + "." + std::to_string(n)),
             files, outcome);
    return outcome;
}

}  // namespace pliant::mutate
