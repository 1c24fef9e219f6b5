// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>
#include <pliant/core/record.h>

#include <cmath>
#include <random>

#include "base/record_toml.h"

namespace pliant {
namespace {

enum class Finish { Matt, Gloss };

struct Handle {
    double length_mm = 120;
};
struct Spoon {
    Handle handle{};
    double depth_mm = 8;
    int teeth = 0;
    std::int64_t number = 5;
    bool pierced = false;
    bool left = false;  ///< a choice between two
    Finish finish = Finish::Matt;
    std::string metal = "steel";
    std::optional<double> price{};
    Vec3d axes{1, 1, 1};
    std::vector<int> stamps{1};
    std::vector<Vec3d> curve_mm{};
    std::vector<NumberPair> widths{};
    std::optional<std::vector<std::string>> ends{};
};

constexpr Setting<Spoon> kRows[] = {
    setting<&Spoon::handle, &Handle::length_mm>(
        {.table = "handle", .name = "length_mm", .unit = "mm", .range = {0, 500}}),
    setting<&Spoon::depth_mm>(
        {.table = "bowl", .name = "depth_mm", .unit = "mm", .range = {0, 50}, .above_low = true}),
    setting<&Spoon::teeth>({.table = "bowl", .name = "teeth", .range = {0, 5}}),
    setting<&Spoon::number>({.table = "bowl", .name = "number", .range = {.low = 1}}),
    setting<&Spoon::pierced>({.table = "bowl", .name = "pierced"}),
    setting<&Spoon::left>(
        {.table = "bowl", .key = "hand", .name = "left", .choices = "right|left"}),
    setting<&Spoon::finish>({.table = "bowl", .name = "finish", .choices = "matt|gloss"}),
    setting<&Spoon::metal>({.table = "bowl", .name = "metal", .choices = "steel|silver|tin"}),
    setting<&Spoon::price>({.table = "bowl", .name = "price", .unit = "EUR", .range = {.low = 0}}),
    setting<&Spoon::axes>({.table = "bowl", .name = "axes", .range = {0, 2}}),
    setting<&Spoon::stamps>({.table = "bowl", .name = "stamps", .range = {-9, 9}}),
    setting<&Spoon::curve_mm>({.table = "bowl", .name = "curve_mm", .unit = "mm"}),
    setting<&Spoon::widths>({.table = "bowl", .name = "widths", .range = {0, 9}}),
    setting<&Spoon::ends>({.table = "bowl", .name = "ends", .choices = "-x|+x"}),
};
constexpr SettingRows<Spoon> kSpoon = kRows;

std::string error_of(const Status& status) {
    return status ? "" : status.error().message;
}

TEST(Record, NamedValuesAreSetAllOrNone) {
    Spoon spoon;
    const Record record = {{"length_mm", 90}, {"depth_mm", 7.5},
                           {"teeth", 3},      {"pierced", true},
                           {"left", "left"},  {"finish", "gloss"},
                           {"metal", "tin"},  {"price", 12},
                           {"axes", 0.5},     {"stamps", std::vector<double>{1, -2}}};
    ASSERT_EQ(error_of(apply(record, kSpoon, spoon)), "");
    EXPECT_EQ(spoon.handle.length_mm, 90);
    EXPECT_EQ(spoon.depth_mm, 7.5);
    EXPECT_EQ(spoon.teeth, 3);
    EXPECT_TRUE(spoon.pierced && spoon.left);
    EXPECT_EQ(spoon.finish, Finish::Gloss);
    EXPECT_EQ(spoon.metal, "tin");
    EXPECT_EQ(spoon.price, 12);
    EXPECT_EQ(spoon.axes, (Vec3d{0.5, 0.5, 0.5}));
    EXPECT_EQ(spoon.stamps, (std::vector<int>{1, -2}));

    const Record half = {{"teeth", 4}, {"depth_mm", 0.0}};
    const Status refused = apply(half, kSpoon, spoon);
    EXPECT_EQ(error_of(refused), "[bowl] depth_mm: expected above 0, up to 50 mm, found 0");
    EXPECT_EQ(refused.error().field, "[bowl] depth_mm");
    EXPECT_EQ(refused.error().expected, "above 0, up to 50 mm");
    EXPECT_EQ(refused.error().found, "0");
    EXPECT_EQ(spoon.teeth, 3);
}

TEST(Record, MistakesNameFieldAndExpectation) {
    const struct {
        NamedValue value;
        const char* message;
    } cases[] = {
        {{"fork", 1}, "fork: expected one of length_mm, depth_mm, teeth"},
        {{"length_mm", -1}, "[handle] length_mm: expected 0 to 500 mm, found -1"},
        {{"length_mm", NAN}, "[handle] length_mm: expected 0 to 500 mm, found nan"},
        {{"length_mm", true}, "[handle] length_mm: expected a number, found true"},
        {{"length_mm", "long"}, "[handle] length_mm: expected a number, found \"long\""},
        {{"teeth", 2.5}, "[bowl] teeth: expected a whole number, found 2.5"},
        {{"teeth", 6}, "[bowl] teeth: expected 0 to 5, found 6"},
        {{"number", 0}, "[bowl] number: expected 1 or more, found 0"},
        {{"pierced", 1}, "[bowl] pierced: expected true or false, found 1"},
        {{"left", "both"}, "[bowl] hand: expected \"right\" or \"left\", found \"both\""},
        {{"metal", "lead"}, "expected \"steel\", \"silver\" or \"tin\", found \"lead\""},
        {{"metal", 4}, "expected \"steel\", \"silver\" or \"tin\", found 4"},
        {{"axes", std::vector<double>{1, 2}}, "[bowl] axes: expected one number or three, found"},
        {{"axes", 3}, "[bowl] axes: expected 0 to 2, found [3, 3, 3]"},
        {{"stamps", std::vector<double>{1.5}}, "[bowl] stamps: expected a whole number"},
        {{"stamps", std::vector<double>{}}, "[bowl] stamps: expected a whole number"},
        {{"stamps", std::vector<double>{10}}, "[bowl] stamps: expected -9 to 9, found 10"},
        {{"price", SettingValue{}}, "[bowl] price: expected a number, found something else"},
        {{"curve_mm", 3}, "[bowl] curve_mm: expected a list of points"},
        {{"widths", std::vector<double>{1, 2}},
         "[bowl] widths: expected a list of pairs of numbers, found [1, 2]"},
        {{"widths", std::vector<NumberPair>{{1, 2}, {3, 10}}},
         "[bowl] widths: expected 0 to 9, found 2 pairs"},
        {{"ends", "-x"}, "[bowl] ends: expected a list of \"-x\" or \"+x\", found \"-x\""},
        {{"ends", std::vector<std::string>{"+y"}},
         "[bowl] ends: expected a list of \"-x\" or \"+x\", found [\"+y\"]"},
    };
    for (const auto& c : cases) {
        Spoon spoon;
        const std::string message = error_of(apply({c.value}, kSpoon, spoon));
        EXPECT_NE(message.find(c.message), std::string::npos) << message;
    }
}

TEST(Record, RangesAreWrittenAsPeopleWriteThem) {
    const auto text = [](double low, double high) {
        return expected_of({.name = "x", .unit = "Pa", .range = {low, high}});
    };
    EXPECT_EQ(text(1, 1e9), "1 to 1e9 Pa");
    EXPECT_EQ(text(1e-4, 1e5), "0.0001 to 100000 Pa");
    EXPECT_EQ(text(-32768, 65535), "-32768 to 65535 Pa");
    EXPECT_EQ(text(1.5e-12, 2.5e120), "1.5e-12 to 2.5e120 Pa");
    EXPECT_EQ(text(-1e10, 0), "-1e10 to 0 Pa");
    EXPECT_EQ(text(-INFINITY, INFINITY), "true or false");
}

TEST(Record, EveryFieldComesBackFromItsRecord) {
    Spoon spoon;
    spoon.handle.length_mm = 0.1;
    spoon.left = true;
    spoon.price = 3;
    spoon.curve_mm = {{1, 2, 3}, {4, 5, 6}};
    spoon.widths = {{0, 1}, {2, 3}};
    spoon.ends = {"+x", "-x"};
    const Record record = record_of(spoon, kSpoon);
    Spoon other;
    ASSERT_EQ(error_of(apply(record, kSpoon, other)), "");
    EXPECT_EQ(record_of(other, kSpoon), record);
    EXPECT_EQ(other.curve_mm.size(), 2u);
    EXPECT_EQ(other.widths, spoon.widths);
    EXPECT_EQ(other.ends, spoon.ends);
    EXPECT_EQ(record.size(), std::size(kRows));
    EXPECT_EQ(record_of(Spoon{}, kSpoon).size(), std::size(kRows) - 2);  // without price and ends
}

TEST(Record, RangesAreHeldAgainstTheWholeStruct) {
    Spoon spoon;
    EXPECT_EQ(error_of(check(spoon, kSpoon)), "");
    spoon.metal = "lead";
    EXPECT_NE(error_of(check(spoon, kSpoon)).find("[bowl] metal"), std::string::npos);
    spoon = {};
    spoon.axes.y = -1;
    EXPECT_NE(error_of(check(spoon, kSpoon)).find("[bowl] axes"), std::string::npos);
    spoon = {};
    spoon.price = INFINITY;
    EXPECT_NE(error_of(check(spoon, kSpoon)).find("[bowl] price"), std::string::npos);
}

TEST(Record, TomlComesBackBitForBit) {
    const std::uint32_t seed = 20261125;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(0, 1);
    for (int n = 0; n < 200; ++n) {
        Spoon spoon;
        spoon.handle.length_mm = 500 * share(random);
        spoon.depth_mm = 50 * share(random) + 1e-9;
        spoon.teeth = int(random() % 6);
        spoon.axes = {share(random), share(random), 2 * share(random)};
        if (n % 2) spoon.price = 1e3 * share(random);
        if (n % 3) spoon.curve_mm = {{share(random), -share(random), 1e-7 * share(random)}};
        if (n % 4) spoon.widths = {{share(random), 0}, {9 * share(random), 1e-9 * share(random)}};
        if (n % 5) spoon.ends.emplace(n % 5 - 1, n % 2 ? "-x" : "+x");
        const std::string text = toml_text(spoon, kSpoon);
        const auto tables = parse_toml(text);
        ASSERT_TRUE(tables.ok()) << text;
        Spoon read;
        for (const TomlTable& table : *tables)
            ASSERT_EQ(error_of(read_table(table, kSpoon, read)), "") << text;
        EXPECT_EQ(record_of(read, kSpoon), record_of(spoon, kSpoon)) << text;
    }
}

TEST(Record, PlainTomlIsReadAsTheParserReadsIt) {
    const std::string text =
        "[handle]\nlength_mm = 12.5\n[bowl]\nteeth = 3\npierced = true\nmetal = \"tin\"\n"
        "axes = [1, 0.25, 3e-3]\n";
    const auto plain = parse_plain_toml(text);
    const auto parsed = parse_toml(text);
    ASSERT_TRUE(parsed.ok());
    ASSERT_EQ(plain.size(), 2u);
    Spoon one, other;
    for (const TomlTable& table : plain) ASSERT_TRUE(read_table(table, kSpoon, one).ok());
    for (const TomlTable& table : *parsed) ASSERT_TRUE(read_table(table, kSpoon, other).ok());
    EXPECT_EQ(record_of(one, kSpoon), record_of(other, kSpoon));
    for (const char* strange :
         {"x = 1\n", "[bowl]\nteeth=3\n", "[bowl]\nteeth = 1979-05-27\n",
          "[bowl]\naxes = [1,2,3]\n", "[bowl]\naxes = [1, 2, 3\n", "[bowl]\naxes = [1, [2], 3]\n",
          "[bowl]\naxes = [1, x]\n", "[bowl]\nmetal = \"a\\tb\"\n"})
        EXPECT_TRUE(parse_plain_toml(strange).empty()) << strange;
}

TEST(Record, TablesNameThemselvesInMistakes) {
    const auto message_of = [](const std::string& text) {
        const auto tables = parse_toml(text);
        if (!tables) return tables.error().message;
        Spoon spoon;
        for (const TomlTable& table : *tables)
            if (const Status s = read_table(table, kSpoon, spoon); !s) return s.error().message;
        return std::string();
    };
    EXPECT_EQ(message_of("[bowl]\nteeth = 9"), "[bowl] teeth: expected 0 to 5, found 9");
    EXPECT_EQ(message_of("[[bowl]]\nteeth = 1\n[[bowl]]\nteeth = 9"),
              "[[bowl]] 2 teeth: expected 0 to 5, found 9");
    EXPECT_EQ(message_of("[bowl]\nteeth = 1979-05-27"),
              "[bowl] teeth: expected a whole number, found something else");
    EXPECT_EQ(message_of("[bowl]\naxes = [1, \"a\", 2]").substr(0, 12), "[bowl] axes:");
    EXPECT_EQ(message_of("teeth = 3").substr(0, 30), "teeth: expected a table, [teet");
    EXPECT_NE(message_of("[fork]\nteeth = 3")
                  .find("[fork] teeth: expected one of [handle] length_mm; [bowl] depth_mm"),
              std::string::npos);
    EXPECT_NE(message_of("[bowl\n").find("line 1: expected TOML"), std::string::npos);
}

}  // namespace
}  // namespace pliant
