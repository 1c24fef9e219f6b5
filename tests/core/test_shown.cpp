// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "core/shown.h"

#include <gtest/gtest.h>

namespace pliant {
namespace {

TEST(Shown, EscapeSequencesAndLineEndsAreNotPassedOn) {
    EXPECT_EQ(shown("a\x1b]0;owned\a\n"), "a?]0;owned??");
    EXPECT_EQ(shown(std::string(61, 'x')), std::string(60, 'x') + "…");
    EXPECT_EQ(printable("a\x1b]0;owned\a\nb\x7f"), "a?]0;owned??b?");
    EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a?b");
    EXPECT_EQ(printable("\xc2\x9b"
                        "31m"),
              "??31m");  // a control sequence in one character
}

TEST(Shown, OtherAlphabetsArePassedOnWhole) {
    EXPECT_EQ(printable("10 × ä …"), "10 × ä …");
    EXPECT_EQ(printable("\xff\xc3"), "??");
    EXPECT_EQ(printable("aä", 2), "a…");
    EXPECT_EQ(printable("aä", 3), "aä");
    EXPECT_EQ(printable(std::string(400, 'x')), std::string(300, 'x') + "…");
}

}  // namespace
}  // namespace pliant
