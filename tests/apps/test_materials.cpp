// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `pliant materials`: the table, one passport, JSON and an unknown name.
// Covers: pliant/run_materials.cpp.

#include <gtest/gtest.h>
#include <pliant/models/passports.h>

#include <algorithm>
#include <string>

#include "support/json.h"
#include "support/program_in_folder.h"

namespace pliant::test {
namespace {

using MaterialsProgram = ProgramInFolder;

std::size_t line_count(const std::string& text) {
    return std::size_t(std::count(text.begin(), text.end(), '\n'));
}

TEST_F(MaterialsProgram, ListsAllPassports) {
    ASSERT_EQ(run("materials"), 0) << said();
    const std::string table = out();
    EXPECT_EQ(line_count(table), 1 + material_passports().size());
    for (const MaterialPassport& passport : material_passports())
        EXPECT_NE(table.find("\n" + std::string(passport.name) + " "), table.npos);
    ASSERT_EQ(run("materials --json"), 0);
    const Json json = Json::parse(out());
    ASSERT_EQ(json.size(), material_passports().size());
    EXPECT_EQ(json[2]["name"], "liver");
    EXPECT_EQ(json[2]["young_modulus_kpa"], 4.3);
    EXPECT_TRUE(json[2]["strain"].empty());
    EXPECT_TRUE(json[2]["error_percent"].is_null());
}

TEST_F(MaterialsProgram, PrintsACurveBesideTheLaws) {
    ASSERT_EQ(run("materials cortex"), 0) << said();
    const std::string text = out();
    EXPECT_NE(text.find("2.8 times as stiff in compression"), text.npos) << text;
    EXPECT_NE(text.find("4.45 kPa: 46 % RMS (tension 24 %, compression 50 %, shear 34 %)"),
              text.npos)
        << text;
    // 4.45/3 (s − 1/s²) but for Poisson's ratio of 0.49, and 0.4151 measured.
    EXPECT_NE(text.find("tension        0.10000    0.4151    0.4063    0.5863    0.32"), text.npos)
        << text;
    EXPECT_NE(text.find("Ogden's law  4.54 kPa, exponent -17.9: 7 % RMS (tension 16 %, compression "
                        "2 %, shear 11 %)"),
              text.npos)
        << text;
    ASSERT_EQ(run("materials cortex --json"), 0);
    const Json json = Json::parse(out());
    const LawError fit = fit_law(*find_material("cortex"));
    EXPECT_EQ(json["fitted_young_modulus_kpa"], fit.young_modulus_kpa);
    EXPECT_EQ(json["fitted_error_percent"], fit.percent);
    EXPECT_EQ(json["load"].size(), 48u);
    EXPECT_EQ(json["load"][47], "shear");
    EXPECT_EQ(json["stress_kpa"][47], 0.5435);
    EXPECT_TRUE(json["deviation_kpa"].is_null());
    EXPECT_EQ(json["ogden_alpha"], find_material("cortex")->ogden_alpha);
    EXPECT_EQ(json["ogden_stress_kpa"].size(), 48u);
    EXPECT_NEAR(json["ogden_error_percent"].get<double>(), 6.9, 0.1);
}

TEST_F(MaterialsProgram, NamesAnUnknownMaterial) {
    EXPECT_EQ(run("materials jelly"), 2);
    EXPECT_NE(said().find("found 'jelly'"), std::string::npos) << said();
}

}  // namespace
}  // namespace pliant::test
