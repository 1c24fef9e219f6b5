// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Documents and types that are made from the rows of settings are as the rows say. With
// PLIANT_WRITE_SETTINGS in the environment, as `./dev settings` has it, they are written anew.
// Covers: protocol/record_json.cpp, protocol/wire_rows.cpp.

#include <gtest/gtest.h>
#include <pliant/core/version.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string_view>

#include "protocol/settings_files.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

constexpr auto kSettings = "docs/reference/settings.md", kProtocol = "docs/developers/protocol.md";

std::string text_in(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void expect_text(const char* name, const std::string& expected) {
    const fs::path path = fs::path(PLIANT_SOURCE_DIR) / name;
    if (std::getenv("PLIANT_WRITE_SETTINGS")) std::ofstream(path, std::ios::binary) << expected;
    EXPECT_EQ(text_in(path), expected) << name << ": run ./dev settings";
}

TEST(SettingsFiles, DocumentsHaveTheTablesOfTheRows) {
    std::set<std::string> placed;
    for (const char* name : {"docs/method/chainmail.md", "docs/method/fem.md", "docs/method/fit.md",
                             "docs/method/pbd.md", kProtocol, kSettings, "docs/method/springs.md",
                             "docs/reference/materials.md", "docs/howto/vessel.md"}) {
        const std::string text = text_in(fs::path(PLIANT_SOURCE_DIR) / name);
        ASSERT_FALSE(text.empty()) << name;
        if (name == std::string_view(kSettings) || name == std::string_view(kProtocol))
            for (const auto& [table, rows] : settings_tables())
                if (text.find("<!-- settings: " + table + " -->\n") != text.npos)
                    placed.insert(table);
        expect_text(name, with_tables(text));
    }
    for (const auto& [table, rows] : settings_tables())
        EXPECT_TRUE(placed.contains(table)) << table << ": expected in " << kSettings << ", or in "
                                            << kProtocol << " for a message";
}

TEST(SettingsFiles, TablesAreMadeOfAllRows) {
    const fs::path root = PLIANT_SOURCE_DIR;
    std::vector<fs::path> headers{root / "src/serve/protocol/wire_rows.h"};
    for (const auto& entry : fs::recursive_directory_iterator(root / "include/pliant"))
        if (entry.is_regular_file()) headers.push_back(entry.path());
    const std::string tables = text_in(root / "tests/protocol/settings_files.cpp");
    const std::regex declaration("\nSettingRows<\\w+> (\\w+_rows\\(\\)) noexcept;");
    std::size_t count = 0;
    for (const fs::path& header : headers) {
        const std::string text = text_in(header);
        for (std::sregex_iterator at(text.begin(), text.end(), declaration), end; at != end; ++at) {
            ++count;
            EXPECT_NE(tables.find((*at)[1].str()), tables.npos)
                << header.filename() << ": expected a table of " << (*at)[1];
        }
    }
    EXPECT_GT(count, 20u);
}

TEST(SettingsFiles, ThePagesTypesAreThoseOfTheRows) {
    expect_text("viewer/src/net/settings.ts", settings_types());
}

TEST(SettingsFiles, AllFilesNameTheSameVersion) {
    const std::string version = PLIANT_VERSION;
    EXPECT_EQ(version, std::to_string(PLIANT_VERSION_MAJOR) + "." +
                           std::to_string(PLIANT_VERSION_MINOR) + "." +
                           std::to_string(PLIANT_VERSION_PATCH));
    for (const auto& [name, words] : std::map<const char*, std::string>{
             {"CITATION.cff", "\nversion: " + version + "\n"},
             {"viewer/package.json", "\"" + version + "\""},
             {"codemeta.json", "\"" + version + "\""},
             {"packaging/vcpkg/pliant/vcpkg.json", "\"" + version + "\""},
             {"packaging/conda/recipe.yaml", "version: \"" + version + "\""},
             {"packaging/homebrew/pliant.rb", "version \"" + version + "\""},
             {"CHANGELOG.md", "\n## [" + version + "]"}})
        EXPECT_NE(text_in(fs::path(PLIANT_SOURCE_DIR) / name).find(words), std::string::npos)
            << name << ": expected version " << version;
}

TEST(SettingsFiles, EveryRowSaysItsMeaning) {
    ASSERT_GT(settings_tables().size(), 10u);
    for (const auto& [name, table] : settings_tables())
        EXPECT_EQ(table.find("|  |\n"), table.npos) << name;
}

TEST(SettingsFiles, TextsBetweenMarksAreReplacedAndNoOthers) {
    const std::string document =
        "a\n<!-- settings: iso -->\nstale\n<!-- end -->\nb\n<!-- settings: other -->\nc\n"
        "<!-- end -->\n";
    const std::string made = with_tables(document);
    EXPECT_EQ(made.find("stale"), made.npos);
    EXPECT_NE(made.find("`iso_hu`"), made.npos);
    EXPECT_TRUE(made.ends_with("b\n<!-- settings: other -->\nc\n<!-- end -->\n"));
    EXPECT_EQ(with_tables(made), made);
}

}  // namespace
}  // namespace pliant::test
