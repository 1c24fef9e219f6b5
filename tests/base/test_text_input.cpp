// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>
#include <pliant/core/files.h>
#include <sys/stat.h>

#include "support/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

std::string repeated(std::string_view part, int count) {
    std::string text;
    for (int n = 0; n < count; ++n) text += part;
    return text;
}

TEST(CheckNesting, RefusesWhatParsersDoNotBear) {
    const struct {
        TextSyntax syntax;
        std::string text;
    } deep[] = {
        {TextSyntax::Toml, repeated("a.", 40'000) + "a = 1"},
        {TextSyntax::Toml, "[" + repeated("a.", 40'000) + "a]"},
        {TextSyntax::Toml, "[[" + repeated("a . ", 40'000) + "a]]"},
        {TextSyntax::Toml, repeated("\"a\".", 40) + "a = 1"},
        {TextSyntax::Toml, repeated("'a'.", 40) + "a = 1"},
        {TextSyntax::Toml, "a = " + repeated("[", 40'000)},
        {TextSyntax::Toml, "a = " + repeated("[\n", 70)},
        {TextSyntax::Toml, "a = " + repeated("{a = ", 40'000)},
        {TextSyntax::Toml, "a = " + repeated("{a = [", 33)},
        {TextSyntax::Toml, "x = {" + repeated("a.", 33) + "a = 1}"},
        {TextSyntax::Toml, "x = \"\\\"\" # [\n" + repeated("a.", 33) + "a = 1"},
        {TextSyntax::Toml, "x = '''\n''''' \n" + repeated("a.", 33) + "a = 1"},
        {TextSyntax::Toml, "x = '\\'\n" + repeated("a.", 33) + "a = 1"},
        {TextSyntax::Json, repeated("[", 5'000'000)},
        {TextSyntax::Json, "{\"a\\\"\": " + repeated("{\"a\": [", 40)},
    };
    for (const auto& d : deep) {
        const Status status = check_nesting(d.text, d.syntax);
        ASSERT_FALSE(status.ok()) << d.text.substr(0, 60);
        EXPECT_TRUE(status.error().message.starts_with("line ")) << status.error().message;
    }
    EXPECT_EQ(check_nesting("a = 1\nb = " + repeated("[", 65), TextSyntax::Toml).error().message,
              "line 2: expected lists and tables nested up to 64, found more");
}

TEST(CheckNesting, LetsPassWhatIsMeant) {
    const std::string brackets = repeated("[", 100), dots = repeated("a.", 100);
    const struct {
        TextSyntax syntax;
        std::string text;
    } flat[] = {
        {TextSyntax::Toml, ""},
        {TextSyntax::Toml, "a.b.c = [[1, 2], [3, 4.5]]\n" + repeated("[a.b]\nc.d = 1.5\n", 1000)},
        {TextSyntax::Toml, "x = [" + repeated("0.5, ", 1000) + "]"},
        {TextSyntax::Toml, "x = \"" + brackets + dots + "\\\"" + brackets + "\""},
        {TextSyntax::Toml, "x = '" + brackets + dots + "'"},
        {TextSyntax::Toml, "x = \"\"\"" + brackets + "\n\"\" \\\"\"\"" + brackets + "\"\"\"\n"},
        {TextSyntax::Toml, "x = '''" + brackets + "\n'' " + dots + "'''"},
        {TextSyntax::Toml, "# " + brackets + dots + "\nx = 1 # \" " + brackets},
        {TextSyntax::Toml, repeated("a = [1]\n", 1000)},
        {TextSyntax::Json, "[" + repeated("[1.5, 2.5], ", 1000) + "1]"},
        {TextSyntax::Json, "{\"" + brackets + "\\\"" + brackets + "\": 1}"},
        {TextSyntax::Json, repeated("[", 64)},
    };
    for (const auto& f : flat) {
        const Status status = check_nesting(f.text, f.syntax);
        EXPECT_TRUE(status.ok()) << f.text.substr(0, 60) << ": " << status.error().message;
    }
}

TEST(SmallFiles, AreRegularOnesOfUpToALength) {
    const test::TemporaryFolder folder;
    folder.write("good", "text");
    folder.write("long", std::string(2000, 'x'));
    fs::create_symlink("loop", folder / "loop");
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    const auto read = [](const fs::path& path) { return read_small_file(path, 1000, "a log"); };
    EXPECT_EQ(read(folder / "good").value(), "text");
    const struct {
        fs::path path;
        const char* expected;
    } refused[] = {
        {folder.path(), "is a folder, expected a log"},
        {folder / "none", "expected a log that can be read, found no file"},
        {folder / "good/x", "expected a log that can be read"},
        {folder / "loop", "expected a log that can be read (Too many levels"},
        {folder / std::string(300, 'x'), "expected a log that can be read (File name too long)"},
        {folder / "pipe", "is no regular file, expected a log"},
        {"/dev/zero", "is no regular file, expected a log"},
        {folder / "long", "expected a log of up to 0 MiB, found more"},
    };
    for (const auto& r : refused) {
        const auto text = read(r.path);
        ASSERT_FALSE(text.ok()) << r.path;
        EXPECT_EQ(text.error().message.find(r.path.string() + ": " + r.expected), 0u)
            << text.error().message;
    }
}

TEST(Messages, ShowNothingThatATerminalObeys) {
    EXPECT_EQ(shown("a\x1b]0;owned\a"), "a?]0;owned?");
    EXPECT_EQ(shown(std::string(100, 'x')), std::string(60, 'x') + "…");
    EXPECT_EQ(printable("ä – 体\U0001F600"), "ä – 体\U0001F600");
    EXPECT_EQ(printable("a\nb\tc\x7f\x1b[1m"), "a b c??[1m");
    EXPECT_EQ(printable("\xc2\x9b"
                        "1m\xe2\x80\xae\xe2\x81\xa6\xe2\x80\xa8"),
              "?1m???");
    EXPECT_EQ(printable("\xff\xc0\x80\xed\xa0\x80\xc3"), std::string(7, '?'));
    EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a?b");
    EXPECT_EQ(printable("aä", 2), "a…");
    EXPECT_EQ(printable("aä", 3), "aä");
    EXPECT_EQ(one_line("file: wrong"), "file: wrong");
    const std::string cut = one_line("begin " + repeated("ä", 1'000'000) + " end");
    EXPECT_LE(cut.size(), 400u);
    EXPECT_TRUE(cut.starts_with("begin ää") && cut.ends_with("ää end")) << cut;
    EXPECT_EQ(cut.find('?'), std::string::npos);
}

}  // namespace
}  // namespace pliant
