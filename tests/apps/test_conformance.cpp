// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant conformance`: cases that must hold, results that must not, the page, and mistakes.
// Covers: pliant/run_conformance.cpp, pliant/conformance_beams.cpp, pliant/conformance_solids.cpp.
// Covers: pliant/conformance_membranes.cpp, pliant/conformance_thick_walls.cpp.
// Covers: pliant/conformance_scan.cpp.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

using ConformanceProgram = ProgramInFolder;

const Json& case_of(const Json& cases, const std::string& name) {
    for (const Json& one : cases)
        if (one["name"] == name) return one;
    throw std::runtime_error("no case is named " + name);
}

TEST_F(ConformanceProgram, ElementsHoldTheirCases) {
    ASSERT_EQ(run("conformance patch beams solids --json --html c.html"), 0) << said();
    const Json cases = Json::parse(out());
    EXPECT_EQ(cases.size(), 30);
    for (const Json& one : cases) {
        EXPECT_FALSE(one["results"].empty());
        if (!one["name"].get<std::string>().starts_with("patch")) continue;
        for (const Json& result : one["results"]) EXPECT_EQ(result["conforms"], true);
    }
    // The last result is that of incompatible modes on the finest mesh; trilinear elements lock.
    for (const char* name : {"slender beam", "twisted beam", "artery at 100 mmHg, plane strain",
                             "thick cylinder, Poisson's ratio 0.4999"}) {
        const Json& results = case_of(cases, name)["results"];
        EXPECT_EQ(results.back()["conforms"], true) << name;
    }
    const Json& twisted = case_of(cases, "twisted beam");
    EXPECT_EQ(twisted["expected"], 0.005424);
    EXPECT_EQ(twisted["results"][0]["conforms"], false);
    EXPECT_NEAR(twisted["results"][0]["value"], 0.00112, 1e-5);
    const std::string page = bytes_of(m_folder / "c.html");
    EXPECT_NE(page.find("30 cases"), page.npos);
    EXPECT_NE(page.find("<td class=no>outside"), page.npos);
    EXPECT_NE(page.find("twisted beam"), page.npos);
}

TEST_F(ConformanceProgram, TheElasticScanMovesARigidBall) {
    ASSERT_EQ(run("conformance scan --json"), 0) << said();
    const Json cases = Json::parse(out());
    ASSERT_EQ(cases.size(), 2);
    for (const Json& one : cases) EXPECT_EQ(one["results"][0]["conforms"], true) << one;
}

TEST_F(ConformanceProgram, AnUnknownPartOrFolderIsOneLine) {
    EXPECT_EQ(run("conformance bridges"), 2);
    EXPECT_NE(said().find("PART"), std::string::npos) << said();
    EXPECT_EQ(run("conformance patch --html none/c.html"), 2);
    EXPECT_NE(said().find("none"), std::string::npos) << said();
}

}  // namespace
}  // namespace pliant::test
