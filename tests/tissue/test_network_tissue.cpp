// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A network as the tissue of a scan, compared with a direct run of SpringTissue.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/models/pbd.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "support/temporary_folder.h"
#include "tissue/no_trace.h"

namespace pliant::test {
namespace {

constexpr std::uint32_t kLeft = kFirstTool, kRight = kSecondTool;
constexpr Vec3d kFirst_mm{6, 6, 6};  ///< corner of the box of tetrahedra

Volume plain_scan() {
    Volume scan;
    scan.grid = {{32, 30, 26}, {1, 1, 1}};
    std::vector<std::int16_t> voxels;
    for (int n = 0; n < 32 * 30 * 26; ++n) voxels.push_back(std::int16_t(n % 97));
    scan.voxels = std::move(voxels);
    return scan;
}

/// Tetrahedra of 3 mm, 10 kPa, with its lowest nodes fixed.
SpringParts box_parts() {
    TetMesh mesh = five_tet_block({6, 5, 4}, 3);
    for (Vec3d& node : mesh.nodes_mm) node = node + kFirst_mm;
    auto parts = springs_of_elastic_tetrahedra(mesh.nodes_mm, mesh.cells,
                                               {.stiffness = 4000, .density = 1e-3, .bulk = 8000});
    for (SpringNode& node : parts->nodes) {
        node.fixed = node.rest.z < 7;
        node.damping = 20 * node.mass;
    }
    return std::move(*parts);
}

/// A sphere at the middle of the box's upper face, pushed down and aside.
const Push kDown{.point_mm = {15, 13.5, 18}, .push_mm = {0.4, 0.3, -2}, .sphere_radius_mm = 3.5};

class Networks : public testing::Test {
  protected:
    std::unique_ptr<Tissue> make(const TaskArena& arena) const {
        auto made = make_network(m_scan, m_parts, m_settings, arena);
        EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
        return std::move(*made);
    }
    std::unique_ptr<Tissue> make() const { return make(m_arena); }
    static std::vector<double> numbers_of(const Tissue& tissue) {
        std::vector<double> numbers;
        dynamic_cast<const NodeTissue&>(tissue).state(numbers);
        return numbers;
    }
    Vec3d place(const std::vector<double>& numbers, std::int32_t node) const {
        const auto n = 3 * std::size_t(node);
        return {numbers[n], numbers[n + 1], numbers[n + 2]};
    }

    const TaskArena m_arena{1};
    const Volume m_scan = plain_scan();
    const SpringParts m_parts = box_parts();
    const NetworkSettings m_settings{.reach_mm = 4};
};

TEST_F(Networks, APushIsThatOfTheSameNodesOfAPlainNetwork) {
    const auto tissue = make();
    auto network = SpringNetwork::create(m_parts);
    auto plain =
        SpringTissue::create(std::move(*network), {.solver = SpringSolver::ImplicitEuler,
                                                   .time_step = m_settings.time_step_s,
                                                   .solve_tolerance = m_settings.solve_tolerance,
                                                   .assembled = true});
    ASSERT_TRUE(plain.ok());
    const auto report = tissue->push(kLeft, kDown);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->status, PushStatus::Applied) << report->message;

    // Strides of at most a quarter of the mean edge; the sphere takes all nodes that it meets.
    double edges = 0;
    for (const SpringCell& cell : m_parts.cells)
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b)
                edges += norm(m_parts.nodes[std::size_t(cell.nodes[a])].rest -
                              m_parts.nodes[std::size_t(cell.nodes[b])].rest);
    const int strides =
        int(std::ceil(norm(kDown.push_mm) / (0.25 * edges / (6.0 * double(m_parts.cells.size())))));
    ASSERT_GT(strides, 1);
    std::vector<std::int32_t> held;
    for (int n = 0; n < strides; ++n) {
        const Vec3d shift = (1.0 / strides) * kDown.push_mm;
        const Vec3d centre = kDown.point_mm + double(n) * shift;
        for (std::int32_t p = 0; p < std::int32_t(m_parts.nodes.size()); ++p)
            if (norm(plain->position(p) - centre) <= kDown.sphere_radius_mm &&
                !m_parts.nodes[std::size_t(p)].fixed && !std::count(held.begin(), held.end(), p))
                held.push_back(p);
        std::sort(held.begin(), held.end());
        ASSERT_TRUE(plain->hold(held).ok());
        ASSERT_TRUE(plain->shift_held(shift).ok());
        ASSERT_TRUE(plain->step(1, m_arena).ok());
    }
    EXPECT_EQ(report->grabbed_elements, std::int64_t(held.size()));
    EXPECT_GT(held.size(), 3u);
    const auto expect_equal = [&](const char* when) {
        const std::vector<double> numbers = numbers_of(*tissue);
        for (std::int32_t p = 0; p < std::int32_t(m_parts.nodes.size()); ++p)
            ASSERT_EQ(place(numbers, p), plain->position(p)) << when << p;
    };
    expect_equal("after the push, node ");
    for (int n = 0; n < 2; ++n) {
        const auto swept = tissue->sweep();
        ASSERT_TRUE(swept.ok());
        ASSERT_FALSE(swept->settled) << "it would be stopped";
        ASSERT_TRUE(plain->step(1, m_arena).ok());
    }
    expect_equal("after two steps, node ");
    // Newtons, against the push.
    const auto reaction = plain->reaction(held, ReactionLaw::Held);
    const auto felt = tissue->force_n(kLeft);
    ASSERT_TRUE(felt.has_value() && reaction.ok());
    EXPECT_NEAR(norm(*felt - 1e-6 * reaction->force), 0, 1e-15);
    EXPECT_LT(dot(*felt, kDown.push_mm), 0);
    EXPECT_EQ(*tissue->force_n(kRight), (Vec3d{0, 0, 0}));
    tissue->release(kLeft);
    ASSERT_TRUE(plain->hold({}).ok());
    ASSERT_TRUE(tissue->sweep().ok());
    ASSERT_TRUE(plain->step(1, m_arena).ok());
    expect_equal("after the release, node ");
}

TEST_F(Networks, AtRestTheForceOnTheToolIsThatOfTheEquilibrium) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->push(kLeft, kDown).ok());
    const auto advanced = tissue->advance({.max_steps = 5000});
    ASSERT_TRUE(advanced.ok());
    EXPECT_TRUE(advanced->settled);
    const std::vector<double> numbers = numbers_of(*tissue);
    auto plain = SpringTissue::create(std::move(*SpringNetwork::create(m_parts)),
                                      {.solver = SpringSolver::Explicit});
    std::vector<std::int32_t> held;
    std::vector<Vec3d> positions;
    const auto at_start = make();
    const auto grabbed = at_start->push(kLeft, kDown);
    // The held nodes are those that moved exactly by strides: by the whole push, or a part of it.
    for (std::int32_t p = 0; p < std::int32_t(m_parts.nodes.size()); ++p) {
        const Vec3d moved = place(numbers, p) - m_parts.nodes[std::size_t(p)].rest;
        const double along = dot(moved, kDown.push_mm) / dot(kDown.push_mm, kDown.push_mm);
        if (along > 0.1 && norm(moved - along * kDown.push_mm) < 1e-12) {
            held.push_back(p);
            positions.push_back(place(numbers, p));
        }
    }
    ASSERT_EQ(std::int64_t(held.size()), grabbed->grabbed_elements);
    ASSERT_TRUE(plain->hold(held).ok());
    ASSERT_TRUE(plain->move_held(positions).ok());
    ASSERT_TRUE(plain->find_equilibrium().ok());
    const auto reaction = plain->reaction(held, ReactionLaw::Held);
    const Vec3d expected = 1e-6 * reaction->force;
    EXPECT_GT(norm(expected), 1e-3);
    EXPECT_LT(norm(*tissue->force_n(kLeft) - expected), 0.01 * norm(expected));
}

TEST_F(Networks, AtRestTheNodesAreWhereTheSolverLinkByLinkPutsThem) {
    const auto tissue = make();
    const auto report = tissue->push(kLeft, kDown);
    ASSERT_TRUE(report.ok());
    const auto advanced = tissue->advance({.max_steps = 5000});
    ASSERT_TRUE(advanced.ok());
    ASSERT_TRUE(advanced->settled);
    const std::vector<double> numbers = numbers_of(*tissue);
    auto plain = SpringTissue::create(std::move(*SpringNetwork::create(m_parts)),
                                      {.solver = SpringSolver::ImplicitEuler,
                                       .time_step = m_settings.time_step_s,
                                       .solve_tolerance = m_settings.solve_tolerance});
    ASSERT_TRUE(plain.ok());
    // The held nodes moved by the whole push or a part of it.
    std::vector<std::int32_t> held;
    std::vector<Vec3d> positions;
    for (std::int32_t p = 0; p < std::int32_t(m_parts.nodes.size()); ++p) {
        const Vec3d moved = place(numbers, p) - m_parts.nodes[std::size_t(p)].rest;
        const double along = dot(moved, kDown.push_mm) / dot(kDown.push_mm, kDown.push_mm);
        if (along > 0.1 && norm(moved - along * kDown.push_mm) < 1e-12) {
            held.push_back(p);
            positions.push_back(place(numbers, p));
        }
    }
    ASSERT_EQ(std::int64_t(held.size()), report->grabbed_elements);
    ASSERT_TRUE(plain->hold(held).ok());
    ASSERT_TRUE(plain->move_held(positions).ok());
    ASSERT_TRUE(plain->step(600, m_arena).ok());
    double farthest = 0, error = 0;
    for (std::int32_t p = 0; p < std::int32_t(m_parts.nodes.size()); ++p) {
        farthest = std::max(farthest, norm(plain->displacement(p)));
        error = std::max(error, norm(place(numbers, p) - plain->position(p)));
    }
    EXPECT_GT(farthest, 1);
    // A network is stopped at 0.05 mm/s, 0.0008 mm a step.
    EXPECT_LT(error, 0.005);
}

TEST_F(Networks, VoxelsMoveWithTheTetrahedraAroundThemAndRestFarAway) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->push(kLeft, kDown).ok());
    const std::vector<double> numbers = numbers_of(*tissue);
    const auto& field = tissue->deformation();
    double largest = 0;
    for (std::size_t n = 0; n < m_parts.nodes.size(); ++n) {
        const Vec3d rest = m_parts.nodes[n].rest;
        const Vec3i voxel{int(rest.x), int(rest.y), int(rest.z)};
        if (voxel.x % 2 != 0 || voxel.y % 2 != 0 || voxel.z % 2 != 0) continue;
        const Vec3d moved = place(numbers, std::int32_t(n)) - rest;
        largest = std::max(largest, norm(moved));
        EXPECT_NEAR(norm(field.displacement_mm(voxel) - moved), 0, 2e-6) << "node " << n;
    }
    EXPECT_GT(largest, 1);
    EXPECT_EQ(field.displacement_mm({30, 28, 25}), (Vec3d{0, 0, 0}));
    EXPECT_EQ(field.displacement_mm({15, 13, 24}), (Vec3d{0, 0, 0})) << "beyond the reach";
    EXPECT_GT(norm(field.displacement_mm({15, 13, 19})), 0.1) << "above the network, carried along";
    EXPECT_GT(deform_volume(*tissue)->written_voxels, 1000);
}

TEST_F(Networks, AHexahedronCarriesAsItsSixTetrahedraDo) {
    auto parts = springs_of_lattice(
        {.size = {3, 3, 3}, .spacing = {6, 6, 6}, .stiffness = {9e3, 9e3, 9e3}, .bulk = 5e3});
    ASSERT_TRUE(parts.ok());
    for (SpringNode& node : parts->nodes) {
        node.fixed = node.rest.z == 0;
        node.rest = node.rest + kFirst_mm;
    }
    auto tissue = make_network(m_scan, *parts, m_settings, m_arena);
    ASSERT_TRUE(tissue.ok()) << tissue.error().message;
    Push push = kDown;
    push.point_mm = {12, 12, 18};
    push.sphere_radius_mm = 2;
    ASSERT_TRUE((*tissue)->push(kLeft, push).ok());
    const std::vector<double> numbers = numbers_of(**tissue);
    const auto& field = (*tissue)->deformation();
    for (std::size_t n = 0; n < parts->nodes.size(); ++n) {
        const Vec3d rest = parts->nodes[n].rest;
        const Vec3d moved = place(numbers, std::int32_t(n)) - rest;
        EXPECT_NEAR(norm(field.displacement_mm({int(rest.x), int(rest.y), int(rest.z)}) - moved), 0,
                    2e-6);
    }
    EXPECT_GT(norm(field.displacement_mm({12, 12, 18})), 1.9);
}

TEST_F(Networks, HaveTheSameBitsForAnyNumberOfThreads) {
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 4}) {
        const TaskArena arena(threads);
        const auto tissue = make(arena);
        ASSERT_TRUE(tissue->push(kLeft, kDown).ok());
        for (int n = 0; n < 10; ++n) ASSERT_TRUE(tissue->sweep().ok());
        hashes.push_back(tissue->hash());
        hashes.push_back(hash_volume(deform_volume(*tissue)->volume));
    }
    EXPECT_EQ(hashes[2], hashes[0]);
    EXPECT_EQ(hashes[4], hashes[0]);
    EXPECT_EQ(hashes[3], hashes[1]);
    EXPECT_EQ(hashes[5], hashes[1]);
}

TEST_F(Networks, AreUndoneSavedLoadedAndComeToRest) {
    const TemporaryFolder folder;
    const auto tissue = make();
    const std::uint64_t at_rest = tissue->hash();
    tissue->begin_group("push");
    ASSERT_TRUE(tissue->push(kLeft, kDown).ok());
    EXPECT_EQ(tissue->end_group(), 0);
    const std::uint64_t pushed = tissue->hash();
    EXPECT_NE(pushed, at_rest);
    ASSERT_TRUE(tissue->rest().ok());
    EXPECT_FALSE(tissue->is_touched());
    ASSERT_TRUE(tissue->save_state(folder / "network").ok());
    ASSERT_TRUE(tissue->undo().ok());
    EXPECT_EQ(tissue->hash(), at_rest);
    ASSERT_TRUE(tissue->redo().ok());
    EXPECT_EQ(tissue->hash(), pushed);
    const auto twin = make();
    ASSERT_TRUE(twin->load_state(folder / "network").ok());
    EXPECT_EQ(twin->hash(), pushed);
    for (int n = 0; n < 4; ++n) {
        ASSERT_TRUE(tissue->sweep().ok());
        ASSERT_TRUE(twin->sweep().ok());
        ASSERT_EQ(twin->hash(), tissue->hash()) << "sweep " << n;
    }
    const auto advanced = tissue->advance({.max_steps = 5000});
    ASSERT_TRUE(advanced.ok());
    EXPECT_TRUE(advanced->settled);
    EXPECT_GT(advanced->steps, 0);
    EXPECT_EQ(tissue->hash(), at_rest) << "a free network returns to its rest positions";
    auto rigid = make_rigid(m_scan, m_arena);
    EXPECT_EQ((*rigid)->load_state(folder / "network").error().code, ErrorCode::Unreadable);
    auto& nodes = dynamic_cast<NodeTissue&>(*twin);
    std::vector<double> numbers = numbers_of(*twin);
    for (const double bad : {std::nan(""), numbers[0] + 1e-3, 1e4}) {  // node 0 is fixed
        std::vector<double> damaged = numbers;
        damaged[0] = bad;
        EXPECT_EQ(nodes.set_state(damaged).error().code, ErrorCode::InvalidArgument) << bad;
    }
    numbers.resize(6);
    EXPECT_EQ(nodes.set_state(numbers).error().code, ErrorCode::InvalidArgument);
}

TEST_F(Networks, APushEndsBeforeATetrahedronFolds) {
    const auto tissue = make();
    Push far = kDown;
    far.push_mm = {0, 0, -40};
    const auto report = tissue->push(kLeft, far);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Limited);
    EXPECT_EQ(report->limited_by, LimitedBy::Fold);
    EXPECT_FALSE(report->message.empty());
    EXPECT_LT(report->step_fraction, 1);
    const std::vector<double> x = numbers_of(*tissue);
    for (const SpringCell& cell : m_parts.cells) {
        const auto at = [&](std::size_t n) { return place(x, cell.nodes[n]); };
        EXPECT_GT(dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))), 0);
    }
}

TEST_F(Networks, APushGoesOnInFinerStridesWhereOneWouldFold) {
    TetMesh mesh;
    for (const SpringNode& node : m_parts.nodes) mesh.nodes_mm.push_back(node.rest);
    for (const SpringCell& cell : m_parts.cells)
        mesh.cells.push_back({cell.nodes[0], cell.nodes[1], cell.nodes[2], cell.nodes[3]});
    const double longest = std::min(rest_mesh(mesh).edge_mm / 4, kDown.sphere_radius_mm / 2);
    int finer = 0;
    for (const Vec3d way : {Vec3d{0, 0, -40}, Vec3d{4, 3, -30}, Vec3d{20, 0, -20}}) {
        const auto tissue = make();
        Push far = kDown;
        far.push_mm = way;
        const auto report = tissue->push(kLeft, far);
        ASSERT_TRUE(report.ok());
        EXPECT_EQ(report->limited_by, LimitedBy::Fold);
        const double strides = report->step_fraction * std::ceil(norm(way) / longest);
        EXPECT_NEAR(8 * strides, std::round(8 * strides), 1e-9) << "not finer than an eighth";
        finer += std::abs(strides - std::round(strides)) > 0.1;
        for (const double x : numbers_of(*tissue)) EXPECT_TRUE(std::isfinite(x));
    }
    EXPECT_GT(finer, 0);
}

TEST_F(Networks, TwoToolsHoldDifferentNodesAndAFreeOneMeetsNothing) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->push(kLeft, kDown).ok());
    Push same = kDown;
    same.point_mm = kDown.point_mm + kDown.push_mm;
    same.push_mm = {0, 0, 0};
    same.sphere_radius_mm = 6;
    ASSERT_TRUE(tissue->push(kRight, same).ok());
    EXPECT_FALSE(tissue->is_touched_by(kLeft));
    EXPECT_TRUE(tissue->is_touched_by(kRight));
    const auto free = tissue->push(
        kLeft, {.point_mm = {29, 27, 23}, .push_mm = {0, 0, 1}, .sphere_radius_mm = 1});
    ASSERT_TRUE(free.ok());
    EXPECT_EQ(free->status, PushStatus::Applied);
    EXPECT_EQ(free->grabbed_elements, 0);
    EXPECT_FALSE(tissue->is_touched_by(kLeft));
    const auto point = tissue->push(kLeft, {.point_mm = {8, 8, 17}, .push_mm = {0.1, 0, 0}});
    ASSERT_TRUE(point.ok());
    EXPECT_EQ(point->grabbed_elements, 4);
}

TEST_F(Networks, RefuseBadInputInALineAndKeepTheirState) {
    const auto tissue = make();
    const std::uint64_t at_rest = tissue->hash();
    for (Push push : {Push{{0, 0, 0}, {0, 0, 501}, 1}, Push{{0, 0, 0}, {0, 0, 1}, -1},
                      Push{{std::nan(""), 0, 0}, {0, 0, 1}, 1}}) {
        const auto report = tissue->push(kLeft, push);
        ASSERT_FALSE(report.ok());
        EXPECT_EQ(report.error().code, ErrorCode::InvalidArgument);
    }
    EXPECT_EQ(tissue->hash(), at_rest);
    EXPECT_FALSE(tissue->is_touched());
    const auto message = [&](const SpringParts& parts, const NetworkSettings& settings) {
        const auto made = make_network(m_scan, parts, settings, m_arena);
        return made.ok() ? std::string("accepted") : made.error().message;
    };
    EXPECT_EQ(message(m_parts, {.time_step_s = 0}).substr(0, 12), "time_step_s:");
    SpringParts links = m_parts;
    links.cells.clear();
    EXPECT_EQ(message(links, m_settings), "network: expected cells, found links alone");
    SpringParts away = m_parts;
    for (SpringNode& node : away.nodes) node.rest.x += 100;
    EXPECT_EQ(message(away, m_settings),
              "network: expected a body inside of the scan, found one beside it");
    SpringParts branched = m_parts;
    branched.links[2].branch_stiffness = branched.links[2].branch_time = 1;
    EXPECT_EQ(message(branched, m_settings),
              "network: expected links without Maxwell branches, found one");
    SpringParts broken = m_parts;
    broken.links.resize(3);
    EXPECT_NE(message(broken, m_settings), "accepted");
}

TEST_F(Networks, OneThatFliesApartSaysSo) {
    // Free and undamped: a push sets it drifting for ever.
    SpringParts parts = box_parts();
    for (SpringNode& node : parts.nodes) {
        node.fixed = false;
        node.damping = 0;
    }
    auto made = make_network(m_scan, parts, m_settings, m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    const auto pushed = (*made)->push(kLeft, kDown);
    ASSERT_TRUE(pushed.ok());
    (*made)->release(kLeft);
    const auto report = (*made)->advance({.max_steps = 20000});
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_TRUE(report->settled);
    EXPECT_NE(report->message.find("flies apart"), std::string::npos) << report->message;
    for (const double x : numbers_of(**made)) EXPECT_LT(std::abs(x), 540);
    // One that comes to rest doesn't.
    const auto held = make();
    ASSERT_TRUE(held->push(kLeft, kDown).ok());
    held->release(kLeft);
    const auto calm = held->advance({.max_steps = 20000});
    ASSERT_TRUE(calm.ok());
    EXPECT_TRUE(calm->settled);
    EXPECT_EQ(calm->message, "");
}

TEST_F(Networks, APushOrSweepThatRanOutOfMemoryLeavesNoTrace) {
    const auto make = [&] {
        auto tissue = this->make();
        touch(*tissue, kDown);
        return tissue;
    };
    Push aside = kDown;
    aside.point_mm = {9, 8, 18};
    const auto check = [&](const char* name, std::uint32_t tool, const Push& push) {
        expect_no_trace(
            name, make, [&](Tissue& tissue) { return tissue.push(tool, push); }, 5);
    };
    check("same tool", kLeft, kDown);
    check("its nodes", kRight, kDown);
    check("aside", kRight, aside);
    fail_each_allocation(
        make, [](Tissue& tissue) { return tissue.undo(); }, visible_state);
    auto tissue = make();
    {
        const FailingAllocation failing(0);
        EXPECT_FALSE(tissue->update_deformation().ok());
    }
    EXPECT_TRUE(tissue->update_deformation().ok());
    EXPECT_EQ(later_hashes(*tissue, 30), later_hashes(*make(), 30));
}

/// Distance of a point from a triangle: from its plane inside of the edges, or from an edge.
double distance_from(Vec3d p, const std::array<Vec3d, 3>& x) {
    double least = 1e300;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d edge = x[(k + 1) % 3] - x[k], d = p - x[k];
        least =
            std::min(least, norm(d - std::clamp(dot(d, edge) / dot(edge, edge), 0.0, 1.0) * edge));
    }
    const Vec3d normal = cross(x[1] - x[0], x[2] - x[0]);
    const Vec3d q = p - (dot(p - x[0], normal) / dot(normal, normal)) * normal;
    bool is_over = true;
    for (std::size_t k = 0; k < 3; ++k)
        is_over &= dot(cross(x[(k + 1) % 3] - x[k], q - x[k]), normal) >= 0;
    return is_over ? std::min(least, norm(p - q)) : least;
}

/// A sphere above the box, that goes into its upper face and aside.
const Push kSlide{.point_mm = {13, 13.5, 23}, .push_mm = {0.6, 0.3, -3.5}, .sphere_radius_mm = 4};

class SlidingOnNetworks : public Networks {
  protected:
    /// Of the sphere's surface from all boundary triangles.
    double clearance(const Tissue& tissue, Vec3d centre, double radius) const {
        TetMesh mesh;
        for (const SpringCell& cell : m_parts.cells)
            mesh.cells.push_back({cell.nodes[0], cell.nodes[1], cell.nodes[2], cell.nodes[3]});
        const std::vector<double> x = numbers_of(tissue);
        double least = 1e300;
        for (const auto& face : boundary_faces(mesh))
            least = std::min(least, distance_from(centre, {place(x, face[0]), place(x, face[1]),
                                                           place(x, face[2])}));
        return least - radius;
    }
    bool is_in_a_tetrahedron(const Tissue& tissue, Vec3d point) const {
        const std::vector<double> x = numbers_of(tissue);
        return std::any_of(m_parts.cells.begin(), m_parts.cells.end(), [&](const auto& cell) {
            return is_inside_tetrahedron(point, {place(x, cell.nodes[0]), place(x, cell.nodes[1]),
                                                 place(x, cell.nodes[2]), place(x, cell.nodes[3])});
        });
    }
};

TEST_F(SlidingOnNetworks, TheSurfaceStaysOutsideAndPushesBack) {
    const auto tissue = make();
    EXPECT_TRUE(tissue->traits().slides);
    const auto report = tissue->slide(kLeft, kSlide, {});
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->way_fraction, 1);
    EXPECT_EQ(report->limited_by, LimitedBy::None);
    EXPECT_GT(report->contacts, 1);
    EXPECT_FALSE(report->ends_in_tissue);
    const Vec3d end = kSlide.point_mm + kSlide.push_mm;
    EXPECT_LT(norm(report->end_mm - end), 1e-12);
    EXPECT_GT(clearance(*tissue, end, 4), -0.01);
    EXPECT_LT(clearance(*tissue, end, 4), 0.01) << "it is touched";
    EXPECT_GT(tissue->force_n(kLeft)->z, 0);
    EXPECT_EQ(*tissue->force_n(kRight), (Vec3d{0, 0, 0}));
    EXPECT_TRUE(tissue->is_touched_by(kLeft));
    const auto advanced = tissue->advance({.max_steps = 5000});
    ASSERT_TRUE(advanced.ok() && advanced->settled);
    EXPECT_GT(clearance(*tissue, end, 4), -0.01);
    // At rest, the force is that of the fixed nodes on the ground.
    auto plain = SpringTissue::create(std::move(*SpringNetwork::create(m_parts)),
                                      {.solver = SpringSolver::Explicit});
    const std::vector<double> x = numbers_of(*tissue);
    std::vector<std::int32_t> ground;
    for (std::int32_t p = 0; p < std::int32_t(m_parts.nodes.size()); ++p) {
        if (m_parts.nodes[std::size_t(p)].fixed)
            ground.push_back(p);
        else
            ASSERT_TRUE(plain->set_state(p, place(x, p), {0, 0, 0}).ok());
    }
    const auto from_ground = plain->reaction(ground, ReactionLaw::Held);
    ASSERT_TRUE(from_ground.ok());
    const Vec3d felt = *tissue->force_n(kLeft);
    EXPECT_GT(felt.z, 1e-3);
    EXPECT_LT(norm(felt + 1e-6 * from_ground->force), 0.02 * norm(felt));
}

TEST_F(SlidingOnNetworks, AWayThroughTheBodyEndsOutsideOfIt) {
    for (const Vec3d way : {Vec3d{0, 0, -40}, Vec3d{30, 5, -20}}) {
        const auto tissue = make();
        Push through = kSlide;
        through.push_mm = way;
        const auto report = tissue->slide(kLeft, through, {});
        ASSERT_TRUE(report.ok());
        EXPECT_FALSE(is_in_a_tetrahedron(*tissue, report->end_mm)) << way.x;
        EXPECT_GT(clearance(*tissue, report->end_mm, 4), -0.1) << way.x;
        if (report->way_fraction < 1) {
            EXPECT_TRUE(report->limited_by == LimitedBy::Fold ||
                        report->limited_by == LimitedBy::Bone);
        }
        const std::vector<double> x = numbers_of(*tissue);
        for (const SpringCell& cell : m_parts.cells) {
            const auto at = [&](std::size_t n) { return place(x, cell.nodes[n]); };
            EXPECT_GT(dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))), 0);
        }
    }
    // One that begins inside stays there.
    const auto tissue = make();
    const auto inside = tissue->slide(
        kLeft, {.point_mm = {13, 12, 12}, .push_mm = {0, 0, 1}, .sphere_radius_mm = 2}, {});
    ASSERT_TRUE(inside.ok());
    EXPECT_EQ(inside->way_fraction, 0);
    EXPECT_TRUE(inside->ends_in_tissue);
    EXPECT_EQ(inside->limited_by, LimitedBy::Wall);
    EXPECT_FALSE(tissue->is_touched());
}

TEST_F(SlidingOnNetworks, AreUndoneAndReturnWhenTheSphereIsReleased) {
    const auto tissue = make();
    const std::uint64_t at_rest = tissue->hash();
    tissue->begin_group("slide");
    ASSERT_TRUE(tissue->slide(kLeft, kSlide, {}).ok());
    EXPECT_EQ(tissue->end_group(), 0);
    const std::uint64_t moved = tissue->hash();
    EXPECT_NE(moved, at_rest);
    ASSERT_TRUE(tissue->undo().ok());
    EXPECT_EQ(tissue->hash(), at_rest);
    EXPECT_FALSE(tissue->is_touched());
    ASSERT_TRUE(tissue->redo().ok());
    EXPECT_EQ(tissue->hash(), moved);
    const auto twin = make();
    ASSERT_TRUE(twin->slide(kLeft, kSlide, {}).ok());
    EXPECT_EQ(twin->hash(), moved);
    twin->release(kLeft);
    EXPECT_FALSE(twin->is_touched());
    const auto advanced = twin->advance({.max_steps = 5000});
    ASSERT_TRUE(advanced.ok() && advanced->settled);
    EXPECT_EQ(twin->hash(), at_rest);
}

TEST_F(SlidingOnNetworks, AnEyeKeepsTheReturningSurfaceOutUntilItIsGone) {
    const auto tissue = make();
    const std::uint64_t at_rest = tissue->hash();
    constexpr std::uint32_t kEye = 9;
    constexpr double kEye_mm = 3.5;
    EXPECT_TRUE(tissue->place_eye(kEye, {13, 12, 12}, kEye_mm).ok());
    EXPECT_FALSE(tissue->has_eye(kEye)) << "in the tissue it has no effect";
    const auto slid = tissue->slide(kLeft, kSlide, {});
    ASSERT_TRUE(slid.ok());
    ASSERT_TRUE(tissue->place_eye(kEye, slid->end_mm, kEye_mm).ok());
    EXPECT_TRUE(tissue->has_eye(kEye));
    tissue->release(kLeft);
    EXPECT_FALSE(tissue->is_touched());
    for (int n = 0; n < 40; ++n) {
        ASSERT_TRUE(tissue->sweep().ok());
        ASSERT_GT(clearance(*tissue, slid->end_mm, kEye_mm), -0.1) << n;
    }
    ASSERT_TRUE(tissue->advance({.max_steps = 5000})->settled);
    EXPECT_LT(clearance(*tissue, slid->end_mm, kEye_mm), 0.3) << "it lies on the eye";
    EXPECT_NE(tissue->hash(), at_rest);
    ASSERT_TRUE(tissue->place_eye(kEye, slid->end_mm, 0).ok());
    EXPECT_FALSE(tissue->has_eye(kEye));
    ASSERT_TRUE(tissue->advance({.max_steps = 5000})->settled);
    EXPECT_EQ(tissue->hash(), at_rest);
    EXPECT_LT(clearance(*tissue, slid->end_mm, kEye_mm), -1) << "where the eye was";
    EXPECT_FALSE(tissue->place_eye(kEye, {0, 0, 0}, -1).ok());
}

TEST_F(SlidingOnNetworks, RefuseOtherToolsAndSurviveAFailedAllocation) {
    const auto tissue = make();
    Push point = kSlide;
    point.sphere_radius_mm = 0;
    EXPECT_EQ(tissue->slide(kLeft, point, {}).error().message,
              "slide: expected a sphere, found a point");
    const auto make = [&] {
        auto made = this->make();
        EXPECT_TRUE(made->slide(kLeft, kSlide, {}).ok());
        return made;
    };
    const auto state = [](const Tissue& made) {
        return std::tuple(made.hash(), made.is_touched_by(kLeft), made.is_touched_by(kRight));
    };
    Push on = kSlide;
    on.point_mm = kSlide.point_mm + kSlide.push_mm;
    on.push_mm = {1, 0, -0.5};
    const Failures failures = fail_each_allocation(
        make, [&](Tissue& made) { return made.slide(kLeft, on, {}); }, state, {.fresh = true});
    EXPECT_GE(failures.failed, 3);
    Push other = kSlide;
    other.point_mm = {20, 14, 23};
    (void)fail_each_allocation(make, [&](Tissue& made) { return made.slide(kRight, other, {}); },
                               state, {.fresh = true});
}

TEST_F(SlidingOnNetworks, APushAndASlideShareTheSurface) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->slide(kLeft, kSlide, {}).ok());
    const Vec3d centre = kSlide.point_mm + kSlide.push_mm;
    const Push beside{
        .point_mm = {22.5, 13.5, 18}, .push_mm = {-0.8, 0, 1}, .sphere_radius_mm = 2.5};
    const auto pushed = tissue->push(kRight, beside);
    ASSERT_TRUE(pushed.ok());
    EXPECT_GT(pushed->grabbed_elements, 0);
    EXPECT_GT(clearance(*tissue, centre, 4), -0.1);
    for (int n = 0; n < 20; ++n) {
        ASSERT_TRUE(tissue->sweep().ok());
        EXPECT_GT(clearance(*tissue, centre, 4), -0.1) << n;
    }
    EXPECT_TRUE(tissue->is_touched_by(kLeft));
    EXPECT_TRUE(tissue->is_touched_by(kRight));
}

}  // namespace
}  // namespace pliant::test
