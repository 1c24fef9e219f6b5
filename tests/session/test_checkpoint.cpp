// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Sessions that go on from a saved state: the same as from the start, or from the start.
// Covers: session/session_log.cpp.

#include "session/checkpoint.h"

#include <gtest/gtest.h>
#include <pliant/serve.h>

#include "hub/client.h"
#include "hub/random_session.h"
#include "session/replay.h"
#include "support/temporary_folder.h"

namespace pliant::serve {
namespace {

using test::TemporaryFolder;

/// Releases both; relaxation is not completed.
void make_quiet(Scene& scene, std::vector<SessionRecord>& records) {
    const auto act = [&](std::uint32_t client, const Action& action) {
        const Outcome outcome = scene.carry_out(client, action);
        records.push_back(SessionCommand{client, action, !outcome.ok()});
    };
    act(1, ReleaseCommand{});
    act(2, ReleaseCommand{});
    if (scene.wants_sweep()) act(1, RelaxCommand{false});
}

std::string state_of(const Scene& scene) {
    SharedState state;
    scene.describe(state);
    return state_text(state);
}

class CheckpointTest : public ::testing::Test {
  protected:
    /// A session with checkpoints in it, in m_session and in m_records.
    /// @param steps_between  random ones, also undo beyond a checkpoint; 0: four pushes
    std::unique_ptr<Scene> record(Random& random, int checkpoints, int steps_between) {
        auto scene = Scene::open(kCube, m_arena);
        EXPECT_TRUE(scene.ok());
        m_records = {SessionCommand{9, soft(), false}};
        (*scene)->carry_out(9, soft());
        for (int n = 1; n <= checkpoints + 1; ++n) {
            if (steps_between > 0) play_on(**scene, random, steps_between);
            for (int k = 0; k < 4 && steps_between == 0; ++k) push_on(**scene, random);
            if (n > checkpoints) break;
            make_quiet(**scene, m_records);
            (void)(*scene)->update();
            Status saved = Ok{};
            m_records.push_back(save_checkpoint(**scene, m_session, n, saved).value());
            EXPECT_TRUE(saved.ok()) << saved.error().message;
        }
        write_session();
        return std::move(*scene);
    }
    void push_on(Scene& scene, Random& random) {
        const PushCommand push{.push = {random_place(scene, random), random.vector(4), 3}};
        const Outcome outcome = scene.carry_out(1, push);
        m_records.push_back(SessionCommand{1, push, !outcome.ok()});
    }
    void play_on(Scene& scene, Random& random, int count) {
        auto more = play(scene, random, count);
        m_records.insert(m_records.end(), more.begin() + 1, more.end());
    }
    void write_session() {
        std::filesystem::remove(m_session);
        auto scene = Scene::open(kCube, m_arena);
        auto log = SessionLog::create(m_session, {kCube, (*scene)->scan_hash()});
        ASSERT_TRUE(log.ok()) << log.error().message;
        for (const SessionRecord& record : m_records) (*log)->add(record);
    }
    Reopened reopened() {
        const auto file = read_session(m_session);
        EXPECT_TRUE(file.ok()) << file.error().message;
        auto again = reopen(*file, m_session, m_arena);
        EXPECT_TRUE(again.ok()) << again.error().message;
        return std::move(*again);
    }
    /// Replays from the start and checks each mark.
    std::unique_ptr<Scene> from_start() {
        auto scene = Scene::open(kCube, m_arena);
        const Status status = replay_into(**scene, m_records, Compare::All);
        EXPECT_TRUE(status.ok()) << status.error().message;
        return std::move(*scene);
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
    const std::filesystem::path m_session = m_folder / "s.pls";
    std::vector<SessionRecord> m_records;
};

TEST_F(CheckpointTest, GoingOnFromOneIsTheSameAsFromTheStart) {
    int from_one = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const auto scene = record(random, 1 + int(seed % 4), 12);
        const Reopened again = reopened();
        EXPECT_EQ(hash_of(*again.scene), hash_of(*scene));
        from_one += again.number > 0;
        if (again.number == 0) {
            EXPECT_EQ(state_of(*again.scene), state_of(*scene));
            continue;
        }
        // The one that goes on has lost the steps before, and its session says so.
        m_records.push_back(SessionForget{again.forgot});
        scene->forget_steps(again.forgot);
        EXPECT_EQ(state_of(*again.scene), state_of(*scene));
        const std::size_t before = m_records.size();
        play_on(*scene, random, 15);
        const Status status =
            replay_into(*again.scene, std::span(m_records).subspan(before), Compare::All);
        ASSERT_TRUE(status.ok()) << status.error().message;
        EXPECT_EQ(hash_of(*again.scene), hash_of(*scene));
        EXPECT_EQ(state_of(*again.scene), state_of(*scene));
        // All that is left can be undone in both, and the whole session says the same again.
        for (;;) {
            const bool undone = again.scene->carry_out(1, UndoCommand{}).ok();
            ASSERT_EQ(scene->carry_out(1, UndoCommand{}).ok(), undone);
            m_records.push_back(SessionCommand{1, UndoCommand{}, !undone});
            if (!undone) break;
        }
        EXPECT_EQ(hash_of(*again.scene), hash_of(*scene));
        EXPECT_EQ(hash_of(*from_start()), hash_of(*scene));
    }
    EXPECT_GE(from_one, 4) << "checkpoints are of use";
}

TEST_F(CheckpointTest, IsUsedOnlyWhereItsFileIsWholeAndTheOne) {
    const std::uint64_t seed = 77;
    SCOPED_TRACE(seed);
    Random random(seed);
    const auto scene = record(random, 2, 0);
    ASSERT_EQ(reopened().number, 1);
    const auto first = checkpoint_path(m_session, 1), second = checkpoint_path(m_session, 2);
    const std::string good = test::bytes_of(first), other = test::bytes_of(second);
    for (int n = 0; n < 25; ++n) {
        std::string bad = good;
        const auto at = std::size_t(random.whole(0, int(good.size()) - 1));
        if (n % 2)
            bad[at] = char(bad[at] ^ (1 << random.whole(0, 7)));
        else
            bad.resize(at);
        m_folder.write(first.filename().string(), n == 24 ? other : bad);
        const Reopened again = reopened();
        EXPECT_EQ(again.number, 2);
        ASSERT_EQ(again.notes.size(), 1U);
        EXPECT_EQ(again.notes[0].find('\n'), std::string::npos);
        EXPECT_EQ(hash_of(*again.scene), hash_of(*scene));
    }
    std::filesystem::remove(first);
    std::filesystem::remove(second);
    const Reopened again = reopened();
    EXPECT_EQ(again.number, 0);
    EXPECT_EQ(again.notes.size(), 2U);
    EXPECT_EQ(hash_of(*again.scene), hash_of(*scene));
    EXPECT_EQ(state_of(*again.scene), state_of(*scene));
}

TEST_F(CheckpointTest, ASessionThatEndsAnywhereOpensWithAllWholeLines) {
    const std::uint64_t seed = 78;
    SCOPED_TRACE(seed);
    Random random(seed);
    record(random, 3, 8);
    const std::string bytes = test::bytes_of(m_session);
    const std::size_t header = bytes.find('\n') + 1;
    const auto all = m_records;
    int from_one = 0;
    for (int n = 0; n < 12; ++n) {
        const auto end = std::size_t(random.whole(int(header), int(bytes.size())));
        m_folder.write("s.pls", bytes.substr(0, end));
        const auto file = read_session(m_session);
        ASSERT_TRUE(file.ok()) << file.error().message;
        const auto whole = std::count(bytes.begin(), bytes.begin() + std::ptrdiff_t(end), '\n') - 1;
        ASSERT_EQ(file->records.size(), std::size_t(whole));
        m_records.assign(all.begin(), all.begin() + whole);
        const Reopened again = reopened();
        from_one += again.number > 0;
        EXPECT_EQ(hash_of(*again.scene), hash_of(*from_start()));
    }
    EXPECT_GE(from_one, 1);
}

TEST_F(CheckpointTest, AServerRefusesANegativeTimeBetweenThem) {
    ServerSettings settings{.phantom_size = {32, 32, 32}, .session = m_session, .checkpoint_s = -1};
    EXPECT_FALSE(Server::start(settings, m_arena).ok());
}

}  // namespace
}  // namespace pliant::serve
