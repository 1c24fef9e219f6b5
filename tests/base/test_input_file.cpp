// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/input_file.h"

#include <gtest/gtest.h>
#include <pliant/core/files.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

/// A regular file that can be opened, and whose reading fails.
constexpr const char* kFailing = "/proc/self/mem";

std::string said(const Status& status) {
    return status.ok() ? "" : status.error().message;
}

TEST(InputFile, GivesTheBytesInAnyOrder) {
    const TemporaryFolder folder;
    constexpr int kSeed = 1;
    SCOPED_TRACE(kSeed);
    Random random(kSeed);
    std::string bytes(100'000, '\0');
    for (char& c : bytes) c = char(random.whole(0, 255));
    InputFile file(folder.write("f", bytes));
    EXPECT_EQ(file.size(), bytes.size());
    for (int n = 0; n < 300; ++n) {
        const auto at = std::size_t(random.whole(0, int(bytes.size()) + 10));
        if (random.whole(0, 3) > 0) file.seek(at);
        const auto from = std::size_t(std::min<std::uint64_t>(file.at(), bytes.size()));
        std::string piece(std::size_t(random.whole(0, n % 10 ? 40 : 40'000)), 'x');
        const std::string expected = bytes.substr(from, piece.size());
        piece.resize(file.read(piece.data(), piece.size()));
        ASSERT_EQ(piece, expected);
        const int next = file.get();
        const std::size_t behind = from + expected.size();
        ASSERT_EQ(next, behind < bytes.size() ? static_cast<unsigned char>(bytes[behind])
                                              : InputFile::kEnd);
    }
    EXPECT_EQ(said(file.status()), "");
    file.seek(99'990);
    EXPECT_EQ(*file.read_rest(10), bytes.substr(99'990));
    file.seek(0);
    EXPECT_FALSE(file.read_rest(99'999).ok());
    EXPECT_EQ(file.fault("ends early").message, (folder / "f").string() + ": ends early");
}

TEST(InputFile, TellsAnErrorFromTheEnd) {
    const std::string fault = std::string(kFailing) + ": can't be read (Input/output error)";
    InputFile file(kFailing);
    EXPECT_EQ(said(file.status()), "") << "it can be opened";
    EXPECT_EQ(file.get(), InputFile::kEnd);
    EXPECT_EQ(said(file.status()), fault);
    EXPECT_EQ(file.fault("ends early").message, fault);
    std::string piece(50'000, 'x');
    InputFile other(kFailing);
    EXPECT_EQ(other.read(piece.data(), piece.size()), 0u);
    EXPECT_EQ(said(other.status()), fault);
    EXPECT_EQ(other.read(piece.data(), 1), 0u) << "the first error stays";
    EXPECT_EQ(InputFile(kFailing).read_rest().error().message, fault);
    EXPECT_EQ(read_small_file(kFailing, 1 << 20, "a log").error().message, fault);
    // Files of /proc have no size.
    EXPECT_TRUE(InputFile("/proc/self/status").read_rest()->starts_with("Name:"));
}

TEST(InputFile, OpensRegularFilesOnly) {
    const TemporaryFolder folder;
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    for (const std::string& name : {(folder / "pipe").string(), folder.path().string(),
                                    std::string("/dev/zero"), std::string("/dev/tty")}) {
        InputFile file(name);
        EXPECT_FALSE(file.status().ok()) << name;
        EXPECT_EQ(file.get(), InputFile::kEnd);
    }
    EXPECT_EQ(said(InputFile(folder / "pipe").status()),
              (folder / "pipe").string() + ": is no regular file");
    EXPECT_EQ(said(InputFile(folder / "none").status()),
              (folder / "none").string() + ": can't be opened (No such file or directory)");
}

TEST(InputFile, FoldersAndKindsAreKnownOrAnError) {
    const TemporaryFolder folder;
    for (const char* name : {"b", "a", ".c"}) (void)folder.write(name, "x");
    EXPECT_EQ(*names_in(folder.path()), (std::vector<std::string>{".c", "a", "b"}));
    EXPECT_EQ(names_in(folder / "a").error().message,
              (folder / "a").string() + ": can't be listed (Not a directory)");
    EXPECT_FALSE(names_in(folder / "none").ok());
    EXPECT_EQ(*type_of(folder / "a"), fs::file_type::regular);
    EXPECT_EQ(*type_of(folder.path()), fs::file_type::directory);
    EXPECT_EQ(*type_of(folder / "none"), fs::file_type::not_found);
    fs::create_symlink("loop", folder / "loop");
    EXPECT_EQ(type_of(folder / "loop").error().message,
              (folder / "loop").string() + ": can't be read (Too many levels of symbolic links)");
    EXPECT_FALSE(type_of(folder / std::string(300, 'x')).ok());
}

}  // namespace
}  // namespace pliant::test
