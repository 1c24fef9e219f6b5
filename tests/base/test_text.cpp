// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace pliant {
namespace {

TEST(Text, NumbersFillTheWholeText) {
    EXPECT_EQ(number_from(" +1.5e2 "), 150.0);
    EXPECT_EQ(number_from("-0.25"), -0.25);
    EXPECT_TRUE(std::isnan(number_from("nan").value_or(0)));
    for (const char* bad : {"", " ", "1.5x", "1,5", "x", "+", "1 2"})
        EXPECT_FALSE(number_from(bad)) << bad;
    EXPECT_FALSE(whole_number_from("1.5"));
    EXPECT_FALSE(whole_number_from("99999999999999999999"));
}

TEST(Text, BlanksSeparateInAnyNumber) {
    EXPECT_EQ(numbers_from("1  2\t3 "), (std::vector<double>{1, 2, 3}));
    EXPECT_EQ(numbers_from("1\\-2\\3", '\\'), (std::vector<double>{1, -2, 3}));
    EXPECT_FALSE(numbers_from("1 two 3"));
}

TEST(Text, NumbersAreWrittenSoThatTheyReadBackTheSame) {
    for (const double number : {0.1, -1.0 / 3, 1e-300, 6.02e23, 0.0, 1.5625})
        EXPECT_EQ(number_from(text_of(number)), number);
    EXPECT_EQ(text_of(0.1), "0.1");
}

TEST(Text, NumbersHaveTheDigitsOfPrintf) {
    EXPECT_EQ(short_text(1234567.0), "1.23457e+06");
    EXPECT_EQ(short_text(0.0625, 2), "0.062");
    EXPECT_EQ(fixed_text(2.5, 0), "2");  // half to even
    EXPECT_EQ(fixed_text(-0.001, 2), "-0.00");
    EXPECT_EQ(fixed_text(1e300, 1), "1.0e+300");
    for (const double number : {0.1, -1.0 / 3, 1e-300, 6.02e23, 1.5625})
        for (int digits = 1; digits < 9; ++digits) {
            char general[64], fixed[64];
            std::snprintf(general, sizeof general, "%.*g", digits, number);
            std::snprintf(fixed, sizeof fixed, "%.*f", digits, number);
            EXPECT_EQ(short_text(number, digits), general);
            EXPECT_EQ(fixed_text(number, digits), fixed);
        }
}

TEST(Text, WhatIsShownOfADamagedFileIsShortAndPrintable) {
    EXPECT_EQ(shown("a\n\x01z"), "a??z");
    EXPECT_LT(shown(std::string(1000, 'x')).size(), 70u);
}

}  // namespace
}  // namespace pliant
