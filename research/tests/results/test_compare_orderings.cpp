// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

using Json = nlohmann::json;

TEST(CompareOrderings, ComparesThemWithTheExactSolution) {
    const TemporaryFolder folder;
    const std::string out = (folder / "out").string();
    const auto run = [&](const std::string& arguments) {
        return std::system(
            ("'" PLIANT_COMPARE_ORDERINGS "' " + arguments + " >'" + out + "'" + " 2>/dev/null")
                .c_str());
    };
    ASSERT_EQ(run("--json --size 12 --pull 2 --heterogeneous --rounds 1"), 0);
    std::istringstream lines(bytes_of(out));
    std::set<std::string> solvers;
    for (std::string line; std::getline(lines, line);) {
        const Json row = Json::parse(line);
        const auto solver = row.at("solver").get<std::string>();
        solvers.insert(solver);
        EXPECT_EQ(row.at("material"), "heterogeneous");
        EXPECT_GT(row.at("moved_elements"), 0);
        if (solver.starts_with("exact")) {
            EXPECT_EQ(row.at("violated_links"), 0) << line;
            EXPECT_EQ(row.at("max_distance_voxels"), 0) << line;
        } else if (solver == "gibson-lists") {
            EXPECT_GT(row.at("violated_links"), 0) << line;
        }
    }
    EXPECT_EQ(solvers.size(), 10u);
    EXPECT_EQ(run("--size 8 --homogeneous --rounds 1"), 0);
    EXPECT_NE(bytes_of(out).find("gibson-convex"), std::string::npos);
    EXPECT_NE(run("--size 2"), 0);
}

}  // namespace
}  // namespace pliant::test
