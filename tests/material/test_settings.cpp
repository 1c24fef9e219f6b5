// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>
#include <pliant/chainmail.h>

#include <sstream>
#include <string_view>
#include <vector>

#include "material/material.h"
#include "material/settings.h"
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
    EXPECT_TRUE(settings.air_enabled);
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
        limits = "rounded"
        [push]
        scale = 1.2
        [lattice]
        brick_size = 5
        max_elements = 1000000
        [air]
        enabled = false
        threshold_hu = -450
        compress = 0.9
        stretch = 20
        shear = 30
        [[label]]
        values = [3, 5]
        law = "constant"
        compress = 0.1
        stretch = [0.1, 0.2, 0.3]
        shear = 0
        max_movement_mm = 4
        frame = "direction"
        [[label]]
        values = 9
        offset = 0.05
        bone_threshold_hu = 1000
        factor = [1, 1, 0.5])");
    const auto settings = read_chainmail_settings(file);
    ASSERT_TRUE(settings.ok()) << settings.error().message;
    EXPECT_EQ(settings->offset, 0.15);
    EXPECT_EQ(settings->bone_threshold_hu, 250);
    EXPECT_EQ(settings->max_movement_mm, 12.5);
    EXPECT_EQ(settings->scale, 1.2);
    EXPECT_EQ(settings->brick_size, 5);
    EXPECT_EQ(settings->max_elements, 1'000'000);
    EXPECT_EQ(settings->limits, LinkLimits::Rounded);
    EXPECT_FALSE(settings->air_enabled);
    EXPECT_EQ(settings->air_threshold_hu, -450);
    EXPECT_EQ(settings->air_compress, 0.9);
    EXPECT_EQ(settings->air_stretch, 20);
    EXPECT_EQ(settings->air_shear, 30);
    ASSERT_EQ(settings->label_materials.size(), 2u);
    const LabelMaterial& fibres = settings->label_materials[0];
    EXPECT_EQ(fibres.values, (std::vector<int>{3, 5}));
    EXPECT_EQ(fibres.law, LabelLaw::Constant);
    EXPECT_EQ(fibres.compress, (Vec3d{0.1, 0.1, 0.1}));
    EXPECT_EQ(fibres.stretch, (Vec3d{0.1, 0.2, 0.3}));
    EXPECT_EQ(fibres.shear, (Vec3d{0, 0, 0}));
    EXPECT_EQ(fibres.max_movement_mm, 4);
    EXPECT_TRUE(fibres.along_direction);
    const LabelMaterial& other = settings->label_materials[1];
    EXPECT_EQ(other.law, LabelLaw::ByValue);
    EXPECT_EQ(other.offset, 0.05);
    EXPECT_EQ(other.bone_threshold_hu, 1000);
    EXPECT_EQ(other.factor, (Vec3d{1, 1, 0.5}));
    EXPECT_FALSE(other.along_direction);
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
    std::string deep = "[material]\n";
    for (int n = 0; n < 100'000; ++n) deep += "a.";
    deep += "a = 1\n";
    // As in a saved state.
    EXPECT_FALSE(parse_settings("s.plst", deep).ok());
    const struct {
        const char* text;
        const char* expected;
    } cases[] = {
        {"[material]\noffset = 1.5", "[material] offset: expected 0 to 1"},
        {"[material]\noffset = -0.1", "[material] offset: expected 0 to 1, found -0.1"},
        {"[material]\noffset = nan", "[material] offset"},
        {"[material]\noffset = \"soft\"", "[material] offset: expected a number, found \"soft\""},
        {"[material]\nofset = 0.1", "[material] ofset: expected one of"},
        {"[material]\nlaw = \"hooke\"", "expected \"draeger\", found \"hooke\""},
        {"[materials]\noffset = 0.1", "[materials] offset"},
        {"[material]\nmax_movement_mm = -1", "max_movement_mm: expected 0 to 500 mm"},
        {"[push]\nscale = 0", "[push] scale"},
        {"[lattice]\nbrick_size = 1", "brick_size: expected 2 to 32 elements, found 1"},
        {"[lattice]\nbrick_size = 8.5", "brick_size: expected a whole number"},
        {"[air]\ncompress = 1.5", "[air] compress: expected 0 to 1, found 1.5"},
        {"[air]\nstretch = 1e-320", "[air] stretch: expected 0.01 or more, or [lattice] bounded"},
        {"[air]\ncompress = 0", "[air] compress: expected 0.01 or more, or [lattice] bounded"},
        {"[air]\nshear = 0.001", "[air] shear: expected 0.01 or more, or [lattice] bounded"},
        {"[air]\nstretch = -1", "[air] stretch: expected 0 to 500, found -1"},
        {"[air]\nshear = 1e9", "[air] shear"},
        {"[material]\nlimits = \"round\"", "expected \"box\" or \"rounded\", found \"round\""},
        {"[label]\nvalues = 1", "[label]: expected [[label]]"},
        {"[[label]]\nvalue = 1", "[[label]] 1 value: expected one of values, law"},
        {"[[label]]\nlaw = \"fixed\"", "[[label]] 1 values: expected one label or more"},
        {"[[label]]\nvalues = [1, \"a\"]", "[[label]] 1 values: expected a whole number"},
        {"[[label]]\nvalues = 1\n[[label]]\nvalues = [2, 1]",
         "[[label]] 2 values: expected each label once, found 1"},
        {"[[label]]\nvalues = 1\nfactor = [1, 2]",
         "factor: expected one number or three, found [1, 2]"},
        {"[[label]]\nvalues = 1\nshear = -1",
         "[[label]] 1 shear: expected 0 to 100, found [-1, -1, -1]"},
        {"[[label]]\nvalues = 1\nlaw = \"soft\"", "expected \"draeger\", \"constant\" or"},
        {"[[label]]\nvalues = 1\nframe = \"world\"", "expected \"lattice\" or \"direction\""},
        {"[[label]]\nvalues = 1\noffset = 2", "[[label]] 1 offset: expected 0 to 1"},
        {"[[label]]\nvalues = 99999", "[[label]] 1 values: expected -32768 to 65535, found 99999"},
        {"[material]\nrange = [1, 0]", "[material] range: expected a lower and a higher value, "},
        {"[material]\nrange = 3", "[material] range: expected two numbers, found 3"},
        {"[material]\nrange_percent = [1, 101]", "[material] range_percent: expected 0 to 100"},
        {"[material]\nrange_percent = [2, 2]", "[material] range_percent: expected a lower and"},
        {"[material]\nelastic = [5, 0.3]",
         "[material] elastic: expected [elastic] moduli_kpa and --model elastic"},
        {"[[label]]\nvalues = 1\nelastic = [0, 0.3]", "[[label]] 1 elastic: expected a modulus"},
        {"[[label]]\nvalues = 1\nelastic = [5, 0.5]",
         "a Poisson's ratio from 0, below 0.5, found 5, 0.5"},
        {"[material]\nfactor = -1", "[material] factor: expected 0 to 100"},
        {"[air]\nenabled = 3", "[air] enabled: expected true or false"},
        {"[material\noffset = 1", "line 1: expected TOML"},
        {deep.c_str(), "bad.toml: line 2: expected keys of up to 32 dots, found more"},
        {"[air]\nenabled = fals\n", "line 2: expected TOML"},
        {"[air]\n\"a\\nb\" = 1", "[air] a?b: expected one of"},
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

TEST(Settings, ANumberIsTakenBetweenItsEndsOnly) {
    constexpr double kNone = -1;  // of an upper end
    const struct {
        const char *table, *key;
        double low, high, step;
    } ends[] = {
        {"material", "offset", 0, 1, 1e-6},
        {"material", "factor", 0, 100, 1e-6},
        {"material", "smallest_bone_mm3", 0, kNone, 1e-6},
        {"material", "max_movement_mm", 0, 500, 1e-6},
        {"material", "yield", 0, 1, 1e-6},
        {"push", "scale", 1e-9, 1000, 1e-9},
        {"lattice", "brick_size", 2, 32, 1},
        {"lattice", "max_elements", 1, kNone, 1},
        {"history", "max_steps", 0, 100'000, 1},
        {"history", "max_mb", 0, 1'000'000, 1},
        {"air", "compress", 0.01, 1, 1e-6},
        {"air", "stretch", 0.01, 500, 1e-6},
        {"air", "shear", 0.01, 500, 1e-6},
        {"[label]", "offset", 0, 1, 1e-6},
        {"[label]", "max_movement_mm", 0, 500, 1e-6},
        {"[label]", "yield", 0, 1, 1e-6},
        {"[label]", "factor", 0, 100, 1e-6},
        {"[label]", "compress", 0, 1, 1e-6},
        {"[label]", "stretch", 0, 100, 1e-6},
        {"[label]", "shear", 0, 100, 1e-6},
    };
    const TemporaryFolder folder;
    for (const auto& end : ends) {
        const auto takes = [&](double value) {
            std::ostringstream text;
            text.precision(17);
            text << '[' << end.table << "]\n";
            if (end.table[0] == '[') text << "values = 1\n";
            text << end.key << " = " << value << '\n';
            return read_chainmail_settings(folder.write("a.toml", text.str())).ok();
        };
        SCOPED_TRACE(std::string(end.table) + ' ' + end.key);
        EXPECT_TRUE(takes(end.low));
        EXPECT_FALSE(takes(end.low - end.step));
        EXPECT_TRUE(takes(end.high == kNone ? 1e9 : end.high));
        EXPECT_TRUE(end.high == kNone || !takes(end.high + end.step));
    }
    const auto takes = [&](const char* text) {
        return read_chainmail_settings(folder.write("a.toml", text)).ok();
    };
    EXPECT_TRUE(takes("[material]\nrange_percent = [0, 100]"));
    EXPECT_FALSE(takes("[material]\nrange_percent = [-1, 100]"));
    EXPECT_TRUE(takes("[[label]]\nvalues = [-32768, 65535]"));
    EXPECT_FALSE(takes("[[label]]\nvalues = -32769"));
    EXPECT_FALSE(takes("[[label]]\nvalues = 65536"));
    EXPECT_TRUE(takes("[[label]]\nvalues = 1\nelastic = [0.001, 0]"));
    EXPECT_FALSE(takes("[[label]]\nvalues = 1\nelastic = [5, -0.001]"));
    EXPECT_TRUE(takes("[[label]]\nvalues = 1\nelastic = [5, 0.499]"));
    EXPECT_TRUE(takes("[lattice]\nbounded = true\n[air]\ncompress = 0\nstretch = 0\nshear = 0"));
}

TEST(Settings, AFileForAScanKeepsTheScansDefaultsWhereItSaysNothing) {
    ValueDefaults mr;
    mr.kind = ValueKind::Magnetic;
    mr.range = {0, 3000};
    mr.air_threshold = 120;
    mr.has_bone = false;
    mr.bone_threshold = 1000;
    const TemporaryFolder folder;
    const auto read = [&](const char* text) {
        const auto settings = read_chainmail_settings(folder.write("a.toml", text), mr);
        EXPECT_TRUE(settings.ok()) << settings.error().message;
        return *settings;
    };
    const ChainMailSettings few = read("[material]\noffset = 0.1\n");
    EXPECT_EQ(few.offset, 0.1);
    EXPECT_EQ(few.range, mr.range);
    EXPECT_EQ(few.air_threshold_hu, 120);
    EXPECT_EQ(few.bone_threshold_hu, 3000);
    const ChainMailSettings other = read("[material]\nrange = [0, 6000]\n[air]\nshear = 3\n");
    EXPECT_EQ(other.range, (ValueSpan{0, 6000}));
    EXPECT_EQ(other.air_threshold_hu, 240);
    EXPECT_EQ(other.air_shear, 3);
    const ChainMailSettings own =
        read("[material]\nrange = [0, 6000]\nbone_threshold_hu = 7\n[air]\nthreshold_hu = 5\n");
    EXPECT_EQ(own.air_threshold_hu, 5);
    EXPECT_EQ(own.bone_threshold_hu, 7);
    EXPECT_EQ(read("bone threshold=1400\n").air_threshold_hu, 120);  // Divod's lines
}

TEST(Settings, RowsOfMaterialsAreThoseOfTissueAndAir) {
    std::vector<std::string_view> expected, found;
    for (const auto& row : chainmail_rows())
        if (row.table == "material" || row.table == "air") expected.push_back(row.name);
    for (const auto& row : chainmail_material_rows()) found.push_back(row.name);
    EXPECT_EQ(found, expected);
    EXPECT_EQ(found.front(), "law");
    EXPECT_EQ(found.back(), "air_shear");
}

TEST(LookupScale, NumbersStandForValuesAndBack) {
    const LookupScale of_ct, of_floats{.per_value = 4, .shift = -10};
    EXPECT_EQ(of_ct.value_of(-37), -37);
    EXPECT_EQ(of_ct.position_of(-37.5), -37.5);
    EXPECT_EQ(of_floats.value_of(2), 3);
    EXPECT_EQ(of_floats.position_of(3.5), 4);
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
