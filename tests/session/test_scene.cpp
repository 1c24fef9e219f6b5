// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scene replays to the same state from a recording with any number of threads, and undoes
// everything.
// Covers: base/tool.cpp, protocol/messages_json.cpp, session/replay.cpp, session/save.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>
#include <pliant/serve.h>

#include <algorithm>
#include <string_view>
#include <variant>

#include "hub/client.h"
#include "hub/random_session.h"
#include "session/checkpoint.h"
#include "session/replay.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::serve {
namespace {

using test::TemporaryFolder;

TEST(Scene, DoesTheSameAgainWithAnyNumberOfThreads) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TaskArena arena(2);
        const auto scene = open_scene(arena);
        const auto records = play(*scene, random, 60);
        SharedState played;
        scene->describe(played);
        for (const int threads : {1, 4}) {
            const TaskArena other(threads);
            auto again = Scene::open(kCube, other);
            ASSERT_TRUE(again.ok());
            const Status status = replay_into(**again, records, Compare::All);
            ASSERT_TRUE(status.ok()) << status.error().message;
            EXPECT_EQ(hash_of(**again), hash_of(*scene));
            SharedState state;
            (*again)->describe(state);
            EXPECT_EQ(state_text(state), state_text(played));
        }
    }
}

TEST(Scene, TakesEverythingBackAndDoesItAgain) {
    for (const std::uint64_t seed : {11U, 12U, 13U}) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TaskArena arena(2);
        const auto scene = open_scene(arena);
        const auto describe = [&] {
            SharedState state;
            scene->describe(state);
            return std::tuple(hash_of(*scene), state.iso_hu, state.materials.offset,
                              state.materials.air_enabled);
        };
        const auto steps = [&] {
            SharedState state;
            scene->describe(state);
            return state.undo_steps;
        };
        for (int n = 0; n < 40; ++n) {
            scene->carry_out(1, random_action(*scene, random));
            for (int k = 0; k < 2 && scene->wants_sweep(); ++k) (void)scene->sweep();
        }
        scene->carry_out(1, RelaxCommand{false});
        scene->carry_out(1, LetGoCommand{});
        scene->carry_out(1, ResetCommand{});
        ASSERT_GT(steps(), 10);
        std::vector<std::tuple<std::uint64_t, double, double, bool>> states = {describe()};
        // The last one was made by open_scene.
        while (steps() > 1) {
            ASSERT_TRUE(scene->carry_out(2, UndoCommand{}).ok());
            states.push_back(describe());
        }
        EXPECT_EQ(scene->tissue().hash(), open_scene(arena)->tissue().hash());
        EXPECT_EQ(std::get<1>(states.back()), -500);
        while (states.size() > 1) {
            ASSERT_EQ(describe(), states.back());
            states.pop_back();
            ASSERT_TRUE(scene->carry_out(1, RedoCommand{}).ok());
        }
        EXPECT_EQ(describe(), states.back());
        EXPECT_EQ(scene->carry_out(1, RedoCommand{}).error_code, "nothing");
    }
}

TEST(Scene, TakesAStrokeForOneStep) {
    const TaskArena arena(1);
    const auto scene = open_scene(arena);
    const auto undo_steps = [&] {
        SharedState state;
        scene->describe(state);
        return state.undo_steps;
    };
    const int before = undo_steps();
    const std::uint64_t hash = hash_of(*scene);
    const PushCommand push{.push = {{0, 0, 0}, {0, 0.5, 0}, 4}, .stroke = 3};
    for (int n = 0; n < 5; ++n) EXPECT_TRUE(scene->carry_out(1, push).ok());
    EXPECT_EQ(undo_steps(), before + 1);
    PushCommand other = push;
    other.stroke = 4;
    scene->carry_out(1, other);
    EXPECT_EQ(undo_steps(), before + 2);
    scene->carry_out(2, other);
    EXPECT_EQ(undo_steps(), before + 3);
    for (int n = 0; n < 3; ++n) EXPECT_TRUE(scene->carry_out(1, UndoCommand{}).ok());
    EXPECT_EQ(hash_of(*scene), hash);
}

TEST(Scene, LetsOneClientHoldAtATime) {
    const TaskArena arena(1);
    const auto scene = open_scene(arena);
    EXPECT_EQ(scene->carry_out(1, DragCommand{{1, 0, 0}}).error_code, "not_holding");
    const GrabCommand grab{.position = {{0, 0, 0}, {0, 0, 0}, 4}};
    EXPECT_GT(scene->carry_out(1, grab).grabbed_elements.value_or(0), 0);
    EXPECT_TRUE(scene->has_contact(1));
    EXPECT_EQ(scene->carry_out(2, grab).error_code, "held_by_other");
    EXPECT_EQ(scene->carry_out(2, DragCommand{{1, 0, 0}}).error_code, "not_holding");
    const Outcome dragged = scene->carry_out(1, DragCommand{{0, 2, 0}});
    EXPECT_EQ(dragged.status, PushStatus::Applied);
    EXPECT_FALSE(dragged.force_n) << "pictures first";
    const auto felt = scene->measure_force();
    ASSERT_TRUE(felt);
    EXPECT_EQ(felt->client, 1u);
    EXPECT_LT(felt->energy_per_mm.y, 0) << "tissue pulls back";
    EXPECT_FALSE(scene->measure_force()) << "told once";
    // A released grab has no force.
    scene->carry_out(1, DragCommand{{0, 2.5, 0}});
    scene->carry_out(1, LetGoCommand{});
    EXPECT_FALSE(scene->measure_force());
    ASSERT_GT(scene->carry_out(1, grab).grabbed_elements.value_or(0), 0);
    // What another client does to the tissue, or takes back, waits.
    const std::uint64_t held = hash_of(*scene);
    for (const Action& action :
         {Action(PushCommand{.push = {{5, 5, 5}, {0, 0.5, 0}, 2}}), Action(UndoCommand{}),
          Action(CarveCommand{{{0, 0, 0}, {0, 0, 0}, 3}}), Action(ResetCommand{}),
          Action(TissueCommand{})}) {
        const Outcome refused = scene->carry_out(2, action);
        EXPECT_EQ(refused.error_code, "held_by_other");
        EXPECT_NE(refused.message.find("client 1"), std::string::npos) << refused.message;
    }
    EXPECT_EQ(hash_of(*scene), held);
    EXPECT_TRUE(scene->carry_out(1, DragCommand{{0, 3, 0}}).ok());
    scene->carry_out(1, LetGoCommand{});
    EXPECT_TRUE(scene->carry_out(2, PushCommand{.push = {{5, 5, 5}, {0, 0.5, 0}, 2}}).ok());
}

TEST(Scene, StrokesThatAlternateAreOneStepOfBothClients) {
    const TaskArena arena(1);
    const auto scene = open_scene(arena);
    const auto undo_steps = [&] {
        SharedState state;
        scene->describe(state);
        return state.undo_steps;
    };
    const int before = undo_steps();
    const auto push = [&](std::uint32_t client, std::uint32_t stroke, double x) {
        EXPECT_TRUE(scene
                        ->carry_out(client, PushCommand{.push = {{x, 0, 0}, {0, 0.3, 0}, 4},
                                                        .stroke = stroke})
                        .ok());
    };
    push(1, 5, -6);
    scene->carry_out(1, ReleaseCommand{});
    const std::uint64_t alone = hash_of(*scene);
    for (int n = 0; n < 8; ++n) {
        push(1, 6, -6);
        push(2, 9, 6);
    }
    EXPECT_EQ(undo_steps(), before + 2) << "one before, and one of both";
    const std::uint64_t both = hash_of(*scene);
    // After one has lifted the tool, the other goes on, and the next stroke is another step.
    scene->carry_out(1, ReleaseCommand{});
    push(2, 9, 6);
    EXPECT_EQ(undo_steps(), before + 2);
    EXPECT_NE(hash_of(*scene), both);
    push(1, 7, -6);
    EXPECT_EQ(undo_steps(), before + 3);
    const std::uint64_t last = hash_of(*scene);
    const Outcome own = scene->carry_out(2, UndoCommand{});
    EXPECT_EQ(own.message, "push");
    EXPECT_EQ(own.whose, std::vector<std::uint32_t>{1}) << "it says whose";
    const Outcome joint = scene->carry_out(2, UndoCommand{});
    std::vector<std::uint32_t> people = joint.whose;
    std::sort(people.begin(), people.end());
    EXPECT_EQ(people, (std::vector<std::uint32_t>{1, 2}));
    EXPECT_EQ(hash_of(*scene), alone);
    EXPECT_EQ(undo_steps(), before + 1);
    scene->carry_out(1, RedoCommand{});
    scene->carry_out(1, RedoCommand{});
    EXPECT_EQ(hash_of(*scene), last);
}

TEST(Scene, TheWayBackBelongsToTheDrag) {
    const TaskArena arena(1);
    const auto scene = open_scene(arena);
    const std::uint64_t at_rest = hash_of(*scene);
    scene->carry_out(1, RelaxCommand{true});
    ASSERT_TRUE(scene->carry_out(1, GrabCommand{.position = {{0, 0, 0}, {0, 0, 0}, 4}}).ok());
    ASSERT_TRUE(scene->carry_out(1, DragCommand{{0, 2, 0}}).ok());
    scene->carry_out(1, LetGoCommand{});
    EXPECT_EQ(scene->carry_out(2, DragCommand{{0, 3, 0}}).error_code, "not_holding");
    for (int n = 0; n < 3; ++n) (void)scene->sweep();
    EXPECT_EQ(scene->carry_out(1, UndoCommand{}).message, "drag");
    EXPECT_EQ(hash_of(*scene), at_rest);
}

TEST(Scene, ToolsThatTouchNoTissueLeaveNoStep) {
    const TaskArena arena(1);
    const auto scene = open_scene(arena);
    SharedState before, after;
    scene->describe(before);
    const std::uint64_t at_rest = hash_of(*scene);
    const Vec3d outside{900, 0, 0};
    for (const Action& action :
         {Action(PushCommand{.push = {outside, {0, 1, 0}, 4}, .stroke = 3}),
          Action(CarveCommand{{outside, outside, 4}, 4}),
          Action(CutCommand{{{outside, outside + Vec3d{0, 9, 0}}, {9, 0, 0}}})})
        scene->carry_out(1, action);
    scene->describe(after);
    EXPECT_EQ(after.undo_steps, before.undo_steps);
    EXPECT_EQ(hash_of(*scene), at_rest);
}

TEST(Scene, AThresholdOfAnotherClientEndsNoGrab) {
    const TaskArena arena(1);
    const auto scene = open_scene(arena);
    const auto state = [&] {
        SharedState now;
        scene->describe(now);
        return now;
    };
    const std::uint64_t at_rest = hash_of(*scene);
    const int before = state().undo_steps;
    const GrabCommand grab{.position = {{0, 0, 0}, {0, 0, 0}, 4}};
    ASSERT_GT(scene->carry_out(1, grab).grabbed_elements.value_or(0), 0);
    ASSERT_TRUE(scene->carry_out(1, DragCommand{{0, 1, 0}}).ok());
    ASSERT_TRUE(scene->carry_out(2, IsoCommand{.iso_hu = 40, .stroke = 7}).ok());
    ASSERT_TRUE(scene->carry_out(2, IsoCommand{.iso_hu = 60, .stroke = 7}).ok());
    const Outcome dragged = scene->carry_out(1, DragCommand{{0, 2, 0}});
    EXPECT_TRUE(dragged.ok()) << dragged.message;
    EXPECT_TRUE(scene->has_contact(1));
    // A client that holds tissue lets go to set the threshold itself.
    ASSERT_TRUE(scene->carry_out(1, LetGoCommand{}).ok());
    EXPECT_EQ(state().undo_steps, before + 2);
    EXPECT_EQ(scene->carry_out(1, UndoCommand{}).message, "drag");
    EXPECT_EQ(hash_of(*scene), at_rest);
    EXPECT_EQ(state().iso_hu, 60);
    EXPECT_EQ(scene->carry_out(1, UndoCommand{}).message, "threshold");
    EXPECT_EQ(state().iso_hu, -500);
    ASSERT_TRUE(scene->carry_out(1, RedoCommand{}).ok());
    EXPECT_EQ(state().iso_hu, 60);
}

TEST(Scene, NamesWhatIsOutOfRange) {
    const TaskArena arena(1);
    const auto scene = open_scene(arena);
    const Outcome outcome = scene->carry_out(1, PushCommand{.push = {{900, 0, 0}, {0, 1, 0}, 4}});
    EXPECT_EQ(outcome.error_code, "out_of_range");
    EXPECT_FALSE(outcome.message.empty());
}

// Springs.

const TissueCommand kSprings{.choice = {.model = "springs",
                                        .nodes = 9,
                                        .springs = {.cell_mm = 8, .fixed_hu = 3000, .depth = 4},
                                        .given = {"fixed_hu"}}};

const TissueCommand kElastic{
    .choice = {.model = "elastic",
               .elastic = {{"moduli_kpa", std::vector<NumberPair>{{-900, 0}, {0, 5}}},
                           {"held_above_hu", 3000.0},
                           {"held_sides", std::vector<std::string>{"-x", "+y"}}}}};

/// Random pushes and drags of springs, with a change of the tissue here and there.
/// @param model  or of another model that moves by itself
std::vector<SessionRecord> play_springs(Scene& scene, Random& random, int count,
                                        const TissueCommand& model = kSprings) {
    std::vector<SessionRecord> records = {SessionCommand{9, soft()}};
    const auto carry_out = [&](const Action& action) {
        const auto client = std::uint32_t(random.whole(1, 2));
        records.push_back(SessionCommand{client, action, !scene.carry_out(client, action).ok()});
    };
    carry_out(model);
    for (int n = 0; n < count; ++n) {
        const int kind = random.whole(0, 24);
        if (kind == 0) carry_out(TissueCommand{});
        if (kind <= 1) carry_out(model);
        carry_out(kind == 2   ? Action(DepthCommand{random.whole(0, 6)})
                  : kind <= 4 ? Action(UndoCommand{})
                  : kind == 5 ? Action(RedoCommand{})
                              : random_action(scene, random));
        int sweeps = 0;
        for (; scene.wants_sweep() && sweeps < 3; ++sweeps) (void)scene.sweep();
        if (sweeps) records.push_back(SessionSweeps{sweeps});
        if (n % 10 > 0) continue;
        (void)scene.update();
        records.push_back(SessionMark{hash_volume(scene.deformed()), scene.tissue().hash()});
    }
    return records;
}

TEST(Springs, DoTheSameAgainWithAnyNumberOfThreads) {
    for (const std::uint64_t seed : {41U, 42U}) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const TaskArena arena(2);
        const auto scene = open_scene(arena);
        const auto records = play_springs(*scene, random, 50);
        for (const int threads : {1, 4}) {
            const TaskArena other(threads);
            auto again = Scene::open(kCube, other);
            ASSERT_TRUE(again.ok());
            const Status status = replay_into(**again, records, Compare::All);
            ASSERT_TRUE(status.ok()) << status.error().message;
            EXPECT_EQ(hash_of(**again), hash_of(*scene));
            SharedState state, played;
            (*again)->describe(state);
            scene->describe(played);
            EXPECT_EQ(state_text(state), state_text(played));
        }
    }
}

TEST(ElasticScan, DoesTheSameAgainFromItsLinesWithAnyNumberOfThreads) {
    constexpr std::uint64_t kSeed = 51;
    SCOPED_TRACE(kSeed);
    Random random(kSeed);
    const TaskArena arena(2);
    const auto scene = open_scene(arena);
    std::vector<SessionRecord> read;
    for (const SessionRecord& record : play_springs(*scene, random, 20, kElastic)) {
        auto line = parse_session_record(text_of(record));
        ASSERT_TRUE(line.ok()) << line.error().message;
        read.push_back(std::move(*line));
    }
    for (const int threads : {1, 4}) {
        const TaskArena other(threads);
        auto again = Scene::open(kCube, other);
        ASSERT_TRUE(again.ok());
        const Status status = replay_into(**again, read, Compare::All);
        ASSERT_TRUE(status.ok()) << status.error().message;
        EXPECT_EQ(hash_of(**again), hash_of(*scene));
    }
}

TEST(Springs, AreChosenPushedTakenBackAndLeft) {
    const TaskArena arena(2);
    const auto scene = open_scene(arena);
    const std::uint64_t at_rest = hash_volume(scene->deformed());
    const auto volume = [&] {
        (void)scene->update();
        return hash_volume(scene->deformed());
    };
    ASSERT_TRUE(scene->carry_out(1, PushCommand{.push = {{0, 0, 0}, {0, 2, 0}, 4}}).ok());
    const std::uint64_t pushed = hash_of(*scene);
    EXPECT_EQ(scene->carry_out(1, DepthCommand{4}).error_code, "other_tissue");
    TissueCommand wrong = kSprings;
    wrong.choice.springs.cell_mm = 99;
    EXPECT_EQ(scene->carry_out(1, wrong).error_code, "out_of_range");
    EXPECT_EQ(hash_of(*scene), pushed);
    // The other tissue's history is cleared, and its clients are informed.
    ASSERT_TRUE(scene->carry_out(1, kSprings).ok());
    EXPECT_FALSE(scene->update().value().boxes.empty());
    EXPECT_EQ(volume(), at_rest);
    EXPECT_EQ(scene->carry_out(1, UndoCommand{}).error_code, "nothing");
    for (const Action& action :
         {Action(CarveCommand{}), Action(soft()), Action(PushCommand{.slide = true})})
        EXPECT_EQ(scene->carry_out(1, action).error_code, "other_tissue");
    const Outcome outcome = scene->carry_out(1, PushCommand{.push = {{0, 0, 0}, {0, 3, 0}, 4}});
    ASSERT_TRUE(outcome.ok());
    ASSERT_TRUE(outcome.force_n.has_value());
    EXPECT_LT(outcome.force_n->y, 0);
    EXPECT_TRUE(scene->has_contact(1));
    for (int n = 0; n < 500 && scene->wants_sweep(); ++n) (void)scene->sweep();
    EXPECT_FALSE(scene->wants_sweep());
    const std::uint64_t held = volume();
    EXPECT_NE(held, at_rest);
    SharedState state;
    scene->describe(state);
    EXPECT_EQ(state.tissue.model, "springs");
    EXPECT_EQ(state.undo_steps, 2) << "a push, and what followed from it";
    const auto figure = [&](std::string_view name) {
        const auto found = std::find_if(state.figures.begin(), state.figures.end(),
                                        [&](const NamedValue& f) { return f.name == name; });
        return found == state.figures.end() ? SettingValue() : found->value;
    };
    EXPECT_GT(std::get<std::int64_t>(figure("active_nodes")), 8);
    EXPECT_EQ(std::get<std::vector<double>>(figure("nodes")).size(), 3u);
    // They are in the message by name, as whole numbers.
    EXPECT_NE(state_text(state).find(R"("active_nodes":)"), std::string::npos);
    EXPECT_EQ(state_text(state).find(R"("nodes":[2.0)"), std::string::npos);
    EXPECT_EQ(scene->carry_out(1, MaterialsCommand{{{"offset", 0.1}}}).error_code, "other_tissue");
    ASSERT_TRUE(scene->carry_out(1, UndoCommand{}).ok());
    ASSERT_TRUE(scene->carry_out(1, UndoCommand{}).ok());
    EXPECT_EQ(volume(), at_rest);
    ASSERT_TRUE(scene->carry_out(1, RedoCommand{}).ok());
    ASSERT_TRUE(scene->carry_out(1, RedoCommand{}).ok());
    EXPECT_EQ(volume(), held);
    ASSERT_TRUE(scene->carry_out(1, TissueCommand{}).ok());
    EXPECT_EQ(volume(), at_rest);
}

TEST(Springs, GoOnFromACheckpoint) {
    const TaskArena arena(2);
    TemporaryFolder folder;
    const auto scene = open_scene(arena);
    ASSERT_TRUE(scene->carry_out(1, kSprings).ok());
    ASSERT_TRUE(scene->carry_out(1, PushCommand{.push = {{0, 0, 0}, {0, 3, 1}, 4}}).ok());
    for (int n = 0; n < 5; ++n) (void)scene->sweep();
    ASSERT_TRUE(scene->carry_out(1, RelaxCommand{false}).ok());
    ASSERT_TRUE(scene->carry_out(1, ReleaseCommand{}).ok());
    ASSERT_TRUE(scene->is_quiet());
    Status saved = Ok{};
    const auto session = folder / "s.pls";
    SessionCheckpoint point = save_checkpoint(*scene, session, 1, saved).value();
    ASSERT_TRUE(saved.ok()) << saved.error().message;
    {
        auto log = SessionLog::create(session, {kCube, scene->scan_hash()});
        ASSERT_TRUE(log.ok());
        (*log)->add(point);
    }
    const auto file = read_session(session);
    ASSERT_TRUE(file.ok()) << file.error().message;
    EXPECT_EQ(std::get_if<SessionCheckpoint>(&file->records.back())->memo, point.memo);
    const auto again = open_scene(arena);
    const auto state = checkpoint_path(session, 1);
    const Status status = again->restore(state, point.memo);
    ASSERT_TRUE(status.ok()) << status.error().message;
    EXPECT_EQ(hash_of(*again), hash_of(*scene));
    EXPECT_NE(hash_volume(again->deformed()), hash_volume(open_scene(arena)->deformed()));
    for (Scene* each : {scene.get(), again.get()}) {
        each->carry_out(1, RelaxCommand{true});
        for (int n = 0; n < 7; ++n) (void)each->sweep();
        each->carry_out(2, PushCommand{.push = {{8, 0, 0}, {1, 2, 1}, 4}});
        for (int n = 0; n < 7; ++n) (void)each->sweep();
    }
    EXPECT_EQ(hash_of(*again), hash_of(*scene));
    // A state that is damaged, or of another lattice.
    SceneMemo other = point.memo;
    other.tissue.nodes = 5;
    EXPECT_FALSE(open_scene(arena)->restore(state, other).ok());
    std::string bytes = test::bytes_of(state);
    bytes[bytes.size() / 2] ^= 1;
    folder.write(state.filename().string(), bytes);
    EXPECT_FALSE(open_scene(arena)->restore(state, point.memo).ok());
}

TEST(Scene, LoadsAStateAndReplaysItsLoading) {
    const TaskArena arena(2);
    TemporaryFolder folder;
    const auto file = folder / "a.plst";
    for (const bool springs : {false, true}) {
        SCOPED_TRACE(springs);
        const auto scene = open_scene(arena);
        std::vector<SessionRecord> records;
        const auto carry_out = [&](const Action& action) {
            ASSERT_TRUE(scene->carry_out(1, action).ok());
            records.push_back(SessionCommand{1, action, false});
        };
        carry_out(soft());
        if (springs) carry_out(kSprings);
        carry_out(PushCommand{.push = {{0, 0, 0}, {0, 3, 1}, 4}});
        carry_out(ReleaseCommand{});
        ASSERT_TRUE(scene->tissue().save_state(file).ok());
        const std::uint64_t saved = hash_of(*scene);
        carry_out(PushCommand{.push = {{4, 0, 0}, {0, 1, 2}, 4}});
        ASSERT_NE(hash_of(*scene), saved);
        // A fault changes nothing: tissue is still held, and steps can be undone.
        const std::uint64_t before = hash_of(*scene);
        const std::string bytes = test::bytes_of(file);
        folder.write("damaged.plst", bytes.substr(0, bytes.size() - 1));
        EXPECT_FALSE(scene->load_state(folder / "damaged.plst").ok());
        EXPECT_EQ(hash_of(*scene), before);
        EXPECT_TRUE(scene->has_contact(1));
        ASSERT_TRUE(scene->load_state(file).ok());
        records.push_back(SessionState{file.string(), checksum_of(file).value()});
        EXPECT_EQ(hash_of(*scene), saved);
        EXPECT_FALSE(scene->has_contact(1));
        EXPECT_FALSE(scene->wants_sweep());
        EXPECT_EQ(scene->carry_out(1, UndoCommand{}).error_code, "nothing");
        carry_out(PushCommand{.push = {{0, 4, 0}, {1, 1, 0}, 4}});
        const auto again = open_scene(arena);
        const auto text = text_of(records[records.size() - 2]);
        const auto read = parse_session_record(text);
        ASSERT_TRUE(read.ok()) << text;
        EXPECT_EQ(text_of(*read), text);
        const Status status = replay_into(*again, records, Compare::Nothing);
        ASSERT_TRUE(status.ok()) << status.error().message;
        EXPECT_EQ(hash_of(*again), hash_of(*scene));
    }
}

TEST(SessionLog, IsReadAsItWasWrittenAndReplays) {
    const TaskArena arena(2);
    TemporaryFolder folder;
    const auto path = folder / "s.pls";
    Random random(21);
    const auto scene = open_scene(arena);
    const auto records = play(*scene, random, 30);
    {
        auto log = SessionLog::create(path, {kCube, scene->scan_hash()});
        ASSERT_TRUE(log.ok());
        for (const SessionRecord& record : records) (*log)->add(record);
        ASSERT_TRUE((*log)->flush().ok());
        EXPECT_FALSE(SessionLog::create(path, {kCube, 0}).ok());
        const auto half_way = read_session(path);
        ASSERT_TRUE(half_way.ok());
        EXPECT_FALSE(SessionLog::go_on(path, *half_way).ok()) << "it is open";
    }
    const auto file = read_session(path);
    ASSERT_TRUE(file.ok()) << file.error().message;
    EXPECT_EQ(file->header.source, kCube);
    ASSERT_EQ(file->records.size(), records.size());
    for (std::size_t n = 0; n < records.size(); ++n)
        EXPECT_EQ(text_of(file->records[n]), text_of(records[n]));
    const auto report = replay_session(path, arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->volume_hash ^ report->tissue_hash, hash_of(*scene));
    EXPECT_GE(report->marks, 3);
}

TEST(SessionLog, RemembersHowTheScanWasRead) {
    TemporaryFolder folder;
    int n = 0;
    for (const bool straighten : {false, true})
        for (const std::optional<std::int64_t> frame : {std::optional<std::int64_t>(), {7}}) {
            SceneSource source{.file = "/scan.nii", .series = "1.2"};
            source.frame = frame;
            source.straighten = straighten;
            if (straighten) source.spacing_mm = Vec3d{0.3, 0.4, 1};
            const auto path = folder / ("s" + std::to_string(n++) + ".pls");
            ASSERT_TRUE(SessionLog::create(path, {source, 1}).ok());
            const auto file = read_session(path);
            ASSERT_TRUE(file.ok()) << file.error().message;
            EXPECT_EQ(file->header.source, source);
            EXPECT_EQ(file->header.source.frame, frame);
            EXPECT_EQ(file->header.source.straighten, straighten);
        }
}

TEST(SessionLog, LosesOnlyTheLineThatWasNotFinished) {
    TemporaryFolder folder;
    const auto path = folder / "s.pls";
    {
        auto log = SessionLog::create(path, {kCube, 1});
        ASSERT_TRUE(log.ok());
        for (int n = 1; n <= 20; ++n) (*log)->add(SessionSweeps{n});
    }
    const std::string bytes = test::bytes_of(path);
    std::vector<std::size_t> ends;
    for (std::size_t n = 0; n < bytes.size(); ++n)
        if (bytes[n] == '\n') ends.push_back(n + 1);
    ASSERT_EQ(ends.size(), 21U);
    for (std::size_t size = ends[0]; size <= bytes.size(); ++size) {
        folder.write("s.pls", bytes.substr(0, size));
        const auto file = read_session(path);
        ASSERT_TRUE(file.ok()) << size << file.error().message;
        const auto whole =
            std::size_t(std::upper_bound(ends.begin(), ends.end(), size) - ends.begin());
        ASSERT_EQ(file->records.size(), whole - 1);
        EXPECT_EQ(file->cut_off_bytes, size - ends[whole - 1]);
        if (size % 7 != 0) continue;
        // It goes on from there, and is whole again.
        {
            auto log = SessionLog::go_on(path, *file);
            ASSERT_TRUE(log.ok());
            (*log)->add(SessionSweeps{99});
        }
        const auto again = read_session(path);
        ASSERT_TRUE(again.ok());
        EXPECT_EQ(again->cut_off_bytes, 0U);
        ASSERT_EQ(again->records.size(), whole);
        EXPECT_EQ(std::get_if<SessionSweeps>(&again->records.back())->count, 99);
    }
    for (std::size_t size = 0; size < ends[0]; ++size) {
        folder.write("s.pls", bytes.substr(0, size));
        EXPECT_FALSE(read_session(path).ok()) << size;
    }
}

TEST(SessionLog, FindsEveryByteThatWasChanged) {
    TemporaryFolder folder;
    const auto path = folder / "s.pls";
    {
        auto log = SessionLog::create(path, {kCube, 1});
        ASSERT_TRUE(log.ok());
        for (int n = 1; n <= 5; ++n) (*log)->add(SessionSweeps{n});
    }
    const std::string bytes = test::bytes_of(path);
    const std::size_t last_line = bytes.rfind('\n', bytes.size() - 2) + 1;
    for (std::size_t n = 0; n < bytes.size(); ++n) {
        std::string changed = bytes;
        changed[n] ^= 1;
        folder.write("s.pls", changed);
        const auto file = read_session(path);
        if (n + 1 < last_line) {
            ASSERT_FALSE(file.ok()) << n;
            EXPECT_NE(file.error().message.find("line"), std::string::npos);
        } else {
            ASSERT_TRUE(file.ok());
            // The end of the line before it makes one line of both.
            EXPECT_EQ(file->records.size(), n + 1 == last_line ? 3U : 4U);
        }
    }
    // A line that is missing.
    std::string shorter = bytes;
    const std::size_t second = bytes.find('\n') + 1;
    shorter.erase(second, bytes.find('\n', second) + 1 - second);
    folder.write("s.pls", shorter);
    EXPECT_FALSE(read_session(path).ok());
    EXPECT_EQ(read_session(folder / "none.pls").error().code, ErrorCode::NotFound);
}

// Data sent to a client, against a client that keeps everything.

TEST(Delivery, BringsEveryClientUpToDateHoweverItReadsAndComesBack) {
    for (const std::uint64_t seed : {31U, 32U, 33U, 34U}) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const Vec3i size{40, 30, 50};
        std::vector<int> truth(60'000), copy(60'000, -1);
        const auto for_each = [&](const Box3i& box, auto visit) {
            for (int k = box.begin.z; k < box.end.z; ++k)
                for (int j = box.begin.y; j < box.end.y; ++j)
                    for (int i = box.begin.x; i < box.end.x; ++i)
                        visit(std::size_t(i + size.x * (j + size.y * k)));
        };
        Delivery delivery(size);
        EXPECT_FALSE(delivery.come_back({}));
        struct Frame {
            Box3i box;
            std::vector<int> values;
            bool last;
            std::uint32_t step;
        };
        std::deque<Frame> on_the_way;
        std::deque<std::uint32_t> answers;
        std::optional<std::uint32_t> held;  // newest whole step of the client
        std::uint32_t step = 0;
        const auto deliver = [&](bool all) {
            while (!on_the_way.empty() && (all || random.whole(0, 3) > 0)) {
                const Frame& frame = on_the_way.front();
                std::size_t n = 0;
                for_each(frame.box, [&](std::size_t v) { copy[v] = frame.values[n++]; });
                if (frame.last) {
                    held = frame.step;
                    answers.push_back(frame.step);
                }
                on_the_way.pop_front();
            }
            while (!answers.empty() && (all || random.whole(0, 1) > 0)) {
                delivery.seen(answers.front());
                answers.pop_front();
            }
        };
        const auto send = [&] {
            if (!delivery.is_due() || !delivery.may_send()) return;
            const auto boxes = delivery.take(random.whole(1, 30'000), step, Clock::now());
            for (std::size_t n = 0; n < boxes.size(); ++n) {
                Frame frame{boxes[n], {}, !delivery.is_due() && n + 1 == boxes.size(), step};
                for_each(boxes[n], [&](std::size_t v) { frame.values.push_back(truth[v]); });
                on_the_way.push_back(std::move(frame));
            }
        };
        for (int round = 0; round < 400; ++round) {
            Box3i box;
            for (int a = 0; a < 3; ++a) {
                box.begin[a] = random.whole(0, size[a] - 1);
                box.end[a] = random.whole(box.begin[a], std::min(size[a], box.begin[a] + 12));
            }
            ++step;
            for_each(box, [&](std::size_t v) { truth[v] = int(step); });
            delivery.mark(box);
            send();
            deliver(false);
            if (random.whole(0, 25) == 0) {
                // The connection ends: data in flight is lost, in both directions.
                on_the_way.clear();
                answers.clear();
                const bool forgets = random.whole(0, 3) == 0;
                if (forgets) {
                    std::fill(copy.begin(), copy.end(), -1);
                    held.reset();
                }
                const bool goes_on = delivery.come_back(held);
                if (forgets) {
                    EXPECT_FALSE(goes_on);
                }
                if (!goes_on) std::fill(copy.begin(), copy.end(), -1);
            }
        }
        for (int n = 0; n < 1000 && (delivery.is_due() || !on_the_way.empty()); ++n) {
            send();
            deliver(true);
        }
        deliver(true);
        EXPECT_EQ(copy, truth);
        EXPECT_FALSE(delivery.unseen_since());
    }
}

TEST(Delivery, EverythingHasItsTurnWhereMoreChangesThanCanBeSent) {
    const Vec3i size{64, 64, 64};
    Delivery delivery(size);
    std::vector<int> sent(8 * 8 * 8, 0);
    constexpr int kSteps = 60;
    for (std::uint32_t step = 1; step <= kSteps; ++step) {
        delivery.mark(Box3i{{0, 0, 0}, size});
        for (const Box3i& box : delivery.take(64 * 64 * 64 / 6, step, Clock::now()))
            for (int z = box.begin.z / 8; z < box.end.z / 8; ++z)
                for (int y = box.begin.y / 8; y < box.end.y / 8; ++y)
                    for (int x = box.begin.x / 8; x < box.end.x / 8; ++x)
                        ++sent[std::size_t(x + 8 * (y + 8 * z))];
    }
    // A sixth each time, more or less.
    EXPECT_GE(*std::min_element(sent.begin(), sent.end()), kSteps / 12);
}

/// The value that the scene shows at a position.
float shown_at(Scene& scene, Vec3d position_mm) {
    (void)scene.update();
    return sample_linear(scene.deformed(), voxel_from_world(scene.deformed().grid, position_mm));
}

TEST(Scene, RelaxationKeepsOutOfAnEndoscopeThatOnlyLooks) {
    const TaskArena arena(2);
    for (const double radius_mm : {2.5, 0.3, 0.0}) {
        SCOPED_TRACE(radius_mm);
        auto opened = Scene::open({.phantom = "airway", .phantom_size = {64, 64, 64}}, arena);
        ASSERT_TRUE(opened.ok());
        Scene& scene = **opened;
        ASSERT_TRUE(scene.info().start.has_value());
        Vec3d wall = scene.info().start->eye_mm;
        ASSERT_LT(shown_at(scene, wall), -500);
        while (shown_at(scene, wall) < -500) wall.x += 0.1;
        const Push push{.point_mm = wall, .push_mm = {6, 0, 0}, .sphere_radius_mm = 4};
        ASSERT_TRUE(scene.carry_out(1, PushCommand{.push = push}).ok());
        ASSERT_TRUE(scene.carry_out(1, ReleaseCommand{}).ok());
        Vec3d eye = wall;
        while (shown_at(scene, eye) < -500) eye.x += 0.1;
        eye.x -= 0.2;
        ASSERT_GT(eye.x, wall.x + 0.5) << "in the dent";
        ASSERT_TRUE(scene.carry_out(1, EyeCommand{eye, radius_mm}).ok());
        ASSERT_TRUE(scene.carry_out(1, RelaxCommand{true}).ok());
        for (int n = 0; n < 20'000 && scene.wants_sweep(); ++n) (void)scene.sweep();
        ASSERT_FALSE(scene.wants_sweep());
        if (radius_mm > 0)
            EXPECT_LT(shown_at(scene, eye), -500);
        else
            EXPECT_GT(shown_at(scene, eye), -500) << "without an eye the dent closes";
    }
}

}  // namespace
}  // namespace pliant::serve
