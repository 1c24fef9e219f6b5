// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A vessel as the server's tissue: equal to the catheter alone, equal in a replay, and correctly
// sent to clients.
// Covers: hub/vessel_*.cpp, tissue/vessel_tissue.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>
#include <pliant/models/drivable.h>
#include <pliant/models/scene_files.h>
#include <pliant/resample.h>
#include <pliant/serve.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <set>

#include "base/byte_order.h"
#include "hub/test_client.h"
#include "hub/vessel_frames.h"
#include "protocol/half.h"
#include "session/checkpoint.h"
#include "session/replay.h"
#include "session/scene.h"
#include "session/session_log.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::serve {
namespace {

using test::Json;
using test::Random;
using test::TemporaryFolder;
using test::TestClient;

/// A stiff wire in a soft bend: it moves the wall on its way, in boxes of few elements.
const char* kFile =
    "[vessel]\nphantom = \"bend\"\nthickness_mm = 1.5\nlayers = 1\n"
    "[wall]\nsupport_pa_per_mm = 2000\n"
    "[catheter]\nlength_mm = 150\nbend_n_mm2 = 200\ntip_bend_n_mm2 = 100\n"
    "[entry]\nplace_mm = [0, 0, 45]\ndirection = [0, 0, 1]\ninserted_mm = 27\n";

class VesselScene : public ::testing::Test {
  protected:
    VesselScene() : m_source{.file = m_folder.write("bend.toml", kFile).string()} {}

    std::unique_ptr<Scene> open(const TaskArena& arena) const {
        auto scene = Scene::open(m_source, arena);
        EXPECT_TRUE(scene.ok()) << scene.error().message;
        return scene.ok() ? std::move(*scene) : nullptr;
    }
    static Outcome drive(Scene& scene, double insert_mm_s, std::uint32_t client = 1) {
        return scene.carry_out(client, DriveCommand{.insert_mm_s = insert_mm_s});
    }

    TemporaryFolder m_folder;
    SceneSource m_source;
    const TaskArena m_arena{2};
};

TEST_F(VesselScene, IsWhatTheCatheterAloneDoes) {
    const auto scene = open(m_arena);
    ASSERT_TRUE(scene && scene->tissue().drivable());
    const MadeVessel& made = *scene->loaded()->vessel;
    auto twin = CatheterScene::create(made.wall, made.settings);
    ASSERT_TRUE(twin.ok());
    const std::uint64_t rest = hash_volume(scene->deformed());
    EXPECT_EQ(rest, hash_volume(scene->loaded()->volume));
    EXPECT_FALSE(scene->wants_sweep());
    EXPECT_TRUE(drive(*scene, 100).ok());
    ASSERT_TRUE(twin->command({.insert_mm_s = 100}).ok());
    constexpr int kSweeps = 60;  // of two steps each
    for (int n = 0; n < kSweeps; ++n) {
        ASSERT_TRUE(scene->wants_sweep());
        (void)scene->sweep();
    }
    ASSERT_TRUE(twin->step(kSweeps * 2, m_arena).ok());
    EXPECT_EQ(scene->tissue().hash(), twin->hash());
    SharedState state;
    scene->describe(state);
    ASSERT_TRUE(state.vessel);
    EXPECT_NEAR(state.vessel->measures.inserted_mm, 27 + 12, 1e-9);
    EXPECT_NEAR(state.vessel->measures.wall_moved_mm, twin->measures().wall_moved_mm, 1e-9);
    EXPECT_GT(state.vessel->measures.wall_moved_mm, 0.05);
    EXPECT_EQ(state.undo_steps, 1);
    EXPECT_EQ(state.next_undo, "catheter");
    // The scan goes where the wall goes, and nowhere else.
    auto carried = CarriedScan::create(scene->loaded()->volume, made.wall.mesh, {}, m_arena);
    ASSERT_TRUE(carried.ok());
    ASSERT_TRUE(carried->update(twin->wall_positions()).ok());
    const LiveUpdate update = scene->update().value();
    EXPECT_FALSE(update.boxes.empty());
    EXPECT_EQ(hash_volume(scene->deformed()),
              hash_volume(deform_volume(carried->scan()).value().volume));
    EXPECT_NE(hash_volume(scene->deformed()), rest);
    // And back.
    EXPECT_TRUE(scene->carry_out(1, ResetCommand{}).ok());
    (void)scene->update();
    EXPECT_EQ(hash_volume(scene->deformed()), rest);
    EXPECT_EQ(scene->tissue().hash(), open(m_arena)->tissue().hash());
}

// Sessions are replayed only with the wall that they were recorded with.
TEST_F(VesselScene, EachWallHasItsOwnHash) {
    std::set<std::uint64_t> hashes{open(m_arena)->scan_hash()};
    std::size_t count = 1;
    for (const std::string change :
         {"model = \"distances\"", "model = \"distances\"\nbend_stiffness = 0.1",
          "gravity_mm_s2 = [0, 0, 1]", "gravity_mm_s2 = [0, 1, 0]"}) {
        std::string file = kFile;
        file.insert(file.find("[wall]\n") + 7, change + "\n");
        SceneSource source{.file = m_folder.write("other.toml", file).string()};
        auto scene = Scene::open(source, m_arena);
        ASSERT_TRUE(scene.ok()) << scene.error().message;
        hashes.insert((*scene)->scan_hash());
        EXPECT_EQ(hashes.size(), ++count) << change;
    }
}

TEST_F(VesselScene, ItsRestFieldFollowsTheWall) {
    const auto scene = open(m_arena);
    ASSERT_TRUE(scene->update().ok());
    ASSERT_TRUE(scene->keep_sources(true));
    RestField field(scene->info().grid);
    // A catheter that is in the vessel from the start has moved the wall already.
    const std::vector<Box3i> all{voxel_box(field.grid())};
    ASSERT_TRUE(field.update(scene->live(), all).ok());
    const std::vector<std::uint16_t> start(field.halves().begin(), field.halves().end());
    const auto expect_as_made_at_once = [&] {
        ASSERT_TRUE(field.update(scene->live(), scene->update().value().boxes).ok());
        const Deformed once = deform_volume(scene->tissue(), Mapping::Cells, true).value();
        const RestField expected = RestField::create(scene->tissue(), once).value();
        ASSERT_EQ(field.at_rest(), expected.at_rest());
        EXPECT_TRUE(std::equal(field.halves().begin(), field.halves().end(),
                               expected.halves().begin(), expected.halves().end()));
    };
    drive(*scene, 100);
    for (int step = 0; step < 4; ++step) {
        for (int n = 0; n < 15; ++n) (void)scene->sweep();
        expect_as_made_at_once();
    }
    EXPECT_FALSE(field.at_rest());
    // Where the wall has gone, the tissue has been elsewhere, but is whole.
    float farthest = 0, raw = 0;
    for (std::size_t n = 0; n < field.halves().size(); n += 4) {
        for (std::size_t a = 0; a < 3; ++a)
            farthest = std::max(farthest, std::abs(float_from_half(field.halves()[n + a])));
        raw = std::max(raw, float_from_half(field.halves()[n + 3]));
    }
    EXPECT_GT(farthest, 0.02F);
    EXPECT_EQ(raw, 0);
    EXPECT_TRUE(scene->carry_out(1, ResetCommand{}).ok());
    expect_as_made_at_once();
    EXPECT_TRUE(
        std::equal(start.begin(), start.end(), field.halves().begin(), field.halves().end()));
}

TEST_F(VesselScene, ComesToRestOnceNobodyDrives) {
    const auto scene = open(m_arena);
    drive(*scene, 80);
    for (int n = 0; n < 20; ++n) (void)scene->sweep();
    EXPECT_TRUE(scene->has_contact(1));
    EXPECT_FALSE(scene->has_contact(2));
    EXPECT_FALSE(scene->is_quiet());
    // A client that leaves lets go of it.
    EXPECT_TRUE(scene->carry_out(1, ReleaseCommand{}).ok());
    EXPECT_FALSE(scene->has_contact(1));
    int sweeps = 0;
    while (scene->wants_sweep() && sweeps < 2000) {
        (void)scene->sweep();
        ++sweeps;
    }
    EXPECT_LT(sweeps, 2000);
    SharedState state;
    scene->describe(state);
    EXPECT_NEAR(state.vessel->measures.inserted_mm, 27 + 80 * 0.04, 1e-9);
    EXPECT_TRUE(scene->is_quiet());
}

TEST_F(VesselScene, TakesBackOneDriveAfterTheOther) {
    const auto scene = open(m_arena);
    const auto rest = [&] {
        drive(*scene, 0);
        for (int n = 0; n < 2000 && scene->wants_sweep(); ++n) (void)scene->sweep();
    };
    const auto inserted = [&] { return scene->tissue().drivable()->measures().inserted_mm; };
    std::vector<std::uint64_t> hashes{scene->tissue().hash()};
    std::vector<double> ways{inserted()};
    for (const double speed : {60.0, 90.0}) {
        drive(*scene, speed);
        for (int n = 0; n < 15; ++n) (void)scene->sweep();
        // More of the same drive: no step of its own.
        scene->carry_out(1, DriveCommand{.rotate_deg_s = 40, .bend_first_deg = speed});
        for (int n = 0; n < 5; ++n) (void)scene->sweep();
        scene->carry_out(1, DriveCommand{.insert_mm_s = 0, .rotate_deg_s = 0});
        rest();
        hashes.push_back(scene->tissue().hash());
        ways.push_back(inserted());
    }
    SharedState state;
    scene->describe(state);
    EXPECT_EQ(state.undo_steps, 2);
    EXPECT_NE(hashes[1], hashes[2]);
    EXPECT_TRUE(scene->carry_out(1, UndoCommand{}).ok());
    EXPECT_EQ(scene->tissue().hash(), hashes[1]);
    EXPECT_EQ(inserted(), ways[1]);
    EXPECT_EQ(scene->tissue().drivable()->hand().bend_first_deg, 60);
    EXPECT_FALSE(scene->wants_sweep());
    EXPECT_TRUE(scene->carry_out(1, UndoCommand{}).ok());
    EXPECT_EQ(scene->tissue().hash(), hashes[0]);
    (void)scene->update();
    EXPECT_EQ(hash_volume(scene->deformed()), hash_volume(scene->loaded()->volume));
    EXPECT_FALSE(scene->carry_out(1, UndoCommand{}).ok());
    EXPECT_TRUE(scene->carry_out(1, RedoCommand{}).ok());
    EXPECT_TRUE(scene->carry_out(1, RedoCommand{}).ok());
    EXPECT_EQ(scene->tissue().hash(), hashes[2]);
    // Taken back while it moves, it stands still.
    drive(*scene, 50);
    for (int n = 0; n < 3; ++n) (void)scene->sweep();
    EXPECT_TRUE(scene->carry_out(1, UndoCommand{}).ok());
    EXPECT_EQ(scene->tissue().hash(), hashes[2]);
    EXPECT_FALSE(scene->has_contact(1));
    EXPECT_FALSE(scene->wants_sweep());
}

// Continuing from a file equals continuing from the saved scene.
TEST_F(VesselScene, GoesOnFromACheckpoint) {
    const TaskArena one(1);
    const auto scene = open(m_arena), other = open(one);
    drive(*scene, 90);
    for (int n = 0; n < 20; ++n) (void)scene->sweep();
    drive(*scene, 0);
    for (int n = 0; n < 2000 && scene->wants_sweep(); ++n) (void)scene->sweep();
    ASSERT_TRUE(scene->is_quiet());
    const SceneMemo memo = scene->rest().value();
    const auto file = m_folder / "state";
    ASSERT_TRUE(scene->tissue().save_state(file).ok());
    ASSERT_TRUE(other->restore(file, memo).ok());
    EXPECT_EQ(other->tissue().hash(), scene->tissue().hash());
    for (Scene* at : {scene.get(), other.get()}) {
        drive(*at, -70);
        for (int n = 0; n < 15; ++n) (void)at->sweep();
        (void)at->update();
    }
    EXPECT_EQ(other->tissue().hash(), scene->tissue().hash());
    EXPECT_EQ(hash_volume(other->deformed()), hash_volume(scene->deformed()));
    // One that is cut short, or another's.
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 8);
    EXPECT_FALSE(other->restore(file, memo).ok());
    m_folder.write("state", "springs");
    EXPECT_FALSE(other->restore(file, memo).ok());
}

// A session with checkpoints is opened at one of them, and ends where all of it ends.
TEST_F(VesselScene, ASessionIsGoneOnWithFromItsCheckpoint) {
    const auto session = m_folder / "hand.session";
    const auto scene = open(m_arena);
    SessionFile file;
    file.scene = file.header = {m_source, scene->scan_hash()};
    const auto carry_out = [&](const Action& action) {
        file.records.push_back(SessionCommand{1, action, !scene->carry_out(1, action).ok()});
    };
    const auto sweep = [&](int most) {
        SessionSweeps sweeps;
        for (; sweeps.count < most && scene->wants_sweep(); ++sweeps.count) (void)scene->sweep();
        file.records.push_back(sweeps);
    };
    for (const int number : {1, 2}) {
        carry_out(DriveCommand{.insert_mm_s = 60.0 + number, .rotate_deg_s = 90});
        sweep(12);
        carry_out(DriveCommand{.insert_mm_s = 0, .rotate_deg_s = 0});
        sweep(2000);
        (void)scene->update();
        ASSERT_TRUE(scene->is_quiet());
        Status saved = Ok{};
        file.records.push_back(save_checkpoint(*scene, session, number, saved).value());
        EXPECT_TRUE(saved.ok()) << saved.error().message;
    }
    carry_out(UndoCommand{});
    carry_out(DriveCommand{.insert_mm_s = -40});
    sweep(10);
    // As it is read from its file.
    const auto write = [&] {
        std::filesystem::remove(session);
        auto log = SessionLog::create(session, file.header);
        ASSERT_TRUE(log.ok()) << log.error().message;
        for (const SessionRecord& record : file.records) (*log)->add(record);
        ASSERT_TRUE((*log)->flush().ok());
    };
    write();
    const auto read = read_session(session);
    ASSERT_TRUE(read.ok()) << read.error().message;
    const auto again = reopen(*read, session, m_arena);
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_EQ(again->number, 1);
    EXPECT_TRUE(again->notes.empty()) << again->notes.front();
    EXPECT_EQ(again->scene->tissue().hash(), scene->tissue().hash());
    const auto replayed = replay_session(session, m_arena);
    ASSERT_TRUE(replayed.ok()) << replayed.error().message;
    EXPECT_EQ(replayed->tissue_hash, scene->tissue().hash());
    // Without its checkpoints all of it is done again.
    for (const int number : {1, 2}) std::filesystem::remove(checkpoint_path(session, number));
    const auto from_start = reopen(*read, session, m_arena);
    ASSERT_TRUE(from_start.ok()) << from_start.error().message;
    EXPECT_EQ(from_start->number, 0);
    EXPECT_EQ(from_start->scene->tissue().hash(), scene->tissue().hash());
    // So is one that doesn't say that its tissue is a vessel, as older ones.
    for (SessionRecord& record : file.records)
        if (auto* point = std::get_if<SessionCheckpoint>(&record)) point->memo.tissue = {};
    write();
    EXPECT_TRUE(replay_session(session, m_arena).ok());
}

TEST_F(VesselScene, DoesTheSameAgainWithAnyNumberOfThreads) {
    constexpr std::uint64_t kSeed = 5;
    SCOPED_TRACE(kSeed);
    Random random(kSeed);
    const auto scene = open(m_arena);
    std::vector<SessionRecord> records;
    for (int n = 0; n < 12; ++n) {
        Action action = DriveCommand{.insert_mm_s = random.real(-20, 100)};
        if (n % 4 == 1)
            action = DriveCommand{.rotate_deg_s = random.real(-300, 300),
                                  .bend_first_deg = random.real(-90, 90),
                                  .bend_second_deg = random.real(-90, 90)};
        if (n == 5) action = ResetCommand{};
        if (n == 6) action = PushCommand{.push = {{0, 0, 0}, {1, 0, 0}, 3}};
        if (n == 7) action = IsoCommand{.iso_hu = 150};
        if (n == 8) action = UndoCommand{};
        if (n == 9) action = ReleaseCommand{};
        if (n == 10) action = UndoCommand{};
        if (n == 11) action = RedoCommand{};
        const Outcome outcome = scene->carry_out(1, action);
        records.push_back(SessionCommand{1, action, !outcome.ok()});
        int sweeps = 0;
        while (scene->wants_sweep() && sweeps < 4) {
            (void)scene->sweep();
            ++sweeps;
        }
        if (sweeps) records.push_back(SessionSweeps{sweeps});
        if (n % 4 != 3) continue;
        (void)scene->update();
        records.push_back(SessionMark{hash_volume(scene->deformed()), scene->tissue().hash()});
    }
    EXPECT_GT(scene->tissue().drivable()->measures().steps, 0);
    for (const int threads : {1, 4}) {
        const TaskArena other(threads);
        const auto again = open(other);
        const Status status = replay_into(*again, records, Compare::All);
        ASSERT_TRUE(status.ok()) << status.error().message;
    }
}

TEST_F(VesselScene, RefusesWhatAVesselCannotDo) {
    const auto scene = open(m_arena);
    const Push push{{0, 0, 0}, {1, 0, 0}, 3};
    EXPECT_EQ(scene->carry_out(1, PushCommand{.push = push}).error_code, "other_tissue");
    EXPECT_EQ(scene->carry_out(1, GrabCommand{.position = push}).error_code, "other_tissue");
    EXPECT_EQ(scene->carry_out(1, CarveCommand{}).error_code, "other_tissue");
    EXPECT_EQ(scene->carry_out(1, UndoCommand{}).error_code, "nothing");
    // The scan may be pushed as any other, and the vessel taken up again.
    drive(*scene, 100);
    for (int n = 0; n < 5; ++n) (void)scene->sweep();
    (void)scene->update();
    EXPECT_TRUE(scene->carry_out(1, TissueCommand{}).ok());
    EXPECT_EQ(scene->tissue().drivable(), nullptr);
    EXPECT_EQ(drive(*scene, 10).error_code, "other_tissue");
    (void)scene->update();
    EXPECT_EQ(hash_volume(scene->deformed()), hash_volume(scene->loaded()->volume));
    EXPECT_TRUE(scene->carry_out(1, TissueCommand{.choice = {.model = "vessel"}}).ok());
    ASSERT_NE(scene->tissue().drivable(), nullptr);
    EXPECT_EQ(scene->tissue().drivable()->measures().steps, 0);

    auto cube = Scene::open({.phantom = "cube", .phantom_size = {20, 20, 20}}, m_arena);
    ASSERT_TRUE(cube.ok());
    EXPECT_EQ(drive(**cube, 10).error_code, "other_tissue");
    EXPECT_EQ((*cube)->carry_out(1, TissueCommand{.choice = {.model = "vessel"}}).error_code,
              "out_of_range");
}

TEST_F(VesselScene, SaysWhatIsWrongWithItsFile) {
    const auto error_of = [&](const char* text) {
        const auto scene =
            Scene::open({.file = m_folder.write("bad.toml", text).string()}, m_arena);
        return scene.ok() ? std::string() : scene.error().message;
    };
    EXPECT_NE(error_of("[vessel]\nphantom = \"knot\"\n").find("bad.toml: [vessel] phantom"),
              std::string::npos);
    EXPECT_NE(error_of("[vessel]\nscan = \"none.nrrd\"\nwindow_hu = [1, 2]\n"
                       "[way]\npoints_mm = [[0,0,0],[1,1,1]]\n")
                  .find("none.nrrd"),
              std::string::npos);
}

/// A simulation takes its time where others use the machine as well.
Json patiently(TestClient& client, const std::function<bool(const Json&)>& holds) {
    Json found;
    for (int n = 0; n < 5 && found.is_null(); ++n) found = client.until(holds);
    return found;
}

/// A client's copy from the frames, decoded as in the protocol.
struct Copy {
    std::vector<Vec3f> rest, positions;
    std::vector<std::uint32_t> corners;
    std::vector<Vec3f> catheter;
    float radius = 0;
    std::size_t nodes_sent = 0;

    template <class T>
    static T take(const std::string& bytes, std::size_t& at) {
        T value{};
        EXPECT_LE(at + sizeof value, bytes.size());
        if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
        at += sizeof value;
        return little_endian(value);
    }
    static Vec3f take_place(const std::string& bytes, std::size_t& at) {
        Vec3f p;
        for (int a = 0; a < 3; ++a) p[a] = take<float>(bytes, at);
        return p;
    }
    void take_surface(const std::string& bytes) {
        ASSERT_EQ(bytes[4], 3);
        std::size_t at = 32;
        const auto nodes = take<std::uint32_t>(bytes, at), cells = take<std::uint32_t>(bytes, at);
        ASSERT_EQ(bytes.size(), 40 + 12 * std::size_t(nodes) + 12 * std::size_t(cells));
        for (std::uint32_t n = 0; n < nodes; ++n) rest.push_back(take_place(bytes, at));
        for (std::uint32_t n = 0; n < 3 * cells; ++n)
            corners.push_back(take<std::uint32_t>(bytes, at));
        for (const std::uint32_t n : corners) ASSERT_LT(n, nodes);
        positions = rest;
    }
    void take_vessel(const std::string& bytes) {
        ASSERT_EQ(bytes[4], 4);
        std::size_t at = 32;
        radius = take<float>(bytes, at);
        catheter.resize(take<std::uint32_t>(bytes, at));
        std::vector<std::array<std::uint32_t, 2>> runs(take<std::uint32_t>(bytes, at));
        for (Vec3f& p : catheter) p = take_place(bytes, at);
        for (auto& run : runs)
            for (auto& number : run) number = take<std::uint32_t>(bytes, at);
        nodes_sent = 0;
        for (const auto& [first, count] : runs) {
            ASSERT_LE(std::size_t(first) + count, positions.size());
            for (std::uint32_t n = first; n < first + count; ++n, ++nodes_sent)
                for (int a = 0; a < 3; ++a)
                    positions[n][a] = rest[n][a] + float_from_half(take<std::uint16_t>(bytes, at));
        }
        ASSERT_EQ(at, bytes.size());
    }
};

TEST_F(VesselScene, SendsWhatHasMovedAndNothingElse) {
    const auto scene = open(m_arena);
    VesselFrames frames;
    frames.update(*scene->tissue().drivable());
    const std::uint64_t first = frames.version();
    Copy early, late;
    early.take_surface(*frames.surface(*scene->tissue().drivable(), 1, 1));
    early.take_vessel(*frames.since(0, 1, 1));
    EXPECT_EQ(early.nodes_sent, 0U);
    drive(*scene, 100);
    for (int n = 0; n < 60; ++n) (void)scene->sweep();
    frames.update(*scene->tissue().drivable());
    EXPECT_GT(frames.version(), first);
    early.take_vessel(*frames.since(first, 1, 1));
    const std::size_t all = early.positions.size();
    EXPECT_GT(early.nodes_sent, 0U);
    EXPECT_LT(early.nodes_sent, all);
    // Nothing has happened since.
    const std::uint64_t second = frames.version();
    frames.update(*scene->tissue().drivable());
    EXPECT_EQ(frames.version(), second);
    for (int n = 0; n < 10; ++n) (void)scene->sweep();
    frames.update(*scene->tissue().drivable());
    early.take_vessel(*frames.since(second, 1, 1));
    late.take_surface(*frames.surface(*scene->tissue().drivable(), 1, 1));
    late.take_vessel(*frames.since(0, 1, 1));
    EXPECT_EQ(early.positions, late.positions);
    EXPECT_EQ(early.catheter, late.catheter);
    // As the simulation has it: half floats of a displacement below 4 mm are 0.002 mm apart.
    const MadeVessel& made = *scene->loaded()->vessel;
    const CatheterView& view = scene->tissue().drivable()->view();
    ASSERT_EQ(all, made.wall.ghost.nodes_mm.size());
    ASSERT_EQ(late.corners.size(), 3 * made.wall.ghost.cells.size());
    for (std::size_t n = 0; n < all; ++n)
        for (int a = 0; a < 3; ++a)
            EXPECT_NEAR(late.positions[n][a], made.wall.ghost.nodes_mm[n][a] + view.moved_mm[n][a],
                        1e-3 + 1e-3 * std::abs(view.moved_mm[n][a]));
    EXPECT_EQ(late.catheter.size(), view.catheter_mm.size());
    EXPECT_NEAR(norm(scene->tissue().drivable()->view().catheter_mm.back() -
                     Vec3d{late.catheter.back().x, late.catheter.back().y, late.catheter.back().z}),
                0, 1e-4);
    EXPECT_FLOAT_EQ(late.radius, 0.9F);
}

TEST_F(VesselScene, IsServedToSeveralAndPlayedAgain) {
    const auto session = m_folder / "v.pls";
    std::string volume;
    {
        auto server = Server::start({.file = m_source.file, .session = session}, m_arena);
        ASSERT_TRUE(server.ok()) << server.error().message;
        TestClient a(server->port(), server->link());
        const Json welcome = a.enter();
        EXPECT_EQ(welcome["state"]["tissue"]["model"], "vessel");
        EXPECT_EQ(welcome["volume"]["name"], "bend");
        EXPECT_EQ(a.command({{"do", "vessel"}, {"on", true}})["t"], "done");
        {
            TestClient viewer(server->port(), server->view_link());
            viewer.enter();
            EXPECT_EQ(viewer.command({{"do", "catheter"}, {"insert_mm_s", 50}})["code"],
                      "view_only");
        }
        EXPECT_EQ(a.command({{"do", "catheter"}, {"insert_mm_s", 101}})["code"], "out_of_range");
        EXPECT_EQ(a.command({{"do", "catheter"}, {"insert_mm_s", 100}})["t"], "done");
        const Json moved = patiently(a, [](const Json& text) {
            return text["t"] == "state" && text["vessel"]["inserted_mm"] > 34 &&
                   text["vessel"]["wall_moved_mm"] > 0.01;
        });
        ASSERT_FALSE(moved.is_null());
        EXPECT_NE(moved["vessel"]["force_n"], 0);
        // A hand that is gone doesn't go on pushing.
        {
            TestClient b(server->port(), server->link());
            b.enter();
            EXPECT_EQ(b.command({{"do", "catheter"}, {"insert_mm_s", -20}})["t"], "done");
        }
        const Json still = patiently(a, [](const Json& text) {
            return text["t"] == "state" && text["vessel"]["insert_mm_s"] == 0 &&
                   text["settled"] == true;
        });
        ASSERT_FALSE(still.is_null());
        EXPECT_GT(still["vessel"]["pace"], 0);
        EXPECT_GT(still["vessel"]["sub_steps"], 0);
        const Json sums = a.checked_checksum();
        volume = sums["volume"];
        ASSERT_FALSE(a.surface.empty());
        Copy copy;
        copy.take_surface(a.surface);
        for (const std::string& frame : a.vessels) copy.take_vessel(frame);
        // A later client is sent the same.
        TestClient late(server->port(), server->view_link());
        late.enter();
        EXPECT_EQ(late.checked_checksum()["volume"], sums["volume"]);
        EXPECT_TRUE(late.surface.empty());  // it hasn't asked
        EXPECT_EQ(late.command({{"do", "vessel"}, {"on", true}})["t"], "done");
        late.checked_checksum();
        Copy other;
        other.take_surface(late.surface);
        for (const std::string& frame : late.vessels) other.take_vessel(frame);
        EXPECT_EQ(other.positions, copy.positions);
        EXPECT_EQ(other.catheter, copy.catheter);
        EXPECT_NE(copy.positions, copy.rest);
    }
    const auto report = replay_session(session, m_arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(hex_text(report->volume_hash, 16), volume);
    EXPECT_GT(report->marks, 0);
    // Another wall is another session.
    std::string other = kFile;
    other.replace(other.find("200\ntip"), 3, "150");
    m_folder.write("bend.toml", other);
    const auto changed = replay_session(session, m_arena);
    ASSERT_FALSE(changed.ok());
}

}  // namespace
}  // namespace pliant::serve
