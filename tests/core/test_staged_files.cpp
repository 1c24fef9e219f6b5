// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "support/temp_folder.h"

#include <pliant/staged_files.h>

#include <gtest/gtest.h>
#include <unistd.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

auto entries(const fs::path& folder) {
    return std::distance(fs::directory_iterator(folder), {});
}

TEST(StagedFiles, AppearTogetherAtTheCommit) {
    const test::TempFolder folder;
    const fs::path a = folder.path() / "a", b = folder.path() / "b";
    StagedFiles files;
    const auto staged_a = files.stage(a), staged_b = files.stage(b);
    ASSERT_TRUE(staged_a.ok() && staged_b.ok());
    EXPECT_EQ(staged_a->filename(), "a");
    write(*staged_a, "one");
    write(*staged_b, "two");
    EXPECT_FALSE(fs::exists(a) || fs::exists(b));
    ASSERT_TRUE(files.commit().ok());
    EXPECT_EQ(test::bytes_of(a), "one");
    EXPECT_EQ(test::bytes_of(b), "two");
    EXPECT_EQ(entries(folder.path()), 2);
}

TEST(StagedFiles, LeaveNothingBehindWithoutACommit) {
    const test::TempFolder folder;
    folder.write("a", "old");
    {
        StagedFiles files;
        const auto staged = files.stage(folder.path() / "a");
        ASSERT_TRUE(staged.ok());
        write(*staged, "new");
    }
    EXPECT_EQ(test::bytes_of(folder.path() / "a"), "old");
    EXPECT_EQ(entries(folder.path()), 1);
}

TEST(StagedFiles, ReplaceWhatWasThere) {
    const test::TempFolder folder;
    folder.write("a", "old");
    StagedFiles files;
    write(*files.stage(folder.path() / "a"), "new");
    ASSERT_TRUE(files.commit().ok());
    EXPECT_EQ(test::bytes_of(folder.path() / "a"), "new");
}

TEST(StagedFiles, TakeFilesBesideThemAlong) {
    const test::TempFolder folder;
    StagedFiles files;
    const auto header = files.stage(folder.path() / "a.nhdr");
    write(*header, "header");
    write(header->parent_path() / "a.raw", "data");
    ASSERT_TRUE(files.commit().ok());
    EXPECT_EQ(test::bytes_of(folder.path() / "a.nhdr"), "header");
    EXPECT_EQ(test::bytes_of(folder.path() / "a.raw"), "data");
    EXPECT_EQ(entries(folder.path()), 2);
}

TEST(StagedFiles, RefusePlacesThatCannotBeWritten) {
    const test::TempFolder folder;
    fs::create_directory(folder.path() / "sub");
    folder.write("file", "x");
    const auto refused = [](const fs::path& path, const char* expected) {
        StagedFiles files;
        const auto staged = files.stage(path);
        ASSERT_FALSE(staged.ok()) << path;
        EXPECT_EQ(staged.error().code, ErrorCode::Unwritable);
        EXPECT_NE(staged.error().message.find(expected), std::string::npos)
            << staged.error().message;
    };
    refused(folder.path() / "gone/a", "does not exist");
    refused(folder.path() / "file/a", "does not exist");
    refused(folder.path() / "sub", "is a folder");
    refused(folder.path() / "sub/", "expected a file name");
    refused("/dev/null", "is no regular file");
    fs::permissions(folder.path() / "sub", fs::perms::owner_read | fs::perms::owner_exec);
    if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
    refused(folder.path() / "sub/a", "can't be written");
}

TEST(StagedFiles, PutEverythingBackWhenOneFails) {
    const test::TempFolder folder;
    folder.write("a", "old");
    StagedFiles files;
    write(*files.stage(folder.path() / "a"), "new");
    write(*files.stage(folder.path() / "b"), "new");
    (void)*files.stage(folder.path() / "c");  // and nothing is written there
    const Status status = files.commit();
    ASSERT_FALSE(status.ok());
    EXPECT_TRUE(status.error().message.starts_with((folder.path() / "c").string()))
        << status.error().message;
    EXPECT_EQ(test::bytes_of(folder.path() / "a"), "old");
    EXPECT_FALSE(fs::exists(folder.path() / "b"));
}

}  // namespace
}  // namespace pliant
