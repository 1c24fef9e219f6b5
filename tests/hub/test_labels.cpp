// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The label map as clients hold it: at rest the file's, and in deformed tissue the label at the
// source of each voxel, by the resampler's one-shot form in a twin scene.
// Covers: hub/label_*.cpp, session/label_map.cpp, session/label_map_file.cpp.

#include <pliant/scan_files.h>

#include <cmath>

#include "hub/twin_scene.h"
#include "protocol/frames.h"
#include "protocol/half.h"
#include "session/label_map.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using serve::float_from_half;
using serve::read_label_map;

constexpr Vec3i kSize{42, 36, 33};

/// Number of a label in a pattern of slabs, with gaps between them.
int pattern(Vec3i p) {
    const int slab = p.x / 5 + 3 * (p.y / 7);
    return p.z < 3 ? 0 : slab % 4;
}
constexpr int kValues[] = {0, 2, 7, 300};  ///< in the file, by number

class LabelsTest : public TwinSceneTest {
  protected:
    void SetUp() override {
        TwinSceneTest::SetUp();
        m_server.reset();
        m_grid = m_twin->info().grid;
        ASSERT_EQ(m_grid.size, kSize);
        ASSERT_TRUE(write_volume(file("labels.nrrd"), labels()).ok());
        m_server = start({.file = file("cube.nrrd"), .labels = file("labels.nrrd")});
    }
    std::string file(const std::string& name) const { return (m_folder / name).string(); }
    std::unique_ptr<Server> start(const ServerSettings& settings) {
        auto server = Server::start(settings, m_arena);
        EXPECT_TRUE(server.ok()) << server.error().message;
        return std::make_unique<Server>(std::move(*server));
    }
    Volume labels() const {
        Volume volume;
        volume.grid = m_grid;
        std::vector<std::int16_t> values(voxel_count(m_grid));
        for (int k = 0; k < kSize.z; ++k)
            for (int j = 0; j < kSize.y; ++j)
                for (int i = 0; i < kSize.x; ++i)
                    values[voxel_index(m_grid, {i, j, k})] =
                        std::int16_t(kValues[pattern({i, j, k})]);
        volume.voxels = std::move(values);
        volume.key_values = {{"Segment0_LabelValue", "7"},
                             {"Segment0_Name", "left lung"},
                             {"Segment0_Color", "0.5 0.25 1"},
                             {"Segment1_LabelValue", "9"},
                             {"Segment1_Name", "absent"}};
        return volume;
    }
    /// Asks for the labels. @returns their list
    static Json ask(TestClient& client) {
        client.overlay_format = serve::kFormatLabels;
        client.overlay.assign(client.voxels.size(), 0xffff);
        client.say({{"do", "labels"}, {"id", 900}, {"on", true}});
        EXPECT_EQ(client.answer(900)["t"], "done");
        return client.until("labels");
    }
    /// Until all voxels and labels of the present step are there.
    void catch_up(TestClient& client) { ASSERT_TRUE(is_twin(client)); }

    Grid m_grid;
};

TEST_F(LabelsTest, AtRestTheyAreThoseOfTheFileWithSlicersNames) {
    Visitor client(*m_server, true);
    const Json list = ask(client);
    EXPECT_EQ(list["name"], "labels.nrrd");
    ASSERT_EQ(list["labels"].size(), 3U);
    EXPECT_EQ(list["labels"][0]["value"], 2);
    EXPECT_EQ(list["labels"][0]["name"], "");
    EXPECT_FALSE(list["labels"][0].contains("colour"));
    EXPECT_EQ(list["labels"][1]["value"], 7);
    EXPECT_EQ(list["labels"][1]["name"], "left lung");
    EXPECT_EQ(list["labels"][1]["colour"], Json::array({0.5, 0.25, 1.0}));
    EXPECT_EQ(list["labels"][2]["value"], 300);
    catch_up(client);
    std::int64_t counts[4] = {};
    for (int k = 0; k < kSize.z; ++k)
        for (int j = 0; j < kSize.y; ++j)
            for (int i = 0; i < kSize.x; ++i) {
                const Vec3i p{i, j, k};
                ++counts[pattern(p)];
                ASSERT_EQ(float_from_half(client.overlay[voxel_index(m_grid, p)]), pattern(p))
                    << i << ' ' << j << ' ' << k;
            }
    for (int n = 1; n < 4; ++n) EXPECT_EQ(list["labels"][std::size_t(n - 1)]["voxels"], counts[n]);
}

TEST_F(LabelsTest, TheyMoveWithTheTissue) {
    Visitor early(*m_server), late(*m_server, true, {{"lz4", true}});
    ask(early);
    Random random(5);
    for (int n = 0; n < 12; ++n) {
        both(early, push_of(random.vector(9), random.vector(4), random.real(2, 6)));
        both(early, {{"do", "release"}});
        if (n % 4 == 3) both(early, {{"do", "undo"}});
    }
    both(early, {{"do", "carve"}, {"from", {0, 0, 0}}, {"to", {4, 0, 0}}, {"radius", 3}});
    ask(late);
    const Deformed once = deform_volume(m_twin->tissue(), Mapping::Cells, true).value();
    const VectorField inverse = inverse_field(once).value();
    for (TestClient* client : {static_cast<TestClient*>(&early), static_cast<TestClient*>(&late)}) {
        catch_up(*client);
        int moved = 0, gaps = 0;
        for (int k = 0; k < kSize.z; ++k)
            for (int j = 0; j < kSize.y; ++j)
                for (int i = 0; i < kSize.x; ++i) {
                    const Vec3i p{i, j, k};
                    const Vec3f back = inverse.vectors_mm[voxel_index(m_grid, p)];
                    const Vec3d source = voxel_from_world(
                        m_grid, world_from_voxel(m_grid, {double(i), double(j), double(k)}) +
                                    Vec3d{back.x, back.y, back.z});
                    const Vec3i from{int(std::lround(source.x)), int(std::lround(source.y)),
                                     int(std::lround(source.z))};
                    int expected = contains(voxel_box(m_grid), from) ? pattern(from) : 0;
                    const bool is_still = back == Vec3f{0, 0, 0};
                    // Gaps, here the carved ones, have no label.
                    const bool is_gap =
                        is_still && once.volume.at(p) != m_twin->loaded()->volume.at(p);
                    if (is_gap) expected = 0;
                    gaps += is_gap && pattern(p) != 0;
                    moved += !is_still;
                    ASSERT_EQ(float_from_half(client->overlay[voxel_index(m_grid, p)]), expected)
                        << i << ' ' << j << ' ' << k;
                }
        EXPECT_GT(moved, 1000);
        EXPECT_GT(gaps, 20);
    }
}

TEST_F(LabelsTest, AnotherMapReplacesThemForAllClientsAndABadOneChangesNothing) {
    Visitor client(*m_server), viewer(*m_server, true);
    ask(client);
    catch_up(client);
    const std::string target = "/open/labels?token=" + token_of(m_server->link()) + "&name=";
    const auto written = [&](const Volume& volume) {
        EXPECT_TRUE(write_volume(file("other.nrrd"), volume).ok());
        return bytes_of(file("other.nrrd"));
    };
    Volume halves = labels();
    halves.voxels = std::vector<float>(voxel_count(m_grid), 0.5F);
    const std::string refused =
        RawConnection(m_server->port()).post(target + "halves.nrrd", written(halves));
    EXPECT_EQ(status_of(refused), "400");
    EXPECT_NE(refused.find("halves.nrrd: expected a label map of whole numbers, found 0.5"),
              std::string::npos)
        << refused;
    const std::string forbidden =
        RawConnection(m_server->port())
            .post("/open/labels?token=" + token_of(m_server->view_link()) + "&name=a.nrrd", "x");
    EXPECT_EQ(status_of(forbidden), "403");

    // A crop, moved by whole voxels: its labels stay where they are in the world.
    Volume crop;
    crop.grid = m_grid;
    crop.grid.size = {10, 9, 8};
    crop.grid.origin_mm = world_from_voxel(m_grid, {5, 6, 7});
    crop.voxels = std::vector<std::int16_t>(voxel_count(crop.grid), std::int16_t(12));
    EXPECT_EQ(status_of(RawConnection(m_server->port()).post(target + "crop.nrrd", written(crop))),
              "200");
    const Json list = client.until("labels");
    EXPECT_EQ(list["name"], "crop.nrrd");
    ASSERT_EQ(list["labels"].size(), 1U);
    EXPECT_EQ(list["labels"][0]["value"], 12);
    EXPECT_EQ(list["labels"][0]["voxels"], 720);
    catch_up(client);
    for (int k = 0; k < kSize.z; ++k)
        for (int j = 0; j < kSize.y; ++j)
            for (int i = 0; i < kSize.x; ++i) {
                const bool in = i >= 5 && i < 15 && j >= 6 && j < 15 && k >= 7 && k < 15;
                ASSERT_EQ(float_from_half(client.overlay[voxel_index(m_grid, {i, j, k})]), in);
            }
    // A map that has nothing inside of the scan is none of this scan.
    crop.grid.origin_mm = {900, 0, 0};
    EXPECT_EQ(status_of(RawConnection(m_server->port()).post(target + "far.nrrd", written(crop))),
              "400");
}

TEST_F(LabelsTest, TheyEndWithTheScan) {
    Visitor client(*m_server);
    ask(client);
    catch_up(client);
    EXPECT_EQ(status_of(RawConnection(m_server->port())
                            .post("/open?token=" + token_of(m_server->link()) + "&name=b.nrrd",
                                  bytes_of(file("cube.nrrd")))),
              "200");
    ASSERT_FALSE(client.until("volume").is_null());
    ASSERT_TRUE(client.until_up_to_date());
    const Json list = ask(client);
    EXPECT_EQ(list["name"], "");
    EXPECT_EQ(list["labels"].size(), 0U);
}

TEST_F(LabelsTest, LabelsWithSettingsAreMaterialsOfTheSceneAndOfItsSession) {
    std::FILE* out = std::fopen(file("materials.toml").c_str(), "wb");
    std::fputs("[[label]]\nvalues = [2, 7, 300]\noffset = 0\n", out);
    std::fclose(out);
    m_server.reset();
    const auto moved = [&](const ServerSettings& settings) {
        auto server = start(settings);
        TestClient client(server->port(), server->link());
        client.enter();
        const Json done = client.command(push_of({0, 0, 0}, {0, 0, 3}, 2));
        EXPECT_EQ(done["t"], "done") << done;
        return std::pair(done["moved_elements"].get<int>(),
                         client.checked_checksum()["tissue"].get<std::string>());
    };
    ServerSettings settings{.file = file("cube.nrrd"), .labels = file("labels.nrrd")};
    const auto shown_only = moved(settings);
    settings.config = file("materials.toml");
    settings.session = file("session.pls");
    const auto rigid = moved(settings);
    EXPECT_NE(rigid.second, shown_only.second);
    // The session goes on with the same materials.
    auto again = start(settings);
    TestClient client(again->port(), again->link());
    client.enter();
    EXPECT_EQ(client.checked_checksum()["tissue"], rigid.second);
    again.reset();
    settings.config.clear();
    const auto other = Server::start(settings, m_arena);
    ASSERT_FALSE(other.ok());
    EXPECT_NE(other.error().message.find("expected a session of"), std::string::npos)
        << other.error().message;
}

TEST_F(LabelsTest, FilesThatAreNoLabelMapsOfTheScanAreErrorsThatNameTheOption) {
    ServerSettings settings{.file = file("cube.nrrd"), .labels = file("absent.nrrd")};
    const auto absent = Server::start(settings, m_arena);
    ASSERT_FALSE(absent.ok());
    EXPECT_EQ(absent.error().field, "labels");
    settings.labels.clear();
    settings.directions = file("labels.nrrd");
    const auto alone = Server::start(settings, m_arena);
    ASSERT_FALSE(alone.ok());
    EXPECT_EQ(alone.error().field, "directions");
    Volume many = labels();
    std::vector<std::int16_t> values(voxel_count(m_grid));
    for (std::size_t n = 0; n < values.size(); ++n) values[n] = std::int16_t(n % 2100);
    many.voxels = std::move(values);
    ASSERT_TRUE(write_volume(file("many.nrrd"), many).ok());
    const auto too_many = read_label_map(file("many.nrrd"), m_grid, m_arena);
    ASSERT_FALSE(too_many.ok());
    EXPECT_NE(too_many.error().message.find("up to 2047 labels"), std::string::npos);
}

}  // namespace
}  // namespace pliant::test
