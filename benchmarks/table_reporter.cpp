// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "table_reporter.h"

#include <cstdio>

namespace pliant::bench {
namespace {

constexpr int kNameWidth = 46;

/// Four significant digits, or "-" where the case has no such number.
std::string counter_text(const benchmark::BenchmarkReporter::Run& run, const char* name) {
    const auto found = run.counters.find(name);
    if (found == run.counters.end()) return "-";
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", double(found->second));
    return text;
}

/// "moving_contact/side:50/push:5" → family "moving_contact", case "side:50 push:5".
std::pair<std::string, std::string> split_name(const std::string& name) {
    const std::size_t slash = name.find('/');
    if (slash == std::string::npos) return {name, ""};
    std::string arguments = name.substr(slash + 1);
    for (const char* noise : {"/manual_time", "/real_time"})
        if (const auto at = arguments.find(noise); at != std::string::npos)
            arguments.erase(at, std::string(noise).size());
    if (const auto at = arguments.find("min_time"); at != std::string::npos) {
        const auto end = arguments.find('/', at);
        arguments.erase(at, end == std::string::npos ? end : end + 1 - at);
    }
    for (char& c : arguments)
        if (c == '/') c = ' ';
    return {name.substr(0, slash), arguments};
}

}  // namespace

bool TableReporter::ReportContext(const Context&) {
    const auto& cpu = benchmark::CPUInfo::Get();
    std::printf(
        "%d processors at %.0f MHz. Medians; the reference is timed turn by turn in the "
        "same run.\n",
        cpu.num_cpus, cpu.cycles_per_second / 1e6);
    std::printf(
        "The floor is the bytes that must be moved over the bandwidth measured in this "
        "run.\n");
    return true;
}

void TableReporter::ReportRuns(const std::vector<Run>& runs) {
    for (const Run& run : runs) {
        const auto [family, arguments] = split_name(run.benchmark_name());
        if (family != m_family) {
            std::printf("\n%-*s %10s %10s %10s %10s %10s %10s\n", kNameWidth, family.c_str(), "ms",
                        "items", "ns/item", "reference", "ratio", "floor");
            m_family = family;
        }
        if (run.error_occurred) {
            std::printf("  %-*s %s\n", kNameWidth - 2, arguments.c_str(),
                        run.error_message.c_str());
            continue;
        }
        if (run.run_type == Run::RT_Aggregate) continue;
        std::printf(
            "  %-*s %10.4g %10s %10s %10s %10s %10s\n", kNameWidth - 2, arguments.c_str(),
            run.GetAdjustedRealTime() * 1e3 / benchmark::GetTimeUnitMultiplier(run.time_unit),
            counter_text(run, "items").c_str(), counter_text(run, "ns/item").c_str(),
            counter_text(run, "reference_ns/item").c_str(),
            counter_text(run, "times_faster").c_str(), counter_text(run, "floor_ns/item").c_str());
        for (const auto& [name, value] : run.counters) {
            const bool in_columns = name == "items" || name == "ns/item" ||
                                    name == "reference_ns/item" || name == "times_faster" ||
                                    name == "floor_ns/item";
            if (!in_columns)
                std::printf("      %s: %s\n", name.c_str(),
                            counter_text(run, name.c_str()).c_str());
        }
        std::fflush(stdout);
    }
}

}  // namespace pliant::bench
