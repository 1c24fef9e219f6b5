// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

TEST(Settings, DefaultsAreTheContract) {
    const ChainMailSettings settings;
    EXPECT_EQ(settings.law, "draeger");
    EXPECT_EQ(settings.offset, 0.2);
    EXPECT_EQ(settings.bone_threshold_hu, 300);
    EXPECT_EQ(settings.max_movement_mm, 20);
    EXPECT_EQ(settings.scale, 1);
    EXPECT_EQ(settings.brick_size, 8);
    EXPECT_FALSE(settings.air_enabled);
    EXPECT_EQ(settings.air_threshold_hu, -500);
}

TEST(Settings, EveryKeyIsRead) {
    const TemporaryFolder folder;
    const auto file = folder.write("a.toml", R"(
        [material]
        law = "draeger"
        offset = 0.15
        bone_threshold_hu = 250
        max_movement_mm = 12.5
        [push]
        scale = 1.2
        [lattice]
        brick_size = 5
        max_elements = 1000000
        [air]
        enabled = false
        threshold_hu = -450)");
    const auto settings = read_chainmail_settings(file);
    ASSERT_TRUE(settings.ok()) << settings.error().message;
    EXPECT_EQ(settings->offset, 0.15);
    EXPECT_EQ(settings->bone_threshold_hu, 250);
    EXPECT_EQ(settings->max_movement_mm, 12.5);
    EXPECT_EQ(settings->scale, 1.2);
    EXPECT_EQ(settings->brick_size, 5);
    EXPECT_EQ(settings->max_elements, 1'000'000);
    EXPECT_EQ(settings->air_threshold_hu, -450);
}

TEST(Settings, DivodsKeyValueLinesAreRead) {
    const TemporaryFolder folder;
    const auto file = folder.write("divod.txt",
                                   "# a comment\n"
                                   "cubicle size=5\n"
                                   "scale factor = 1.2\n"
                                   "offset=0.25\n"
                                   "maximum allowed movement for element=7\n"
                                   "bone threshold=1400\n"
                                   "adapt regions to z-scale=true\n"
                                   "max tries=5\n"
                                   "step scale=0.5\n");
    std::vector<std::string> notes;
    const auto settings = read_chainmail_settings(file, &notes);
    ASSERT_TRUE(settings.ok()) << settings.error().message;
    EXPECT_EQ(settings->brick_size, 5);
    EXPECT_EQ(settings->scale, 1.2);
    EXPECT_EQ(settings->offset, 0.25);
    EXPECT_EQ(settings->max_movement_mm, 7);
    EXPECT_EQ(settings->bone_threshold_hu, 400);
    EXPECT_EQ(notes.size(), 5u);
}

TEST(Settings, BadFilesAreNamedWithKeyAndExpectation) {
    const struct {
        const char* text;
        const char* expected;
    } cases[] = {
        {"[material]\noffset = 1.5", "[material] offset: expected a fraction"},
        {"[material]\noffset = 0", "[material] offset"},
        {"[material]\noffset = nan", "[material] offset"},
        {"[material]\noffset = \"soft\"", "[material] offset: expected a number, found string"},
        {"[material]\nofset = 0.1", "[material] ofset: expected one of"},
        {"[material]\nlaw = \"hooke\"", "expected \"draeger\", found \"hooke\""},
        {"[materials]\noffset = 0.1", "[materials] offset"},
        {"[material]\nmax_movement_mm = -1", "max_movement_mm: expected 0 to 500 mm"},
        {"[push]\nscale = 0", "[push] scale"},
        {"[lattice]\nbrick_size = 1", "brick_size: expected 2 to 32, found 1"},
        {"[lattice]\nbrick_size = 8.5", "brick_size: expected a whole number"},
        {"[air]\nenabled = true", "[air] enabled: expected false"},
        {"[air]\nenabled = 3", "[air] enabled: expected true or false"},
        {"[material\noffset = 1", "line 1: expected TOML"},
        {"offset=abc", "offset: expected a number, found 'abc'"},
        {"ofset=0.2", "ofset: expected cubicle size"},
        {"offset 0.2", "expected key=value"},
    };
    const TemporaryFolder folder;
    for (const auto& c : cases) {
        const auto file = folder.write("bad.toml", c.text);
        const auto settings = read_chainmail_settings(file);
        ASSERT_FALSE(settings.ok()) << c.text;
        EXPECT_NE(settings.error().message.find(c.expected), std::string::npos)
            << c.text << "\n"
            << settings.error().message;
        EXPECT_NE(settings.error().message.find("bad.toml"), std::string::npos);
        EXPECT_EQ(settings.error().message.find('\n'), std::string::npos);
    }
    const auto missing = read_chainmail_settings(folder / "none.toml");
    ASSERT_FALSE(missing.ok());
    EXPECT_NE(missing.error().message.find("none.toml"), std::string::npos);
    EXPECT_FALSE(read_chainmail_settings(folder.path()).ok());
}

TEST(Settings, DraegersLawIsTheThesis) {
    ChainMailSettings settings;
    settings.offset = 0.2;
    settings.max_movement_mm = 10;
    const MaterialLaw law = draeger_law(settings);
    EXPECT_DOUBLE_EQ(law(-1000).shear.x, 0.2);
    EXPECT_DOUBLE_EQ(law(-2000).shear.x, 0.2);
    EXPECT_DOUBLE_EQ(law(3095).stretch.y, 0);
    EXPECT_DOUBLE_EQ(law(4000).compress.z, 0);
    const double w = 2000 / 4095.0;
    EXPECT_DOUBLE_EQ(law(1000).compress.z, 0.2 * (1 - w * w));
    EXPECT_DOUBLE_EQ(law(1000).max_movement_mm, 10 * (1 - w * w));
    EXPECT_TRUE(law(301).fixed);
    EXPECT_FALSE(law(300).fixed);
}

}  // namespace
}  // namespace pliant::test
