// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Each change that was announced by has_room() is in the session's file, also where memory runs out
// between the change and the file.

#include "hub/recorder.h"

#include <gtest/gtest.h>

#include <utility>

#include "support/count_allocations.h"
#include "support/temporary_folder.h"

namespace pliant::serve {
namespace {

using test::FailingAllocation;

class RecorderTest : public ::testing::Test {
  protected:
    /// Numbers of the recorded states, in order.
    std::vector<std::uint64_t> numbers() const {
        const auto file = read_session(m_session);
        EXPECT_TRUE(file.ok());
        std::vector<std::uint64_t> numbers;
        if (!file.ok()) return numbers;
        for (const SessionRecord& record : file->records)
            if (const auto* state = std::get_if<SessionState>(&record))
                numbers.push_back(state->checksum);
        return numbers;
    }
    Recorder begin() {
        std::filesystem::remove(m_session);
        auto log = SessionLog::create(m_session, {{.phantom = "cube"}, 0});
        EXPECT_TRUE(log.ok());
        return Recorder(std::move(*log));
    }
    /// A long record.
    static SessionRecord state(std::uint64_t number) {
        return SessionState{std::string(4000, 's'), number};
    }

    const test::TemporaryFolder m_folder;
    const std::filesystem::path m_session = m_folder / "s.pls";
};

TEST_F(RecorderTest, ARecordIsKeptWhicheverAllocationOfTheWriteFails) {
    bool has_failed = true;
    int failures = 0;
    for (int n = 0; has_failed; ++n) {
        SCOPED_TRACE("allocation " + std::to_string(n));
        Recorder recorder = begin();
        std::vector<SessionRecord> records = {state(1), state(2), state(3)};
        ASSERT_TRUE(recorder.has_room());
        {
            const FailingAllocation failing(0);
            for (SessionRecord& record : records) recorder.note(std::move(record));
        }
        {
            // Destructors of nlohmann::json allocate a little, and end the process where they
            // can't.
            constexpr std::size_t kSmall = 1024;
            const FailingAllocation failing(n, kSmall);
            recorder.write();
            has_failed = failing.has_failed();
        }
        failures += has_failed;
        recorder.write();
        EXPECT_EQ(numbers(), (std::vector<std::uint64_t>{1, 2, 3}));
    }
    EXPECT_GT(failures, 2);
}

TEST_F(RecorderTest, HasNoRoomWithoutMemoryAndRoomAgainLater) {
    Recorder recorder = begin();
    std::uint64_t noted = 0;
    bool has_room = true;
    {
        ASSERT_TRUE(recorder.has_room());
        std::vector<SessionRecord> records;
        for (std::uint64_t n = 1; n <= 100; ++n) records.push_back(state(n));
        const FailingAllocation failing(0);
        while (has_room && noted < records.size()) {
            recorder.note(std::move(records[noted++]));
            has_room = recorder.has_room();
        }
    }
    EXPECT_FALSE(has_room);
    EXPECT_TRUE(recorder.has_room());
    recorder.note(state(++noted));
    recorder.write();
    EXPECT_EQ(numbers().size(), noted);
}

TEST_F(RecorderTest, WithoutALogThereIsRoomForEverything) {
    Recorder recorder(nullptr);
    EXPECT_TRUE(recorder.has_room());
    recorder.note(state(1));
    recorder.write();
    EXPECT_FALSE(recorder.is_recorded());
    EXPECT_FALSE(recorder.has_file());
    EXPECT_FALSE(recorder.part().ok());
}

}  // namespace
}  // namespace pliant::serve
