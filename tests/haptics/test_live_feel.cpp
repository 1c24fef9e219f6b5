// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Local models of a tissue that gives way during the contact, against ChainMailFeel on the
// undeformed scan, and against the springs' force.
// Covers: haptics/posed_device.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/organs.h>
#include <pliant/models/pbd.h>
#include <pliant/tissues.h>
#include <pliant/volume.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <variant>
#include <vector>

#include "haptic_run.h"
#include "haptics/live_feel.h"
#include "haptics/posed_device.h"
#include "support/temporary_folder.h"
#include "tissue/chainmail_tissue.h"
#include "tissue/spring_tissue.h"

namespace pliant {
namespace {

constexpr std::uint32_t kTool = 7;
const ChainMailFeelSettings kSettings{.tool_radius_mm = 4, .iso_hu = -500};

/// A tool that goes straight into a wall of the airway phantom, and out again.
class LiveFeelTest : public ::testing::Test {
  protected:
    void SetUp() override {
        auto phantom = make_phantom({.name = "airway", .size = {64, 64, 64}}, m_arena);
        ASSERT_TRUE(phantom.ok());
        m_scan = std::move(phantom->volume);
        const PhantomLandmark& mark = phantom->landmarks.front();
        m_wall = RayCaster(m_scan, m_arena)
                     .first_hit(mark.eye_mm, mark.push_point_mm - mark.eye_mm, m_settings.iso_hu,
                                m_settings.polarity)
                     .value();
    }
    void take(std::unique_ptr<Tissue> tissue) {
        m_tissue = std::move(tissue);
        m_live.emplace(LiveDeformation::create(*m_tissue).value());
        (void)m_live->update();
        auto feel = LiveFeel::create(m_scan, m_live->volume(), {}, m_settings, kTool, m_arena);
        ASSERT_TRUE(feel.ok()) << feel.error().message;
        m_feel = std::move(*feel);
    }
    /// The tool's centre at a depth beyond where it touches.
    Vec3d at(double depth_mm) const {
        return m_wall.point_mm + (m_settings.tool_radius_mm - depth_mm) * m_wall.normal;
    }
    /// One step of a server: the tissue is pushed, shown and its model posted.
    HapticModel step(double depth_mm) {
        const Vec3d to = at(depth_mm);
        const Vec3d proxy = at(std::min(depth_mm, 0.0));
        if (!m_feel->follow(to, proxy)) {
            m_tissue->release(kTool);
            m_pushed = to;
        } else if (norm(to - m_pushed) > 0) {
            const Push push{m_pushed, to - m_pushed, m_settings.tool_radius_mm};
            double done = 0;
            if (m_tissue->traits().slides)
                done = m_tissue->slide(kTool, push, {}).value().way_fraction;
            else
                done = m_tissue->push(kTool, push).value().step_fraction;
            m_pushed = m_pushed + done * push.push_mm;
        }
        m_feel->changed(m_live->update().value().boxes);
        return m_feel->model(*m_tissue, m_pushed);
    }
    /// How far the wall is now from where it was.
    double dent_mm() const {
        const RayCaster caster(m_live->volume(), m_arena);
        const auto hit = caster.first_hit(m_wall.point_mm + 3.0 * m_wall.normal, -m_wall.normal,
                                          m_settings.iso_hu, m_settings.polarity);
        return hit ? hit->distance_mm - 3 : 1e9;
    }

    const TaskArena m_arena{2};
    ChainMailFeelSettings m_settings = kSettings;
    Volume m_scan;
    RayHit m_wall{};
    std::unique_ptr<Tissue> m_tissue;
    std::optional<LiveDeformation> m_live;
    std::unique_ptr<LiveFeel> m_feel;
    Vec3d m_pushed{0, 0, 0};
};

TEST_F(LiveFeelTest, AWallThatGivesWayIsFeltAsItWas) {
    take(std::make_unique<ChainMailTissue>(ChainMail::create(m_scan, {}, m_arena).value()));
    const auto still = ChainMailFeel::create(m_scan, {}, kSettings, m_arena).value();
    double last = 0;
    for (double depth = -2; depth < 3; depth += 0.25) {
        const HapticModel model = step(depth);
        const HapticModel alone = still->model(at(depth), at(std::min(depth, 0.0)));
        EXPECT_EQ(model.force_n, alone.force_n) << depth;
        EXPECT_EQ(model.plane_count, alone.plane_count) << depth;
        if (depth > 0.2) {
            EXPECT_GT(norm(model.force_n), last) << depth;
        }
        last = norm(model.force_n);
    }
    EXPECT_GT(last, 0.02);
    EXPECT_GT(dent_mm(), 1);  // the sphere's edge is in no voxel's middle
}

TEST_F(LiveFeelTest, WhatTheTissueIsNowCountsForTheNextContact) {
    take(std::make_unique<ChainMailTissue>(ChainMail::create(m_scan, {}, m_arena).value()));
    for (double depth = -2; depth < 3; depth += 0.25) step(depth);
    const double deep_n = norm(step(2).force_n);
    EXPECT_GT(deep_n, 0.02);  // still the same contact, dent or not
    step(-1);
    EXPECT_FALSE(m_feel->touches());
    const double dent = dent_mm();
    ASSERT_GT(dent, 1);
    step(-1);  // the dent is the wall now
    const auto still = ChainMailFeel::create(m_scan, {}, kSettings, m_arena).value();
    const double undented_n = norm(still->model(at(dent), at(0)).force_n);
    EXPECT_LT(norm(step(dent).force_n), 0.5 * undented_n);
    // Tissue that came back, or was put back, is met again where it was.
    (void)m_tissue->reset();
    m_feel->changed(m_live->update().value().boxes);
    step(-1);
    step(-1);
    step(0.25);
    EXPECT_NEAR(norm(step(2).force_n), deep_n, 0.05 * deep_n);
}

TEST_F(LiveFeelTest, LessIsLeftOfAWallThatWasPushedAlready) {
    auto model = ChainMail::create(m_scan, {}, m_arena).value();
    const auto limit = [&](const Volume& shown, Vec3d surface) {
        const auto feel = ChainMailFeel::create(m_scan, shown, {}, kSettings, m_arena).value();
        return feel->give_at(surface, m_wall.normal).limit_mm;
    };
    const double at_rest = limit(m_scan, m_wall.point_mm);
    ASSERT_TRUE(std::isfinite(at_rest));
    ASSERT_TRUE(slide_sphere(model, {at(-2), at(3) - at(-2), 4}).ok());
    take(std::make_unique<ChainMailTissue>(std::move(model)));
    const double dent = dent_mm();
    ASSERT_GT(dent, 1);
    const double later = limit(m_live->volume(), m_wall.point_mm - dent * m_wall.normal);
    EXPECT_NEAR(later, at_rest - dent, 0.2 * at_rest + 0.8);  // half a voxel
    EXPECT_LT(later, at_rest - 0.5 * dent);
}

TEST_F(LiveFeelTest, SpringsAreFeltAsTheyPushBack) {
    take(make_springs(m_scan, {.cell_mm = 8}, m_arena).value());
    step(-1);
    double last = 0;
    for (double depth = 0.2; depth < 3; depth += 0.2) {
        const HapticModel model = step(depth);
        ASSERT_TRUE(m_feel->touches()) << depth;
        for (int k = 0; k < 5; ++k) (void)m_tissue->sweep();
        const HapticModel felt = m_feel->model(*m_tissue, m_pushed);
        EXPECT_EQ(felt.force_n, *m_tissue->force_n(kTool)) << depth;
        EXPECT_GT(model.plane_count, 0);
        last = dot(felt.force_n, m_wall.normal);
    }
    EXPECT_GT(last, 0.01);
    step(-1);
    EXPECT_FALSE(m_tissue->is_touched());
    EXPECT_EQ(norm(step(-1).force_n), 0);
}

// Palpation [Choi2004, 5]. The force follows the label's modulus, less so if only the tissue near
// the wall's point has it.
TEST_F(LiveFeelTest, AStiffLabelIsFeltStifferThanASoftOne) {
    const auto& values = std::get<VoxelArray<std::int16_t>>(m_scan.voxels);
    const Vec3i size = m_scan.grid.size;
    const auto force_n = [&](double radius_mm, double young_kpa) {
        auto labels = std::make_shared<Volume>(m_scan);
        VoxelArray<std::int16_t> numbers(values.size());
        for (int k = 0; k < size.z; ++k)
            for (int j = 0; j < size.y; ++j)
                for (int i = 0; i < size.x; ++i) {
                    const auto n = voxel_index(m_scan.grid, {i, j, k});
                    if (values[n] < kSettings.iso_hu) continue;  // air has no label
                    const Vec3d p =
                        world_from_voxel(m_scan.grid, {double(i), double(j), double(k)});
                    numbers[n] = norm(p - m_wall.point_mm) < radius_mm ? 1 : 2;
                }
        labels->voxels = std::move(numbers);
        take(make_springs(
                 m_scan,
                 {.cell_mm = 8,
                  .label_materials = {{.values = {1}, .elastic = ElasticPair{young_kpa, 0.25}},
                                      {.values = {2}, .elastic = ElasticPair{5, 0.25}}},
                  .labels = labels},
                 m_arena)
                 .value());
        for (double depth = -1; depth < 3; depth += 0.5) step(depth);
        for (int n = 0; n < 200; ++n) (void)m_tissue->sweep();
        const HapticModel felt = m_feel->model(*m_tissue, m_pushed);
        m_tissue->release(kTool);
        m_pushed = at(-2);
        return dot(felt.force_n, m_wall.normal);
    };
    const double soft = force_n(1e9, 5), stiff = force_n(1e9, 15), near = force_n(25, 15);
    std::printf("5 kPa: %.4f N; 15 kPa: %.4f N, within 25 mm %.4f N\n", soft, stiff, near);
    EXPECT_GT(soft, 1e-3);
    EXPECT_NEAR(stiff / soft, 3, 0.15);
    EXPECT_GT(near / soft, 1.7);
    EXPECT_LT(near, stiff);
}

TEST_F(LiveFeelTest, ANetworkIsFeltInNewtonsAsStiffAsItIs) {
    std::vector<double> forces;
    for (const double modulus_pa : {3e3, 9e3}) {
        // A block whose top is the wall; its far layers are fixed.
        TetMesh mesh = five_tet_block({6, 6, 6}, 4);
        const Vec3d top = m_wall.normal;
        const Vec3d along =
            normalized(cross(top, std::abs(top.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
        const Vec3d across = cross(top, along);
        for (Vec3d& p : mesh.nodes_mm)
            p = m_wall.point_mm + (p.x - 12) * along + (p.y - 12) * across + (p.z - 24) * top;
        auto parts = springs_of_elastic_tetrahedra(mesh.nodes_mm, mesh.cells,
                                                   {.stiffness = modulus_pa, .density = 1e-3});
        for (SpringNode& node : parts->nodes)
            node.fixed = dot(node.rest - m_wall.point_mm, m_wall.normal) < -9;
        take(std::move(make_network(m_scan, *parts, {}, m_arena)).value());
        for (double depth = -2; depth < 3; depth += 0.5) step(depth);
        for (int n = 0; n < 100; ++n) ASSERT_TRUE(m_tissue->sweep().ok());
        const HapticModel model = step(3);
        const auto force = m_tissue->force_n(kTool);
        ASSERT_TRUE(force.has_value());
        EXPECT_NEAR(norm(model.force_n - *force), 0, 1e-9 + 1e-6 * norm(*force));
        EXPECT_GT(dot(model.force_n, m_wall.normal), 0) << "out of the wall";
        forces.push_back(norm(*force));
        EXPECT_GT(dent_mm(), 1);
        m_tissue->release(kTool);
        m_pushed = at(-2);
    }
    EXPECT_GT(forces[0], 1e-3);
    EXPECT_NEAR(forces[1] / forces[0], 3, 0.05);
}

/// An organ in air, and a tool that goes to its front, against +y.
class OrganFeelTest : public LiveFeelTest {
  protected:
    void SetUp() override {
        m_settings.tool_radius_mm = 10;  // larger than the cells
        const auto level = [](Vec3d x) {
            return 25 * (1 - norm(Vec3d{x.x / 40, x.y / 30, x.z / 25}));
        };
        const auto mesh = stuff_isosurface(
            level, {.begin_mm = {-42, -32, -27}, .end_mm = {42, 32, 27}, .cell_mm = 8}, m_arena);
        ASSERT_TRUE(mesh.ok());
        const auto file = m_folder / "organ.vtu";
        ASSERT_TRUE(write_vtu(file, *mesh).ok());
        auto made = make_organs(organ_file_of_mesh(file.string()), m_arena);
        ASSERT_TRUE(made.ok()) << made.error().message;
        m_scan = made->scan;
        m_wall = RayCaster(m_scan, m_arena)
                     .first_hit({0, -60, 0}, {0, 1, 0}, m_settings.iso_hu, m_settings.polarity)
                     .value();
        auto tissue = make_tissue(*made, m_scan, m_arena);
        ASSERT_TRUE(tissue.ok()) << tissue.error().message;
        take(std::move(*tissue));
    }

    test::TemporaryFolder m_folder;
};

TEST_F(OrganFeelTest, AnOrganIsFeltInNewtonsAndOnlyWhereItIsTouched) {
    for (double depth = -3; depth < -1; depth += 0.25) {
        EXPECT_EQ(norm(step(depth).force_n), 0) << depth;
        EXPECT_FALSE(m_tissue->is_touched()) << depth;
    }
    double last = 0;
    for (double depth = 1; depth < 5; depth += 1) {
        step(depth);
        for (int n = 0; n < 30; ++n) ASSERT_TRUE(m_tissue->sweep().ok());
        const HapticModel model = step(depth);
        ASSERT_TRUE(m_feel->touches()) << depth;
        EXPECT_EQ(model.force_n, *m_tissue->force_n(kTool)) << depth;
        EXPECT_GT(dot(model.force_n, m_wall.normal), last) << depth;
        EXPECT_GT(dot(model.force_n, m_wall.normal), 0.9 * norm(model.force_n)) << "no friction";
        last = dot(model.force_n, m_wall.normal);
    }
    // A rigid sphere that is 4 mm in a half space: 4/3 · E/(1 − ν²) · √(R d³), by Hertz. The organ
    // gives way as a whole, too.
    const double hertz_n =
        4.0 / 3 * 15e3 / (1 - 0.45 * 0.45) * std::sqrt(0.01 * std::pow(0.004, 3));
    EXPECT_GT(last, 0.2 * hertz_n);
    EXPECT_LT(last, 1.5 * hertz_n);
    EXPECT_GT(dent_mm(), 1);
    EXPECT_EQ(norm(step(-3).force_n), 0);
    EXPECT_FALSE(m_tissue->is_touched());
}

TEST_F(OrganFeelTest, AHandThatTapsAnOrganGetsNoEnergy) {
    HapticRun run;
    run.settings.max_force_n = 8;
    VirtualDeviceSettings settings;
    settings.coulomb_n = 0.05;
    settings.encoder_mm = 0.02;
    settings.position_mm = at(-5);
    settings.hand = spring_hand(at(-5));
    VirtualDevice device(settings);
    Vec3d proxy_mm = at(-5);
    double most_n = 0, deepest_mm = 0;
    int contacts = 0, free = 0;
    const auto tissue = [&](Vec3d tool_mm) {
        const bool touches = m_feel->follow(tool_mm, proxy_mm);
        if (!touches) {
            m_tissue->release(kTool);
            m_pushed = tool_mm;
        } else if (norm(tool_mm - m_pushed) > 0) {
            const Push way{m_pushed, tool_mm - m_pushed, m_settings.tool_radius_mm};
            const auto slid = m_tissue->slide(kTool, way, {});
            EXPECT_TRUE(slid.ok());
            if (slid.ok()) m_pushed = slid->end_mm;
        }
        for (int n = 0; n < 2; ++n) (void)m_tissue->sweep();
        m_feel->changed(m_live->update().value().boxes);
        return m_feel->model(*m_tissue, m_pushed);
    };
    run_haptics(device, run, 3000, tissue,
                [&](const HapticReading& reading, const HapticModel*, const HapticState& state,
                    const HapticForce& force) {
                    const double t = 1e-9 * double(reading.time_ns);
                    device.hand().target_mm =
                        at(-5 + 6 * (1 - std::cos(2 * std::numbers::pi * 0.7 * t)));
                    proxy_mm = state.proxy_mm;
                    const double depth = dot(at(0) - device.position_mm(), m_wall.normal);
                    deepest_mm = std::max(deepest_mm, depth);
                    most_n = std::max(most_n, norm(force.force_n));
                    contacts += state.in_contact;
                    if (depth < -2) {
                        ++free;
                        EXPECT_EQ(norm(force.force_n), 0) << t << " s, " << depth << " mm";
                    }
                    return true;
                });
    EXPECT_GT(contacts, 300);
    EXPECT_GT(free, 300);
    EXPECT_GT(deepest_mm, 2);
    EXPECT_GT(most_n, 0.1);
    EXPECT_GE(device.lowest_passivity_j(), -1e-4);
}

TEST(PosedDevice, GoesSmoothlyToWhereItIsSaidToBe) {
    Vec3d place{0, 0, 0};
    const Vec3d to{10, -4, 2};
    double last = norm(to);
    for (int k = 0; k < 100; ++k) {
        const Vec3d next = posed_step(place, to, 1e-3);
        EXPECT_LT(norm(next - place), 0.1 * norm(to));
        EXPECT_LT(norm(to - next), last);
        last = norm(to - next);
        place = next;
    }
    EXPECT_LT(last, 0.01);
    // The same way in larger steps.
    Vec3d coarse{0, 0, 0};
    for (int k = 0; k < 10; ++k) coarse = posed_step(coarse, to, 1e-2);
    EXPECT_LT(norm(coarse - place), 1e-9);
}

TEST(PosedDevice, IsLostWhereNobodySaysAnything) {
    const auto positions = std::make_shared<PosedPositions>();
    const auto device = make_posed_device(positions);
    HapticReading reading;
    EXPECT_FALSE(device->read(reading));
    positions->write({1, {1, 2, 3}});  // long ago
    EXPECT_FALSE(device->read(reading));
}

}  // namespace
}  // namespace pliant
