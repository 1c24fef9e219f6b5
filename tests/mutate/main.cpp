// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Runs the program on damaged files of every format that it reads, and judges each run.
//
//   mutate --program build/gcc/pliant --count 200 --seed 1 --keep found nrrd session
//
// Exit status 1 where a run had a fault, 2 where a seed is refused undamaged.

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "mutate/formats.h"
#include "mutate/judge.h"
#include "mutate/runs.h"

namespace pliant::mutate {
namespace {

const char* const kHelp =
    "mutate --program FILE [--count N] [--seed S] [--first N] [--jobs N] [--keep DIR]\n"
    "       [--no-limits] [--list] [FORMAT…]\n"
    "  --program FILE  the program pliant\n"
    "  --count N       runs of each format (default 200)\n"
    "  --seed S        of the random numbers (default 1)\n"
    "  --first N       number of the first run (default 1); with --count 1 a run is repeated\n"
    "  --jobs N        runs at once (default 1)\n"
    "  --keep DIR      keeps the input files of faults there\n"
    "  --no-limits     no limit of memory: for a program with sanitizers\n"
    "  --list          names the formats\n";

struct Settings {
    Options options;
    int first = 1, count = 200;
    int jobs = 1;  ///< runs at once
    std::vector<NamedFormat> formats;
    std::string only_says;  ///< --help or --list
};

struct Row {
    std::string format;
    int runs = 0, taken = 0, refused = 0, cut_off = 0, crashes = 0, faults = 0;
    double slowest_s = 0, peak_mb = 0;
};

/// Each command line of each seed; the first of a seed has to succeed.
void check_seeds(const Options& options, const Format& format) {
    const auto target = target_of(options, format);
    for (const Seed& seed : format.seeds)
        for (const std::string& command : seed.commands) {
            const Outcome outcome = target->take(good_files(seed), command);
            const bool refused = &command == &seed.commands.front() && outcome.ended.status != 0;
            if (!refused && outcome.faults.empty()) continue;
            give_up(format.name + ": seed " + seed.name + " is not taken: pliant " + command +
                    ": " + (outcome.faults.empty() ? "refused" : outcome.faults.front()) + ": " +
                    printable(outcome.ended.err, 400));
        }
}

void print_fault(const Options& options, const Format& format, int n, const Outcome& outcome) {
    std::string why;
    for (const std::string& fault : outcome.faults) why += (why.empty() ? "" : "; ") + fault;
    std::printf(
        "FAULT %s %d: %s | pliant %s | %s | ./dev mutate %s --seed %llu --first %d --count 1\n",
        format.name.c_str(), n, why.c_str(), outcome.command.c_str(),
        printable(outcome.ended.err).c_str(), format.name.c_str(),
        static_cast<unsigned long long>(options.seed), n);
    std::fflush(stdout);
}

void add(Row& row, const Ended& ended, bool has_faults) {
    ++row.runs;
    row.taken += ended.status == kTaken;
    row.refused += ended.status == kRefused;
    row.cut_off += ended.too_long;
    row.crashes += ended.signal != 0 && !ended.too_long;
    row.faults += has_faults;
    row.slowest_s = std::max(row.slowest_s, ended.seconds);
    row.peak_mb = std::max(row.peak_mb, ended.peak_mb);
}

/// Runs of one format, several at once.
Row run_format(const Settings& settings, const NamedFormat& named) {
    const Format format = named.make(settings.options.sources);
    check_seeds(settings.options, format);
    Row row{.format = format.name};
    std::mutex mutex;
    std::atomic<int> next = settings.first;
    const auto work = [&] {
        const auto target = target_of(settings.options, format);
        for (int n = next++; n < settings.first + settings.count; n = next++) {
            const Outcome outcome = run_damaged(settings.options, format, n, *target);
            const std::lock_guard lock(mutex);
            add(row, outcome.ended, !outcome.faults.empty());
            if (!outcome.faults.empty()) print_fault(settings.options, format, n, outcome);
        }
        const std::vector<std::string> faults = target->end();
        const std::lock_guard lock(mutex);
        for (const std::string& fault : faults) {
            ++row.faults;
            std::printf("FAULT %s, at the end: %s\n", format.name.c_str(), fault.c_str());
        }
    };
    std::vector<std::jthread> workers;
    for (int n = 0; n < settings.jobs; ++n) workers.emplace_back(work);
    workers.clear();
    return row;
}

void print_table(const std::vector<Row>& rows) {
    std::printf("%-14s %7s %7s %8s %8s %8s %7s %10s %8s\n", "format", "runs", "taken", "refused",
                "cut off", "crashes", "faults", "slowest s", "peak MB");
    for (const Row& row : rows)
        std::printf("%-14s %7d %7d %8d %8d %8d %7d %10.2f %8.0f\n", row.format.c_str(), row.runs,
                    row.taken, row.refused, row.cut_off, row.crashes, row.faults, row.slowest_s,
                    row.peak_mb);
}

Settings parsed(int argc, char** argv) {
    Settings s;
    s.options.sources = {
        .program = "", .fuzz_corpus = PLIANT_FUZZ_CORPUS, .corpus = PLIANT_MUTATE_CORPUS};
    for (int n = 1; n < argc; ++n) {
        const std::string word = argv[n];
        const auto value = [&]() -> std::string {
            if (n + 1 == argc) give_up(word + ": expected a value");
            return argv[++n];
        };
        const auto number = [&] {
            const std::string text = value();
            if (text.empty() || text.size() > 9 ||
                text.find_first_not_of("0123456789") != text.npos)
                give_up(word + ": expected a number, found '" + text + "'");
            return std::atoi(text.c_str());
        };
        const auto is_named = [&](const NamedFormat& format) { return word == format.name; };
        const auto found = std::find_if(all_formats().begin(), all_formats().end(), is_named);
        if (word == "--help" || word == "--list")
            s.only_says = word;
        else if (word == "--program")
            s.options.sources.program = std::filesystem::absolute(value());
        else if (word == "--count")
            s.count = number();
        else if (word == "--seed")
            s.options.seed = std::uint64_t(number());
        else if (word == "--first")
            s.first = number();
        else if (word == "--jobs")
            s.jobs = std::clamp(number(), 1, 256);
        else if (word == "--keep")
            s.options.keep = std::filesystem::absolute(value());
        else if (word == "--no-limits")
            s.options.limit_memory = false;
        else if (found != all_formats().end())
            s.formats.push_back(*found);
        else
            give_up("expected a format (see --list), found '" + word + "'");
    }
    if (s.formats.empty()) s.formats = all_formats();
    return s;
}

int run(const Settings& settings) {
    if (settings.only_says == "--help") return std::fputs(kHelp, stdout), 0;
    if (settings.only_says == "--list") {
        for (const NamedFormat& format : all_formats()) std::printf("%s\n", format.name);
        return 0;
    }
    if (!std::filesystem::is_regular_file(settings.options.sources.program))
        give_up("--program: expected the program pliant");
    std::printf("seed %llu\n", static_cast<unsigned long long>(settings.options.seed));
    std::vector<Row> rows;
    bool sound = true;
    for (const NamedFormat& format : settings.formats) {
        rows.push_back(run_format(settings, format));
        sound = sound && rows.back().faults == 0;
    }
    print_table(rows);
    return sound ? 0 : 1;
}

}  // namespace
}  // namespace pliant::mutate

int main(int argc, char** argv) {
    return pliant::mutate::run(pliant::mutate::parsed(argc, argv));
}
