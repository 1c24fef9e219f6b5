// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>
#include <pliant/tissues.h>

#include <random>
#include <string>
#include <utility>

#include "base/record_toml.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

constexpr const char* kBoth = R"(
    [material]
    offset = 0.15
    [elastic]
    moduli_kpa = [[-950, 0], [-900, 1.5], [40, 8]]
    poisson_ratio = 0.4
    held_sides = ["-x", "+z"]
    window_cells = 32
    [[label]]
    values = 3
)";

TEST(ElasticSettings, DefaultsAreTheContract) {
    const ElasticScanSettings settings;
    EXPECT_EQ(settings.poisson_ratio, 0.45);
    EXPECT_EQ(settings.held_above_hu, 300);
    EXPECT_TRUE(settings.moduli_kpa.empty());
    EXPECT_FALSE(settings.held_sides.has_value());
}

TEST(ElasticSettings, OneFileServesChainMailAndTheElasticScan) {
    const TemporaryFolder folder;
    const auto file = folder.write("both.toml", kBoth);
    const auto elastic = read_elastic_settings(file);
    ASSERT_TRUE(elastic.ok()) << elastic.error().message;
    const std::vector<ElasticScanSettings::Modulus> moduli = {{-950, 0}, {-900, 1.5}, {40, 8}};
    EXPECT_EQ(elastic->moduli_kpa, moduli);
    EXPECT_EQ(elastic->poisson_ratio, 0.4);
    EXPECT_EQ(elastic->held_above_hu, 300);
    EXPECT_EQ(elastic->held_sides, (std::vector<std::string>{"-x", "+z"}));
    EXPECT_EQ(elastic->window_cells, 32);
    const auto chainmail = read_chainmail_settings(file);
    ASSERT_TRUE(chainmail.ok()) << chainmail.error().message;
    EXPECT_EQ(chainmail->offset, 0.15);
    EXPECT_EQ(chainmail->label_materials.size(), 1u);
}

TEST(ElasticSettings, KeysThatAreMissingSuitTheScan) {
    const TemporaryFolder folder;
    const auto file = folder.write("a.toml", "[elastic]\npoisson_ratio = 0.3\nheld_sides = []\n");
    const ValueDefaults magnetic{.kind = ValueKind::Magnetic,
                                 .range = {0, 900},
                                 .air_threshold = 30,
                                 .bone_threshold = 700,
                                 .has_bone = false};
    const auto settings = read_elastic_settings(file, magnetic);
    ASSERT_TRUE(settings.ok()) << settings.error().message;
    ElasticScanSettings expected;
    suit_elastic(magnetic, expected);
    expected.poisson_ratio = 0.3;
    expected.held_sides.emplace();
    EXPECT_EQ(*settings, expected);
    EXPECT_EQ(settings->held_above_hu, 700);
}

TEST(ElasticSettings, RandomSettingsComeBackFromAFileBitForBit) {
    const std::uint32_t seed = 20261129;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(0, 1);
    const TemporaryFolder folder;
    for (int n = 0; n < 50; ++n) {
        ElasticScanSettings settings;
        double value = -2000 * share(random);
        const int count = 1 + int(random() % 6);
        for (int m = 0; m < count; ++m)
            settings.moduli_kpa.push_back({value += share(random) + 1e-9, 100 * share(random)});
        settings.poisson_ratio = 0.495 * share(random);
        settings.held_above_hu = 4000 * share(random);
        settings.return_s = share(random) + 1e-3;
        settings.window_cells = 8 + 2 * std::int32_t(random() % 40);
        if (n % 2) settings.held_sides.emplace(random() % 3, n % 4 == 1 ? "-y" : "+z");
        const auto file = folder.write("r.toml", toml_text(settings, elastic_scan_rows()));
        const auto read = read_elastic_settings(file);
        ASSERT_TRUE(read.ok()) << read.error().message;
        EXPECT_EQ(*read, settings);
    }
}

TEST(ElasticSettings, MistakesNameFileTableAndKey) {
    const TemporaryFolder folder;
    for (const auto& [text, message] : {
             std::pair("[elastic]\nstiffness = 3", "[elastic] stiffness: expected one of"),
             {"[elastic]\npoisson_ratio = 0.5", "[elastic] poisson_ratio: expected 0 to 0.495"},
             {"[elastic]\nmoduli_kpa = [1, 2]", "[elastic] moduli_kpa: expected a list of pairs"},
             {"[elastic]\nmoduli_kpa = [[1, 2, 3]]", "moduli_kpa: expected a list of pairs"},
             {"[elastic]\nmoduli_kpa = [[1, 2], 3]", "moduli_kpa: expected a list of pairs"},
             {"[elastic]\nmoduli_kpa = [[4, 2], [3, 1]]", "expected ascending values"},
             {"[elastic]\nheld_sides = [\"left\"]", "[elastic] held_sides: expected a list of"},
             {"[elastic]\nheld_sides = \"-x\"", "[elastic] held_sides: expected a list of"},
             {"[elastic]\nwindow_cells = 9", "[elastic] window_cells: expected an even number"},
             {"[elastc]\npoisson_ratio = 0.3", "[elastc]: expected [elastic]"},
             {"[[elastic]]\npoisson_ratio = 0.3", "[[elastic]] 1: expected [elastic]"},
             {"poisson_ratio = 0.3", "poisson_ratio: expected a table"},
         }) {
        const auto file = folder.write("bad.toml", text);
        const auto read = read_elastic_settings(file);
        ASSERT_FALSE(read.ok()) << text;
        EXPECT_NE(read.error().message.find(message), std::string::npos) << read.error().message;
        EXPECT_NE(read.error().message.find("bad.toml"), std::string::npos) << read.error().message;
    }
    EXPECT_FALSE(read_elastic_settings(folder.path() / "none.toml").ok());
}

}  // namespace
}  // namespace pliant::test
