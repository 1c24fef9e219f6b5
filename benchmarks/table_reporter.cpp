// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "table_reporter.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <string_view>
#include <utility>

namespace pliant::bench {
namespace {

constexpr int kNameWidth = 46;
constexpr std::string_view kColumns[] = {"items", "ns/item", "reference_ns/item", "times_faster",
                                         "floor_ns/item"};

/// Four significant digits, or "-" for a missing number.
std::string counter_text(const benchmark::BenchmarkReporter::Run& run, const std::string& name) {
    const auto found = run.counters.find(name);
    if (found == run.counters.end()) return "-";
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", double(found->second));
    return text;
}

/// Median of the turns for cases with items; otherwise Google Benchmark's mean.
double median_ms(const benchmark::BenchmarkReporter::Run& run) {
    const auto items = run.counters.find("items"), ns = run.counters.find("ns/item");
    if (items != run.counters.end() && ns != run.counters.end())
        return double(items->second) * double(ns->second) * 1e-6;
    return run.GetAdjustedRealTime() * 1e3 / benchmark::GetTimeUnitMultiplier(run.time_unit);
}

/// "moving_contact/side:50/push:5" → family "moving_contact", case "side:50 push:5".
std::pair<std::string, std::string> split_name(const std::string& name) {
    const std::size_t slash = name.find('/');
    if (slash == std::string::npos) return {name, ""};
    std::string arguments = name.substr(slash + 1);
    for (const char* noise : {"/manual_time", "/real_time", "/min_time:", "/iterations:"})
        if (const auto at = arguments.find(noise); at != std::string::npos) {
            const auto end = arguments.find('/', at + 1);
            arguments.erase(at, end == std::string::npos ? end : end - at);
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
        "The floor is the bytes that must be moved over the bandwidth measured in this run; of "
        "rays, the vector instructions of the last cells alone.\n");
    std::printf(
        "cores: how many the threads had in truth, beside turns that last; a virtual "
        "machine's processors may share one.\n");
    return true;
}

void TableReporter::ReportRuns(const std::vector<Run>& runs) {
    for (const Run& run : runs) {
        const auto [family, arguments] = split_name(run.benchmark_name());
        if (family != m_family) {
            std::printf("\n%-*s %10s %10s %10s %10s %10s %10s\n", kNameWidth, family.c_str(), "ms",
                        "items", "ns/item", "reference", "ratio", "floor");
            if (!run.report_label.empty()) std::printf("  (%s)\n", run.report_label.c_str());
            m_family = family;
        }
        if (run.error_occurred) {
            std::printf("  %-*s %s\n", kNameWidth - 2, arguments.c_str(),
                        run.error_message.c_str());
            continue;
        }
        if (run.run_type == Run::RT_Aggregate) continue;
        std::printf("  %-*s %10.4g", kNameWidth - 2, arguments.c_str(), median_ms(run));
        for (const std::string_view column : kColumns)
            std::printf(" %10s", counter_text(run, std::string(column)).c_str());
        std::printf("\n");
        std::string others;
        for (const auto& [name, value] : run.counters)
            if (std::find(std::begin(kColumns), std::end(kColumns), name) == std::end(kColumns))
                others += (others.empty() ? "" : ", ") + name + " " + counter_text(run, name);
        if (!others.empty()) std::printf("      %s\n", others.c_str());
        std::fflush(stdout);
    }
}

}  // namespace pliant::bench
