// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Published and closed-form results beside those of Pliant's models: a table, JSON, a page.

#include <pliant/core/files.h>
#include <pliant/core/tasks.h>
#include <pliant/core/text.h>
#include <pliant/core/version.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "commands.h"
#include "conformance.h"
#include "conformance_value.h"
#include "json.h"
#include "output_text.h"

namespace pliant::app {
namespace {

struct Part {
    const char* name;
    const char* title;
    ConformanceCases (*make)(const TaskArena&);
};
constexpr Part kParts[] = {{"patch", "Patch tests", patch_cases},
                           {"beams", "Beams", beam_cases},
                           {"membranes", "Membranes and plates", membrane_cases},
                           {"solids", "Solids", solid_cases},
                           {"scan", "Elastic scan", scan_cases},
                           {"chainmail", "ChainMail", chainmail_cases},
                           {"springs", "Springs", spring_cases},
                           {"bodies", "Bodies", body_cases},
                           {"rods", "Rods", rod_cases},
                           {"rigs", "Rods whose tips are loaded or held", rig_cases}};

std::vector<std::string> part_names() {
    std::vector<std::string> names;
    for (const Part& part : kParts) names.emplace_back(part.name);
    return names;
}

/// Relative to the expected value; absolute if that is 0.
double deviation(const ConformanceCase& one, const ConformanceResult& result) {
    const double difference = result.value - one.expected;
    return one.expected == 0 ? difference : difference / std::abs(one.expected);
}

std::string value_text(double value) {
    return short_text(value, 4);
}

std::string deviation_text(const ConformanceCase& one, const ConformanceResult& result) {
    if (one.expected == 0) return value_text(result.value);
    const double percent = 100 * deviation(one, result);
    return (percent < 0 ? "−" : "+") + fixed_text(std::abs(percent), 1) + " %";
}

std::string tolerance_text(const ConformanceCase& one) {
    return one.expected == 0 ? value_text(one.tolerance) : value_text(100 * one.tolerance) + " %";
}

void print(const ConformanceCases& cases) {
    for (const ConformanceCase& one : cases) {
        std::printf("%s: %s, expected %s within %s [%s]\n", one.name.c_str(), one.quantity.c_str(),
                    value_text(one.expected).c_str(), tolerance_text(one).c_str(),
                    one.source.c_str());
        for (const ConformanceResult& result : one.results)
            std::printf("  %-4s %-30s %-22s %-12s %s\n", conforms(one, result) ? "ok" : "FAIL",
                        result.model.c_str(), result.mesh.c_str(), value_text(result.value).c_str(),
                        deviation_text(one, result).c_str());
    }
}

Json json_of(const ConformanceCases& cases) {
    Json list = Json::array();
    for (const ConformanceCase& one : cases) {
        Json results = Json::array();
        for (const ConformanceResult& result : one.results)
            results.push_back({{"model", result.model},
                               {"mesh", result.mesh},
                               {"value", result.value},
                               {"conforms", conforms(one, result)}});
        list.push_back({{"name", one.name},
                        {"quantity", one.quantity},
                        {"source", one.source},
                        {"expected", one.expected},
                        {"tolerance", one.tolerance},
                        {"results", std::move(results)}});
    }
    return list;
}

void add_rows(std::string& page, const ConformanceCases& cases) {
    page +=
        "<table><tr><th>case<th>quantity<th>source<th>expected<th>tolerance<th>model<th>mesh"
        "<th>value<th>deviation<th></tr>\n";
    for (const ConformanceCase& one : cases) {
        const std::string span = " rowspan=" + std::to_string(one.results.size()) + ">";
        page += "<tr><td" + span + one.name + "<td" + span + one.quantity + "<td" + span +
                one.source + "<td" + span + value_text(one.expected) + "<td" + span +
                tolerance_text(one);
        bool is_first = true;
        for (const ConformanceResult& result : one.results) {
            if (!is_first) page += "<tr>";
            is_first = false;
            const bool ok = conforms(one, result);
            page += "<td>" + result.model + "<td>" + result.mesh + "<td>" +
                    value_text(result.value) + "<td>" + deviation_text(one, result) +
                    (ok ? "<td class=ok>within" : "<td class=no>outside") + "</tr>\n";
        }
    }
    page += "</table>\n";
}

/// The beginning of the page. @param within, all  results
std::string head_of(int cases, int within, int all) {
    return "<!doctype html><html lang=en><meta charset=utf-8><title>Pliant: conformance</title>\n"
           "<style>body{font:15px/1.4 sans-serif;margin:2em;max-width:75em}table{border-collapse:"
           "collapse}td,th{border:1px solid #ccc;padding:2px 8px;text-align:left;vertical-align:"
           "top}.ok{background:#d7f0d7}.no{background:#f6d5d5}</style>\n"
           "<h1>Conformance</h1>\n<p>pliant " PLIANT_VERSION ": " +
           std::to_string(cases) + " cases with published or closed-form results. " +
           std::to_string(within) + " of " + std::to_string(all) +
           " results are within the tolerance of their case; the others are listed as outside. "
           "Coarse meshes are part of the list: they show what a model needs.</p>\n";
}

}  // namespace

bool conforms(const ConformanceCase& one, const ConformanceResult& result) {
    return std::abs(deviation(one, result)) <= one.tolerance;
}

void add_conformance(CLI::App& app, ConformanceOptions& o) {
    auto* c = app.add_subcommand("conformance",
                                 "Compare the models with published and closed-form results");
    std::string list;
    for (const std::string& name : part_names()) list += name + ", ";
    c->add_option("PART", o.parts, list + "all by default")->check(CLI::IsMember(part_names()));
    c->add_option("--html", o.html, "write a page with all of them");
    c->add_flag("--json", o.json, "print JSON");
    c->footer(
        "Examples:\n  pliant conformance --html conformance.html\n  pliant conformance beams "
        "--json");
}

int run_conformance(const ConformanceOptions& o) {
    const TaskArena arena;
    StagedFiles files;
    std::filesystem::path page;
    if (!o.html.empty()) {
        const auto staged = files.stage(o.html);
        if (!staged.ok()) return bad_input(staged.error());
        page = *staged;
    }
    int case_count = 0, within = 0, all = 0;
    std::string body;
    Json json = Json::array();
    try {
        for (const Part& part : kParts) {
            const auto is_named = [&](const std::string& name) { return name == part.name; };
            if (!o.parts.empty() && std::ranges::none_of(o.parts, is_named)) continue;
            const ConformanceCases cases = part.make(arena);
            for (const ConformanceCase& one : cases) {
                ++case_count;
                for (const ConformanceResult& result : one.results) {
                    ++all;
                    within += conforms(one, result);
                }
            }
            if (o.json)
                for (Json& one : json_of(cases)) json.push_back(std::move(one));
            else
                print(cases);
            body += "<h2>" + std::string(part.title) + "</h2>\n";
            add_rows(body, cases);
        }
    } catch (const ConformanceFailure& failure) {
        return bad_input(failure.message);
    }
    if (o.json)
        std::printf("%s\n", json.dump(2).c_str());
    else
        std::printf("%d cases; %d of %d results are within the tolerance\n", case_count, within,
                    all);
    if (o.html.empty()) return kExitOk;
    const Status written = write_text(page, head_of(case_count, within, all) + body + "</html>\n");
    if (!written.ok()) return bad_input(written.error());
    const Status committed = files.commit();
    return committed.ok() ? kExitOk : bad_input(committed.error());
}

}  // namespace pliant::app
