// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The library's tissues behind the common interface. Bodies are compared with a direct run of
// PbdBody.
// Covers: tissue/*tissue.cpp.

#include <gtest/gtest.h>
#include <pliant/check_tissue.h>
#include <pliant/mesh.h>
#include <pliant/models/drivable.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>

#include "support/temporary_folder.h"
#include "tissue/no_trace.h"

namespace pliant::test {
namespace {

constexpr std::uint32_t kHand = kFirstTool, kSecond = kSecondTool;
constexpr Vec3d kCorner_mm{6, 6, 6};  ///< of the box of tetrahedra
constexpr double kCell_mm = 3;
constexpr Vec3i kCells{6, 5, 4};

/// Tissue, with a slab of bone in the lowest 9 mm: the body's lowest nodes are fixed.
Volume scan_with_bone() {
    Volume scan;
    scan.grid = {{32, 30, 26}, {1, 1, 1}};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < 26; ++k)
        for (int n = 0; n < 32 * 30; ++n) voxels.push_back(std::int16_t(k < 8 ? 900 : n % 97));
    scan.voxels = std::move(voxels);
    return scan;
}

TetMesh box() {
    TetMesh mesh = five_tet_block(kCells, kCell_mm);
    for (Vec3d& node : mesh.nodes_mm) node = node + kCorner_mm;
    return mesh;
}

/// A sphere at the middle of the box's upper face, pushed down and aside.
const Push kPush{.point_mm = {15, 13.5, 18}, .push_mm = {0.4, 0.3, -2}, .sphere_radius_mm = 3.5};

class Bodies : public testing::Test {
  protected:
    std::unique_ptr<Tissue> make(const TaskArena& arena) const {
        auto made = make_body(m_scan, m_mesh, m_settings, arena);
        EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
        return std::move(*made);
    }
    std::unique_ptr<Tissue> make() const { return make(m_arena); }
    /// Its steps are the tissue's sub-steps.
    PbdBody plain_body() {
        auto parts = pbd_of_mesh(m_mesh, {.density = 1e-3,
                                          .edges = false,
                                          .volumes = false,
                                          .solids = true,
                                          .young_modulus = 15e3,
                                          .poisson_ratio = 0.45});
        for (std::size_t n = 0; n < parts->positions.size(); ++n)
            if (parts->positions[n].z < 7.5) parts->inverse_masses[n] = 0;
        m_sub_steps = std::max(m_settings.sub_steps,
                               int(std::ceil(wave_sub_steps(*parts, m_settings.time_step_s))));
        return std::move(PbdBody::create(std::move(*parts),
                                         {.time_step = m_settings.time_step_s / m_sub_steps,
                                          .sub_steps = 1,
                                          .damping = 5,
                                          .warm_starts = true}))
            .value();
    }
    static std::vector<double> numbers_of(const Tissue& tissue) {
        std::vector<double> numbers;
        dynamic_cast<const NodeTissue&>(tissue).state(numbers);
        return numbers;
    }

    const TaskArena m_arena{1};
    const Volume m_scan = scan_with_bone();
    const TetMesh m_mesh = box();
    const BodySettings m_settings{.reach_mm = 4};
    int m_sub_steps = 0;  ///< of plain_body()
};

TEST_F(Bodies, APushIsThatOfTheSameNodesOfAPlainBody) {
    const auto tissue = make();
    PbdBody body = plain_body();
    const auto report = tissue->push(kHand, kPush);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->status, PushStatus::Applied) << report->message;

    // Strides of at most a quarter of the mean edge; the sphere takes all nodes that it meets.
    double edges = 0;
    for (const auto& cell : m_mesh.cells)
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b)
                edges += norm(m_mesh.nodes_mm[std::size_t(cell[a])] -
                              m_mesh.nodes_mm[std::size_t(cell[b])]);
    const double edge = edges / (6.0 * double(m_mesh.cells.size()));
    const int strides = int(std::ceil(norm(kPush.push_mm) / (0.25 * edge)));
    ASSERT_GT(strides, 1);
    std::vector<std::int32_t> held;
    for (int n = 0; n < strides; ++n) {
        const Vec3d shift = (1.0 / strides) * kPush.push_mm;
        const Vec3d centre = kPush.point_mm + double(n) * shift;
        for (std::int32_t p = 0; p < body.particle_count(); ++p)
            if (norm(body.position(p) - centre) <= kPush.sphere_radius_mm &&
                body.inverse_mass(p) > 0) {
                ASSERT_TRUE(body.set_inverse_mass(p, 0).ok());
                held.push_back(p);
            }
        // They move evenly, so that nothing is thrown.
        body.recall_forces();
        for (int k = 0; k < m_sub_steps; ++k) {
            for (const std::int32_t p : held)
                ASSERT_TRUE(
                    body.set_state(p, body.position(p) + (1.0 / m_sub_steps) * shift, {0, 0, 0})
                        .ok());
            ASSERT_TRUE(body.step(1, m_arena).ok());
        }
    }
    // The body keeps no momentum of a push.
    for (std::int32_t p = 0; p < body.particle_count(); ++p)
        ASSERT_TRUE(body.set_state(p, body.position(p), {0, 0, 0}).ok());
    EXPECT_EQ(report->grabbed_elements, std::int64_t(held.size()));
    EXPECT_GT(held.size(), 3u);
    const auto expect_equal = [&](const char* when) {
        const std::vector<double> numbers = numbers_of(*tissue);
        for (std::int32_t p = 0; p < body.particle_count(); ++p)
            for (int a = 0; a < 3; ++a) {
                ASSERT_EQ(numbers[std::size_t(6 * p + a)], body.position(p)[a]) << when << p;
                ASSERT_EQ(numbers[std::size_t(6 * p + 3 + a)], body.velocity(p)[a]) << when << p;
            }
    };
    expect_equal("after the push, particle ");

    // The force on the tool, in newtons, is that of the constraints on the held nodes.
    Vec3d force{0, 0, 0};
    const std::vector<Vec3d> forces = body.constraint_forces();
    for (const std::int32_t p : held) force = force + forces[std::size_t(p)];
    const auto felt = tissue->force_n(kHand);
    ASSERT_TRUE(felt.has_value());
    EXPECT_NEAR(norm(*felt - 1e-6 * force), 0, 1e-12);
    EXPECT_LT(dot(*felt, kPush.push_mm), 0) << "against the push";
    EXPECT_EQ(*tissue->force_n(kSecond), (Vec3d{0, 0, 0}));

    for (int n = 0; n < 5; ++n) {
        ASSERT_TRUE(tissue->sweep().ok());
        body.recall_forces();
        ASSERT_TRUE(body.step(m_sub_steps, m_arena).ok());
    }
    expect_equal("after five steps, particle ");
    tissue->release(kHand);
    for (const std::int32_t p : held)
        ASSERT_TRUE(body.set_inverse_mass(p, body.parts().inverse_masses[std::size_t(p)]).ok());
    ASSERT_TRUE(tissue->sweep().ok());
    body.recall_forces();
    ASSERT_TRUE(body.step(m_sub_steps, m_arena).ok());
    expect_equal("after the release, particle ");
}

TEST_F(Bodies, VoxelsMoveWithTheTetrahedraAroundThemAndRestFarAway) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->push(kHand, kPush).ok());
    const std::vector<double> numbers = numbers_of(*tissue);
    const auto& field = tissue->deformation();
    // A node that is a control node too.
    double largest = 0;
    for (std::size_t n = 0; n < m_mesh.nodes_mm.size(); ++n) {
        const Vec3d rest = m_mesh.nodes_mm[n];
        const Vec3i voxel{int(rest.x), int(rest.y), int(rest.z)};
        const Vec3i step = voxel - Vec3i{2, 2, 2};  // the lattice's first node: corner less reach
        if (step.x % 2 != 0 || step.y % 2 != 0 || step.z % 2 != 0) continue;
        const Vec3d moved = Vec3d{numbers[6 * n], numbers[6 * n + 1], numbers[6 * n + 2]} - rest;
        largest = std::max(largest, norm(moved));
        EXPECT_NEAR(norm(field.displacement_mm(voxel) - moved), 0, 2e-6) << "node " << n;
    }
    EXPECT_GT(largest, 1);
    EXPECT_EQ(field.displacement_mm({30, 28, 25}), (Vec3d{0, 0, 0}));
    EXPECT_EQ(field.displacement_mm({15, 13, 24}), (Vec3d{0, 0, 0})) << "beyond the reach";
    EXPECT_GT(norm(field.displacement_mm({15, 13, 19})), 0.1) << "above the body, carried along";
    const auto deformed = deform_volume(*tissue);
    ASSERT_TRUE(deformed.ok());
    EXPECT_GT(deformed->written_voxels, 1000);
}

TEST_F(Bodies, HaveTheSameBitsForAnyNumberOfThreads) {
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 4}) {
        const TaskArena arena(threads);
        const auto tissue = make(arena);
        ASSERT_TRUE(tissue->push(kHand, kPush).ok());
        for (int n = 0; n < 10; ++n) ASSERT_TRUE(tissue->sweep().ok());
        hashes.push_back(tissue->hash());
        hashes.push_back(hash_volume(deform_volume(*tissue)->volume));
    }
    EXPECT_EQ(hashes[2], hashes[0]);
    EXPECT_EQ(hashes[4], hashes[0]);
    EXPECT_EQ(hashes[3], hashes[1]);
    EXPECT_EQ(hashes[5], hashes[1]);
}

TEST_F(Bodies, AreUndoneSavedLoadedAndComeToRest) {
    const TemporaryFolder folder;
    const auto tissue = make();
    const std::uint64_t at_rest = tissue->hash();
    tissue->begin_group("push");
    ASSERT_TRUE(tissue->push(kHand, kPush).ok());
    EXPECT_EQ(tissue->end_group(), 0);
    const std::uint64_t pushed = tissue->hash();
    EXPECT_NE(pushed, at_rest);
    EXPECT_EQ(tissue->undo_steps(), 1);
    ASSERT_TRUE(tissue->rest().ok());
    EXPECT_FALSE(tissue->is_touched());
    ASSERT_TRUE(tissue->save_state(folder / "body").ok());
    ASSERT_TRUE(tissue->undo().ok());
    EXPECT_EQ(tissue->hash(), at_rest);
    ASSERT_TRUE(tissue->redo().ok());
    EXPECT_EQ(tissue->hash(), pushed);
    // Later results are the same after a round trip through a file.
    const auto twin = make();
    ASSERT_TRUE(twin->load_state(folder / "body").ok());
    EXPECT_EQ(twin->hash(), pushed);
    for (int n = 0; n < 4; ++n) {
        ASSERT_TRUE(tissue->sweep().ok());
        ASSERT_TRUE(twin->sweep().ok());
        ASSERT_EQ(twin->hash(), tissue->hash()) << "sweep " << n;
    }
    const auto advanced = tissue->advance({.max_steps = 5000});
    ASSERT_TRUE(advanced.ok());
    EXPECT_TRUE(advanced->settled);
    EXPECT_GT(advanced->steps, 5);
    EXPECT_EQ(tissue->hash(), at_rest) << "a free body returns to its rest positions";
    // A held one rests too, although its force makes rounded positions tremble.
    ASSERT_TRUE(tissue->push(kHand, kPush).ok());
    const auto held = tissue->advance({.max_steps = 500});
    ASSERT_TRUE(held.ok());
    EXPECT_TRUE(held->settled);
    // One without damping trembles on, and stops at last.
    auto undamped = make_body(m_scan, m_mesh, {.damping_per_s = 0, .reach_mm = 4}, m_arena);
    ASSERT_TRUE(undamped.ok());
    ASSERT_TRUE((*undamped)->push(kHand, kPush).ok());
    (*undamped)->release(kHand);
    const auto stopped = (*undamped)->advance({.max_steps = 5000});
    ASSERT_TRUE(stopped.ok());
    EXPECT_TRUE(stopped->settled);
    EXPECT_LE(stopped->steps, 600) << "10 s";
    // A state of another tissue, and damaged ones.
    auto rigid = make_rigid(m_scan, m_arena);
    ASSERT_TRUE(rigid.ok());
    EXPECT_EQ((*rigid)->load_state(folder / "body").error().code, ErrorCode::Unreadable);
    std::vector<double> numbers = numbers_of(*twin);
    auto& nodes = dynamic_cast<NodeTissue&>(*twin);
    numbers[4] = std::nan("");
    EXPECT_EQ(nodes.set_state(numbers).error().code, ErrorCode::InvalidArgument);
    numbers.resize(6);
    EXPECT_EQ(nodes.set_state(numbers).error().code, ErrorCode::InvalidArgument);
}

TEST_F(Bodies, APushEndsBeforeATetrahedronFolds) {
    const auto tissue = make();
    Push far = kPush;
    far.push_mm = {0, 0, -40};
    const auto report = tissue->push(kHand, far);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Limited);
    EXPECT_EQ(report->limited_by, LimitedBy::Fold);
    EXPECT_FALSE(report->message.empty());
    EXPECT_LT(report->step_fraction, 1);
    const std::vector<double> x = numbers_of(*tissue);
    const auto at = [&](std::int32_t n) {
        const auto k = std::size_t(6 * n);
        return Vec3d{x[k], x[k + 1], x[k + 2]};
    };
    for (const auto& c : m_mesh.cells)
        EXPECT_GT(dot(at(c[1]) - at(c[0]), cross(at(c[2]) - at(c[0]), at(c[3]) - at(c[0]))), 0);
}

TEST_F(Bodies, ATwoToolsHoldDifferentNodesAndAFreeOneMeetsNothing) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->push(kHand, kPush).ok());
    // The second tool takes the nodes of the first.
    Push same = kPush;
    same.point_mm = kPush.point_mm + kPush.push_mm;
    same.push_mm = {0, 0, 0};
    same.sphere_radius_mm = 6;
    ASSERT_TRUE(tissue->push(kSecond, same).ok());
    EXPECT_FALSE(tissue->is_touched_by(kHand));
    EXPECT_TRUE(tissue->is_touched_by(kSecond));
    const auto free = tissue->push(
        kHand, {.point_mm = {29, 27, 23}, .push_mm = {0, 0, 1}, .sphere_radius_mm = 1});
    ASSERT_FALSE(free.ok());
    EXPECT_EQ(free.error().field, "push");
    EXPECT_NE(free.error().message.find("expected a point inside of a body"), std::string::npos);
    EXPECT_NE(free.error().message.find("found 29, 27, 23; bodies lie from "), std::string::npos)
        << free.error().message;
    EXPECT_FALSE(tissue->is_touched_by(kHand));
    EXPECT_TRUE(tissue->is_touched_by(kSecond));
    // A point tool takes the tetrahedron around it.
    const auto point = tissue->push(kHand, {.point_mm = {8, 8, 17}, .push_mm = {0.1, 0, 0}});
    ASSERT_TRUE(point.ok());
    EXPECT_EQ(point->grabbed_elements, 4);
}

TEST_F(Bodies, RefuseBadInputInALineAndKeepTheirState) {
    const auto tissue = make();
    const std::uint64_t at_rest = tissue->hash();
    for (Push push : {Push{{0, 0, 0}, {0, 0, 501}, 1}, Push{{0, 0, 0}, {0, 0, 1}, -1},
                      Push{{std::nan(""), 0, 0}, {0, 0, 1}, 1}}) {
        const auto report = tissue->push(kHand, push);
        ASSERT_FALSE(report.ok());
        EXPECT_EQ(report.error().code, ErrorCode::InvalidArgument);
    }
    EXPECT_EQ(tissue->hash(), at_rest);
    EXPECT_FALSE(tissue->is_touched());
    EXPECT_EQ(make_body(m_scan, m_mesh, {.young_modulus_pa = 0}, m_arena).error().field,
              "young_modulus_pa");
    EXPECT_FALSE(make_body(m_scan, TetMesh{}, m_settings, m_arena).ok());
    TetMesh away = m_mesh;
    for (Vec3d& node : away.nodes_mm) node = node + Vec3d{100, 0, 0};
    EXPECT_EQ(make_body(m_scan, away, m_settings, m_arena).error().field, "mesh");
    auto chain = PbdBody::create(
        {.positions = {{9, 9, 9}, {10, 9, 9}}, .inverse_masses = {1, 1}, .distances = {{{0, 1}}}},
        {});
    ASSERT_TRUE(chain.ok());
    EXPECT_EQ(make_body(m_scan, std::move(*chain), m_settings, m_arena).error().field, "body");
}

TEST_F(Bodies, APushOrSweepThatRanOutOfMemoryLeavesNoTrace) {
    const auto make = [&] {
        auto tissue = this->make();
        touch(*tissue, kPush);
        return tissue;
    };
    Push aside = kPush;
    aside.point_mm = {9, 8, 18};
    const auto check = [&](const char* name, std::uint32_t tool, const Push& push) {
        expect_no_trace(
            name, make, [&](Tissue& tissue) { return tissue.push(tool, push); }, 5);
    };
    check("same tool", kHand, kPush);
    check("its nodes", kSecond, kPush);
    check("aside", kSecond, aside);
    fail_each_allocation(
        make, [](Tissue& tissue) { return tissue.undo(); }, visible_state);
    // Sweeps need no memory, after a release either.
    {
        const auto tissue = make(), twin = make();
        for (Tissue* one : {tissue.get(), twin.get()}) one->release(kHand);
        ASSERT_TRUE(twin->sweep().ok());
        const FailingAllocation failing(0);
        ASSERT_TRUE(tissue->sweep().ok());
        ASSERT_EQ(visible_state(*tissue), visible_state(*twin));
    }
    // The force is unknown without memory, and the tissue goes on.
    auto tissue = make();
    {
        const FailingAllocation failing(0);
        EXPECT_FALSE(tissue->force_n(kHand).has_value());
        EXPECT_FALSE(tissue->update_deformation().ok());
    }
    EXPECT_TRUE(tissue->update_deformation().ok());
    EXPECT_EQ(later_hashes(*tissue, 30), later_hashes(*make(), 30));
}

TEST(RigidTissue, StopsEveryPushAsBoneDoesAndNeverMoves) {
    const TaskArena arena(1);
    const Volume scan = scan_with_bone();
    const auto made = make_rigid(scan, arena);
    ASSERT_TRUE(made.ok());
    Tissue& rigid = **made;
    const std::uint64_t at_rest = rigid.hash();
    rigid.begin_group("push");
    const auto report = rigid.push(kHand, kPush);
    EXPECT_EQ(rigid.end_group(), 0);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Rejected);
    EXPECT_EQ(report->limited_by, LimitedBy::Bone);
    EXPECT_EQ(report->step_fraction, 0);
    EXPECT_FALSE(rigid.push(kHand, {.push_mm = {0, std::nan(""), 0}}).ok());
    EXPECT_FALSE(rigid.is_touched());
    EXPECT_EQ(rigid.undo_steps(), 0);
    EXPECT_TRUE(rigid.advance({.max_steps = 3})->settled);
    EXPECT_EQ(rigid.hash(), at_rest);
    EXPECT_EQ(deform_volume(rigid)->written_voxels, 0);
    const TemporaryFolder folder;
    EXPECT_TRUE(rigid.save_state(folder / "rigid").ok());
    EXPECT_TRUE(rigid.load_state(folder / "rigid").ok());
    EXPECT_FALSE(rigid.slide(kHand, kPush, {}).ok());
}

/// The half of a sphere with x above that of its centre.
struct Half final : ToolShape {
    bool contains(Vec3d offset_mm) const noexcept override { return offset_mm.x > 0; }
};

TEST(ToolShapes, BoundTheElementsAndNodesOfEveryTissue) {
    const TaskArena arena(1);
    const Volume scan = scan_with_bone();
    const Half half;
    Push push = kPush;
    push.push_mm = {0, 0, 0};
    push.point_mm = {15.25, 13.5, 16};
    push.sphere_radius_mm = 5;
    Push shaped = push;
    shaped.shape = &half;
    const auto count = [](const std::unique_ptr<Tissue>& tissue, const Push& by) {
        const auto report = tissue->push(kHand, by);
        EXPECT_TRUE(report.ok());
        return report->grabbed_elements;
    };
    auto chainmail = make_chainmail(scan, {}, arena).value();
    std::int64_t inside = 0;
    for (int k = 8; k < 26; ++k)
        for (int j = 0; j < 30; ++j)
            for (int i = 16; i < 32; ++i)
                inside += norm(Vec3d{i * 1.0, j * 1.0, k * 1.0} - push.point_mm) <= 5;
    EXPECT_EQ(count(chainmail, shaped), inside);
    EXPECT_GT(count(chainmail, push), inside);
    auto springs = make_springs(scan, {.cell_mm = 3}, arena).value();
    auto body = make_body(scan, box(), {}, arena).value();
    for (const auto* tissue : {&springs, &body}) {
        const std::int64_t part = count(*tissue, shaped);
        EXPECT_GT(part, 0);
        EXPECT_LT(part, count(*tissue, push));
    }
    // Elements count where they are now: moved beyond the plane, they are out of reach.
    const auto before = count(chainmail, shaped);
    Push aside = push;
    aside.push_mm = {-2, 0, 0};
    ASSERT_TRUE(chainmail->push(kSecond, aside).ok());
    EXPECT_LT(count(chainmail, shaped), before);
}

TEST(RestingTools, KeepOtherTissueOutOrHoldTheirElementsAlone) {
    const TaskArena arena(1);
    const Volume scan = scan_with_bone();
    std::vector<std::uint64_t> hashes;
    for (const auto resting : {RestingTool::KeepsTissueOut, RestingTool::HoldsElements}) {
        auto tissue = make_chainmail(scan, {}, arena, resting).value();
        ASSERT_TRUE(tissue->push(kHand, kPush).ok());
        const auto relaxed = tissue->advance({.max_steps = 30});
        ASSERT_TRUE(relaxed.ok());
        EXPECT_GT(relaxed->steps, 1);
        hashes.push_back(tissue->hash());
        // One call is as many sweeps.
        auto twin = make_chainmail(scan, {}, arena, resting).value();
        ASSERT_TRUE(twin->push(kHand, kPush).ok());
        for (std::int64_t n = 0; n < relaxed->steps; ++n) ASSERT_TRUE(twin->sweep().ok());
        EXPECT_EQ(twin->hash(), hashes.back());
    }
    EXPECT_NE(hashes[0], hashes[1]);
}

VesselWall tube() {
    const std::vector<CentrePoint> branch{{{16, 15, 3}, 4}, {{16, 15, 23}, 4}};
    return swept_tube(branch, {.thickness_mm = 1.5, .layers = 1, .sectors = 12}).value();
}
CatheterSettings in_tube() {
    return {.catheter = {.length_mm = 60}, .entry = entry_at(tube().ends[0])};
}

TEST(VesselTissue, MovesOnlyWhileItIsDriven) {
    const TaskArena arena(1);
    const Volume scan = scan_with_bone();
    auto tissue = make_vessel(scan, tube(), in_tube(), arena).value();
    Drivable* const catheter = tissue->drivable();
    ASSERT_NE(catheter, nullptr);
    EXPECT_EQ(catheter->length_mm(), 60);
    EXPECT_EQ(catheter->wall().nodes_mm, tube().ghost.nodes_mm);
    EXPECT_FALSE(tissue->push(kHand, kPush).ok());
    const double before = catheter->measures().inserted_mm;
    tissue->begin_group("catheter");
    ASSERT_TRUE(catheter->drive(kHand, {.insert_mm_s = 50, .bend_first_deg = 5}).ok());
    EXPECT_TRUE(tissue->is_touched_by(kHand) && !tissue->is_touched_by(kSecond));
    ASSERT_TRUE(tissue->advance({.max_steps = 20}).ok());
    EXPECT_NEAR(catheter->measures().inserted_mm,
                before + 50 * 20 * 0.001 * tissue->traits().sweep_ms, 1e-9);
    EXPECT_NEAR(norm(catheter->view().catheter_mm.back() - catheter->entry().position_mm),
                catheter->measures().inserted_mm, 0.5);
    tissue->release(kHand);
    tissue->end_group();
    EXPECT_FALSE(tissue->is_touched());
    EXPECT_EQ(catheter->hand(), (CatheterCommand{.bend_first_deg = 5}));
    ASSERT_TRUE(tissue->undo().ok());
    EXPECT_EQ(catheter->measures().inserted_mm, before);
    // No other tissue has one.
    EXPECT_EQ(make_rigid(scan, arena).value()->drivable(), nullptr);
}

TEST(TissueModels, AreThoseThatTheFunctionsMake) {
    const TaskArena arena(1);
    const Volume scan = scan_with_bone();
    std::vector<std::unique_ptr<Tissue>> tissues;
    for (auto* make :
         {+[](const Volume&s, const TaskArena&a) { return make_chainmail(s, {}, a); },
          +[](const Volume&s, const TaskArena&a) { return make_elastic(s, {}, a); },
          +[](const Volume&s, const TaskArena&a) { return make_springs(s, {.cell_mm = 4}, a); },
          +[](const Volume&s, const TaskArena&a) { return make_body(s, box(), {}, a); },
          +[](const Volume&s, const TaskArena&a) { return make_vessel(s, tube(), in_tube(), a); },
          +[](const Volume&s, const TaskArena&a) { return make_rigid(s, a); }}) {
        auto made = make(scan, arena);
        ASSERT_TRUE(made.ok()) << made.error().message;
        tissues.push_back(std::move(*made));
    }
    ASSERT_EQ(tissue_models().size(), tissues.size());
    for (std::size_t n = 0; n < tissues.size(); ++n) {
        const TissueTraits listed = tissue_models()[n], made = tissues[n]->traits();
        EXPECT_EQ(listed.model, made.model);
        EXPECT_EQ(listed.takes_pushes, made.takes_pushes);
        EXPECT_EQ(listed.slides, made.slides);
        EXPECT_EQ(listed.cuts, made.cuts);
        EXPECT_EQ(listed.carves, made.carves);
        EXPECT_EQ(listed.has_energy, made.has_energy);
        EXPECT_EQ(listed.moves_by_itself, made.moves_by_itself);
    }
}

/// The library's models, by name.
std::vector<std::pair<std::string, MakeTissue>> all_models() {
    const auto network = [](const Volume& scan, const TaskArena& arena) {
        const TetMesh mesh = box();
        SpringParts parts =
            springs_of_tetrahedra(mesh.nodes_mm, mesh.cells,
                                  {.stiffness = 4000, .density = 1e-3, .bulk = 8000})
                .value();
        for (SpringNode& node : parts.nodes) {
            node.fixed = node.rest.z < 7;
            node.damping = 20 * node.mass;
        }
        return make_network(scan, std::move(parts), {.reach_mm = 4}, arena);
    };
    return {
        {"chainmail", [](const Volume& s, const TaskArena& a) { return make_chainmail(s, {}, a); }},
        {"elastic", [](const Volume& s, const TaskArena& a) { return make_elastic(s, {}, a); }},
        {"springs",
         [](const Volume& s, const TaskArena& a) { return make_springs(s, {.cell_mm = 4}, a); }},
        {"body", [](const Volume& s,
                    const TaskArena& a) { return make_body(s, box(), {.reach_mm = 4}, a); }},
        {"network", network},
        {"rigid", [](const Volume& s, const TaskArena& a) { return make_rigid(s, a); }}};
}

TEST(TissueModels, KeepTheRulesOfAllTissues) {
    const Volume scan = scan_with_bone();
    Push point = kPush;
    point.sphere_radius_mm = 0;
    point.point_mm.z = 17;
    for (const auto& [name, make] : all_models())
        for (const Push& push : {kPush, point}) {
            const Status kept = check_tissue(make, scan, push);
            EXPECT_TRUE(kept.ok())
                << name << ", radius " << push.sphere_radius_mm << ": " << kept.error().message;
        }
}

}  // namespace
}  // namespace pliant::test
