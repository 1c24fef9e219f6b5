// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: base/descriptor.cpp.

#include "support/temporary_folder.h"

#include <pliant/core/files.h>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <thread>

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
    const test::TemporaryFolder folder;
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
    const test::TemporaryFolder folder;
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
    const test::TemporaryFolder folder;
    folder.write("a", "old");
    StagedFiles files;
    write(*files.stage(folder.path() / "a"), "new");
    ASSERT_TRUE(files.commit().ok());
    EXPECT_EQ(test::bytes_of(folder.path() / "a"), "new");
}

TEST(StagedFiles, TakeFilesBesideThemAlong) {
    const test::TemporaryFolder folder;
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
    const test::TemporaryFolder folder;
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
    const fs::path socket = folder.path() / "socket";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, socket.c_str(), sizeof address.sun_path - 1);
    const int made = ::socket(AF_UNIX, SOCK_STREAM, 0);
    ASSERT_EQ(::bind(made, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    refused(socket, "is no regular file");
    ::close(made);
    fs::create_symlink("loop", folder.path() / "loop");
    refused(folder.path() / "loop", "loop: can't be written (Too many levels");
    refused(folder.path() / std::string(300, 'x'), "can't be written (File name too long)");
    fs::permissions(folder.path() / "sub", fs::perms::owner_read | fs::perms::owner_exec);
    if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
    refused(folder.path() / "sub/a", "can't be written");
}

TEST(StagedFiles, PutEverythingBackWhenOneFails) {
    const test::TemporaryFolder folder;
    folder.write("a", "old");
    StagedFiles files;
    write(*files.stage(folder.path() / "a"), "new");
    write(*files.stage(folder.path() / "b"), "new");
    write(*files.stage(folder.path() / "c"), "new");
    folder.write("c/in the way", "old");
    const Status status = files.commit();
    ASSERT_FALSE(status.ok());
    EXPECT_TRUE(status.error().message.starts_with((folder.path() / "c").string()))
        << status.error().message;
    EXPECT_EQ(test::bytes_of(folder.path() / "a"), "old");
    EXPECT_FALSE(fs::exists(folder.path() / "b"));
    EXPECT_EQ(test::bytes_of(folder.path() / "c/in the way"), "old");
}

TEST(StagedFiles, AnOutputThatWasNotWrittenStopsAllOthers) {
    const test::TemporaryFolder folder;
    StagedFiles files;
    write(*files.stage(folder.path() / "a"), "new");
    (void)*files.stage(folder.path() / "c");  // and nothing is written there
    const Status status = files.commit();
    ASSERT_FALSE(status.ok());
    EXPECT_TRUE(status.error().message.starts_with((folder.path() / "c").string()))
        << status.error().message;
    EXPECT_FALSE(fs::exists(folder.path() / "a"));
    StagedFiles same;
    write(*same.stage(folder.path() / "d"), "one");
    write(*same.stage(folder.path() / "d"), "two");
    EXPECT_FALSE(same.commit().ok()) << "two outputs of one name";
    EXPECT_FALSE(fs::exists(folder.path() / "d"));
}

TEST(StagedFiles, FoldersAppearWithAllTheirFiles) {
    const test::TemporaryFolder folder;
    folder.write("there/1", "old");
    folder.write("there/kept", "kept");
    folder.write("file", "x");
    {
        StagedFiles files;
        write(*files.stage_folder(folder.path() / "new/in/it/") / "1", "new");
        EXPECT_EQ(entries(folder.path()), 3) << "one of them temporary";
    }
    EXPECT_EQ(entries(folder.path()), 2);
    StagedFiles files;
    const auto made = files.stage_folder(folder.path() / "new/in/it/");
    const auto there = files.stage_folder(folder.path() / "there");
    ASSERT_TRUE(made.ok() && there.ok());
    write(*made / "1", "new");
    write(*there / "1", "new");
    write(*there / "2", "new");
    // A writer that stages for itself finds that this has been done.
    StagedFiles inner;
    const auto nested = inner.stage(*there / "3");
    ASSERT_TRUE(nested.ok());
    EXPECT_EQ(*nested, *there / "3");
    write(*nested, "new");
    ASSERT_TRUE(inner.commit().ok());
    ASSERT_TRUE(files.commit().ok());
    EXPECT_EQ(test::bytes_of(folder.path() / "new/in/it/1"), "new");
    for (const char* name : {"there/1", "there/2", "there/3"})
        EXPECT_EQ(test::bytes_of(folder.path() / name), "new") << name;
    EXPECT_EQ(test::bytes_of(folder.path() / "there/kept"), "kept");
    EXPECT_EQ(entries(folder.path() / "there"), 4);
    for (const char* name : {"file", "file/a", "file/a/b", ""})
        EXPECT_FALSE(StagedFiles().stage_folder(*name ? folder.path() / name : fs::path()).ok())
            << name;
}

TEST(StagedFiles, LinksAreFollowed) {
    const test::TemporaryFolder folder;
    folder.write("real/a", "old");
    fs::create_symlink("real/a", folder.path() / "link");
    fs::create_symlink("link", folder.path() / "second");
    fs::create_symlink("real/b", folder.path() / "dangling");
    StagedFiles files;
    write(*files.stage(folder.path() / "second"), "new");
    write(*files.stage(folder.path() / "dangling"), "new");
    ASSERT_TRUE(files.commit().ok());
    EXPECT_EQ(test::bytes_of(folder.path() / "real/a"), "new");
    EXPECT_EQ(test::bytes_of(folder.path() / "real/b"), "new");
    for (const char* name : {"link", "second", "dangling"})
        EXPECT_TRUE(fs::is_symlink(folder.path() / name)) << name;
    EXPECT_EQ(entries(folder.path() / "real"), 2);
}

TEST(StagedFiles, StreamsAreWrittenAndStayWhatTheyAre) {
    const test::TemporaryFolder folder;
    const fs::path pipe = folder.path() / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    fs::create_symlink("pipe", folder.path() / "link");
    std::string read;
    std::thread reader([&] { read = test::bytes_of(pipe); });
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const std::string long_text(50'000, 'x');
    {
        StagedFiles files;
        write(*files.stage(folder.path() / "link"), long_text);
        write(*files.stage("/dev/fd/" + std::to_string(ends[1])), "two");
        write(*files.stage("/dev/null"), "three");
        write(*files.stage(folder.path() / "file"), "four");
        const Status done = files.commit();
        EXPECT_TRUE(done.ok()) << done.error().message;
    }
    reader.join();
    EXPECT_EQ(read, long_text);
    char text[8] = {};
    EXPECT_EQ(::read(ends[0], text, sizeof text), 3);
    EXPECT_EQ(std::string(text), "two");
    EXPECT_TRUE(fs::is_fifo(pipe));
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_EQ(entries(folder.path()), 3);
    // Where a stream can't be written, nothing is.
    StagedFiles files;
    write(*files.stage("/dev/full"), "one");
    write(*files.stage(folder.path() / "other"), "two");
    const Status full = files.commit();
    ASSERT_FALSE(full.ok());
    EXPECT_EQ(full.error().message, "/dev/full: can't be written (No space left on device)");
    EXPECT_FALSE(fs::exists(folder.path() / "other"));
    EXPECT_FALSE(StagedFiles().stage("/dev/fd/" + std::to_string(ends[0])).ok()) << "only read";
    for (const int end : ends) ::close(end);
    EXPECT_FALSE(StagedFiles().stage("/dev/fd/" + std::to_string(ends[1])).ok()) << "closed";
}

TEST(StagedFiles, MessagesNamePlaces) {
    EXPECT_EQ(about_targets("o/.pliant-out-Xa81Qe/12/a.nrrd: full"), "o/a.nrrd: full");
    EXPECT_EQ(about_targets(".pliant-out-Xa81Qe/0/a and .pliant-out-Xa81Qf/1/b"), "a and b");
    for (const char* other : {"a", "", ".pliant-out-", ".pliant-out-Xa81Qe", ".pliant-out-Xa81Qe/1",
                              ".pliant-out-Xa81Qe/before-0/a"})
        EXPECT_EQ(about_targets(other), other);
}

}  // namespace
}  // namespace pliant
