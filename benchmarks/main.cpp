// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// pliant_bench [GROUP] [Google Benchmark's options]: with a group, runs only its cases, and prints
// a table and writes JSON to bench-GROUP.json in the working directory.

#include <benchmark/benchmark.h>

#include <cstring>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "table_reporter.h"

int main(int argc, char** argv) {
    static const std::map<std::string, std::string> kGroups = {
        {"chainmail",
         "--benchmark_filter=^(moving_contact|bounded_lattice|drag_|thesis_case|resample|"
         "whole_frame|chainmail_|large_scan/(open|push)/)"},
        {"fem", "--benchmark_filter=^fem_"},
        {"resample", "--benchmark_filter=^(resample|whole_frame)"},
        {"overlay", "--benchmark_filter=^overlay_frame"},
        {"pbd", "--benchmark_filter=^pbd_"},
        {"render", "--benchmark_filter=^(first_hits|endoscope_view|ray_caster_bricks)"},
        {"scan", "--benchmark_filter=^large_scan"},
        {"springs", "--benchmark_filter=^springs_"},
    };
    std::vector<std::string> arguments(argv, argv + argc);
    bool as_table = false;
    if (argc > 1 && argv[1][0] != '-') {
        const auto group = kGroups.find(argv[1]);
        if (group == kGroups.end()) {
            std::cerr << "pliant_bench: no group '" << argv[1] << "'; expected one of";
            for (const auto& [name, filter] : kGroups) std::cerr << ' ' << name;
            std::cerr << '\n';
            return 2;
        }
        as_table = true;
        arguments[1] = group->second;
        arguments.insert(arguments.begin() + 2, {"--benchmark_out=bench-" + group->first + ".json",
                                                 "--benchmark_out_format=json"});
    }
    for (const std::string& argument : arguments)
        if (argument == "--benchmark_format=csv" || argument == "--benchmark_out_format=csv") {
            std::cerr << "pliant_bench: " << argument
                      << ": expected console or json, since cases have different columns\n";
            return 2;
        }
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    int count = int(pointers.size());
    benchmark::Initialize(&count, pointers.data());
    if (benchmark::ReportUnrecognizedArguments(count, pointers.data())) return 2;
    pliant::bench::TableReporter table;
    if (as_table)
        benchmark::RunSpecifiedBenchmarks(&table);
    else
        benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
}
