// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>
#include <pliant/core/files.h>
#include <pliant/core/output_file.h>

#include <string>

#include "support/temporary_folder.h"

namespace pliant {
namespace {

TEST(OutputFile, HasThePiecesOfAnySizeInTheirOrder) {
    const test::TemporaryFolder folder;
    const std::string path = folder / "text";
    std::string whole;
    OutputFile file(path);
    ASSERT_TRUE(file.status());
    for (const std::size_t size : {1u, 65535u, 2u, 65536u, 200000u, 0u, 3u}) {
        const std::string piece(size, char('a' + whole.size() % 26));
        whole += piece;
        file.write(piece);
    }
    ASSERT_TRUE(file.close());
    EXPECT_EQ(*read_small_file(path, kMaxSmallFileBytes, "a text"), whole);
}

TEST(OutputFile, SaysWhyItCantBeOpened) {
    const test::TemporaryFolder folder;
    OutputFile file(folder.path());
    EXPECT_FALSE(file.status());
    file.write("text");
    const Status closed = file.close();
    ASSERT_FALSE(closed);
    EXPECT_EQ(closed.error().code, ErrorCode::Unwritable);
    EXPECT_EQ(closed.error().message,
              folder.path().string() + ": can't be written (Is a directory)");
}

TEST(OutputFile, SaysThatTheDiskIsFullUnderItsName) {
    for (const std::size_t size : {1u, 100000u}) {
        OutputFile file("/dev/full", "scan.nrrd");
        file.write(std::string(size, 'x'));
        const Status closed = file.close();
        ASSERT_FALSE(closed);
        EXPECT_EQ(closed.error().message, "scan.nrrd: can't be written (No space left on device)");
    }
}

}  // namespace
}  // namespace pliant
