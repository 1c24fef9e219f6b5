// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// README's and the documents' command lines run as they stand, and their pushes show.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdio>

#include "documents/commands.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

/// README.md and docs/, relative to the repository.
std::vector<std::string> documents() {
    const fs::path root = PLIANT_SOURCE_DIR;
    std::vector<std::string> names{"README.md"};
    for (const auto& entry : fs::recursive_directory_iterator(root / "docs"))
        if (entry.path().extension() == ".md")
            names.push_back(fs::relative(entry.path(), root).string());
    std::sort(names.begin(), names.end());
    return names;
}

class CommandsOf : public ::testing::TestWithParam<std::string> {};

TEST_P(CommandsOf, DocumentsRunAndShowTheirPushes) {
    const CommandBlocks found = command_blocks(bytes_of(fs::path(PLIANT_SOURCE_DIR) / GetParam()));
    for (const std::string& fault : found.faults) ADD_FAILURE() << GetParam() << ":" << fault;
    bool any = false;
    for (const CommandBlock& block : found.blocks)
        if (block.exemption.empty())
            any = true;
        else
            std::printf("%s:%d: not run: %s\n", GetParam().c_str(), block.line,
                        block.exemption.c_str());
    if (!any) return;
    const TemporaryFolder folder;
    for (const std::string& fault : faults_of_run(folder.path(), found.blocks))
        ADD_FAILURE() << GetParam() << ":" << fault;
}

INSTANTIATE_TEST_SUITE_P(All, CommandsOf, ::testing::ValuesIn(documents()), [](const auto& made) {
    std::string name = made.param;
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
    return name;
});

TEST(CommandBlocks, RunUnlessAReasonIsGiven) {
    const CommandBlocks found = command_blocks(
        "text\n```sh\npliant info a.nrrd\n```\n<!-- not run: needs a browser -->\n```bash\n"
        "pliant serve a.nrrd\n```\n```cpp\nint n;\n```\n");
    EXPECT_TRUE(found.faults.empty());
    ASSERT_EQ(found.blocks.size(), 2u);
    EXPECT_EQ(found.blocks[0].line, 2);
    EXPECT_EQ(found.blocks[0].text, "pliant info a.nrrd\n");
    EXPECT_EQ(found.blocks[0].exemption, "");
    EXPECT_EQ(found.blocks[1].exemption, "needs a browser");
}

TEST(CommandBlocks, AreTheOnlyPlaceOfCommands) {
    for (const char* document :
         {"a\n```bash\npliant info a.nrrd\n```\n",                               // no reason
          "<!-- not run:  -->\n```bash\npliant info a.nrrd\n```\n",              // nor here
          "<!-- not run: slow -->\n```sh\npliant info a.nrrd\n```\n",            // but it would run
          "a\n\n    pliant info a.nrrd\n", "a\n```\npliant info a.nrrd\n```\n",  // hidden
          "a\n```console\npliant info a.nrrd\n```\n"})
        EXPECT_EQ(command_blocks(document).faults.size(), 1u) << document;
}

std::vector<std::string> faults_of(const std::string& commands) {
    const TemporaryFolder folder;
    return faults_of_run(folder.path(), {{7, commands, {}}, {9, "exit 3\n", "isn't run"}});
}

// A cube of 1000 HU; without the settings it counts as bone.
const std::string kCube =
    "pliant phantom cube --size 32 --out cube.nrrd\n"
    "printf '[material]\\nbone_threshold_hu = 3000\\n' >soft.toml\n";
const std::string kPush = "pliant deform cube.nrrd --push 0,-29.5,0:0,6,0 --tool sphere:8 ";

TEST(CommandsThatRun, ShowTheirPushes) {
    const std::string out = "--out a.nrrd --png a.png\n";
    EXPECT_EQ(faults_of(kCube + kPush + "--config soft.toml " + out), std::vector<std::string>());
    const std::vector<std::string> unseen{
        "a.nrrd: expected a visible change, found the voxels of cube.nrrd",
        "a.png: expected a visible change, found it before as after"};
    EXPECT_EQ(faults_of(kCube + kPush + out), unseen) << "a push that bone stops";
    EXPECT_EQ(faults_of(kCube + "pliant deform cube.nrrd --config soft.toml --tool sphere:8 " +
                        "--push 0,-29.5,0:0,0.01,0 " + out),
              unseen)
        << "a push of much less than a voxel";
}

TEST(CommandsThatRun, MakeAVolumeOfTheirOwn) {
    const auto faults =
        faults_of(kCube + kPush + "--config soft.toml --save-state a.plst --out a.nrrd\n" +
                  "pliant deform cube.nrrd --load-state a.plst --out b.nrrd\n");
    ASSERT_EQ(faults.size(), 1u);
    EXPECT_EQ(faults[0], "b.nrrd: expected a change of its own, found that of a.nrrd");
}

TEST(CommandsThatRun, NameTheBlockThatFails) {
    const auto faults = faults_of("pliant info missing.nrrd\n");
    ASSERT_EQ(faults.size(), 1u);
    EXPECT_TRUE(faults[0].starts_with("7: a command fails: pliant: missing.nrrd")) << faults[0];
}

}  // namespace
}  // namespace pliant::test
