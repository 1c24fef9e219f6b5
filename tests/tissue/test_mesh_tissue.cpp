// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue of one's own on the base of bodies, networks and springs.
// Covers: tissue/mesh_strides.cpp.

#include <gtest/gtest.h>
#include <pliant/models/mesh_tissue.h>
#include <pliant/models/pbd.h>
#include <pliant/resample.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

namespace pliant::test {
namespace {

constexpr std::uint32_t kTool = 3, kOther = 4;

/// Dough: each free node moves to the mean displacement of its neighbours, less a tenth. A step may
/// fail on request.
class Dough final : public MeshTissue {
  public:
    static std::unique_ptr<Dough> create(const Volume& scan, const TetMesh& mesh,
                                         const TaskArena& arena) {
        auto carried = carry(scan, mesh, 4, arena);
        EXPECT_TRUE(carried.ok());
        return std::unique_ptr<Dough>(new Dough(rest_mesh(mesh), std::move(*carried)));
    }
    TissueTraits traits() const noexcept override {
        return {.model = "dough", .moves_by_itself = true};
    }
    void positions_mm(std::span<Vec3d> positions) const override {
        std::copy(m_x.begin(), m_x.end(), positions.begin());
    }
    const RestMesh& at_rest() const override { return m_rest; }
    bool is_fixed(std::int32_t n) const override { return m_rest.nodes_mm[std::size_t(n)].z < 7; }
    using MeshTissue::held_by;

    int steps = 0;
    int failing_step = 0;  ///< which throws; 0: none

  private:
    Dough(RestMesh rest, std::unique_ptr<MovingScan> carried)
        : MeshTissue(std::move(carried), rest.nodes_mm.size()),
          m_rest(std::move(rest)),
          m_x(m_rest.nodes_mm),
          m_is_held(m_x.size()) {}
    void put(std::span<const Vec3d> positions, std::span<const Vec3d>) noexcept override {
        for (std::size_t n = 0; n < m_x.size(); ++n)
            if (!is_fixed(std::int32_t(n))) m_x[n] = positions[n];
    }
    void hold_nodes() noexcept override {
        std::fill(m_is_held.begin(), m_is_held.end(), std::uint8_t(0));
        for (const auto& [tool, nodes] : m_tools)
            for (const std::int32_t n : nodes) m_is_held[std::size_t(n)] = 1;
    }
    Status stride(std::span<const std::int32_t> nodes, Vec3d shift) override {
        for (const std::int32_t n : nodes) m_x[std::size_t(n)] = m_x[std::size_t(n)] + shift;
        return step();
    }
    Status step() override {
        if (++steps == failing_step) throw std::bad_alloc();
        std::vector<Vec3d> sums(m_x.size());
        std::vector<int> counts(m_x.size());
        for (const auto& cell : m_rest.cells)
            for (const std::int32_t a : cell)
                for (const std::int32_t b : cell) {
                    sums[std::size_t(a)] = sums[std::size_t(a)] + m_x[std::size_t(b)] -
                                           m_rest.nodes_mm[std::size_t(b)];
                    ++counts[std::size_t(a)];
                }
        m_farthest = 0;
        for (std::size_t n = 0; n < m_x.size(); ++n) {
            if (is_fixed(std::int32_t(n)) || m_is_held[n] != 0) continue;
            const Vec3d to = m_rest.nodes_mm[n] + (0.9 / counts[n]) * sums[n];
            m_farthest = std::max(m_farthest, norm(to - m_x[n]));
            m_x[n] = to;
        }
        return Ok{};
    }
    bool is_calm() override { return m_farthest < 1e-3; }

    RestMesh m_rest;
    std::vector<Vec3d> m_x;
    std::vector<std::uint8_t> m_is_held;
    double m_farthest = 0;
};

class MeshTissues : public testing::Test {
  protected:
    MeshTissues() {
        m_scan.grid = {{32, 30, 26}, {1, 1, 1}};
        std::vector<std::int16_t> voxels;
        for (int n = 0; n < 32 * 30 * 26; ++n) voxels.push_back(std::int16_t(n % 97));
        m_scan.voxels = std::move(voxels);
        m_mesh = five_tet_block({6, 5, 4}, 3);
        for (Vec3d& node : m_mesh.nodes_mm) node = node + Vec3d{6, 6, 6};
    }
    std::unique_ptr<Dough> make() const { return Dough::create(m_scan, m_mesh, m_arena); }
    static std::vector<double> numbers_of(const Dough& tissue) {
        std::vector<double> numbers;
        tissue.state(numbers);
        return numbers;
    }
    static Vec3d place(const std::vector<double>& numbers, std::int32_t node) {
        const auto n = 3 * std::size_t(node);
        return {numbers[n], numbers[n + 1], numbers[n + 2]};
    }

    const TaskArena m_arena{1};
    Volume m_scan;
    TetMesh m_mesh;
    const Push m_push{.point_mm = {15, 13.5, 18}, .push_mm = {0.4, 0.3, -2}, .sphere_radius_mm = 3};
};

TEST_F(MeshTissues, OnesOwnIsPushedHeldUndoneAndReturns) {
    const auto tissue = make();
    const std::uint64_t at_rest = tissue->hash();
    tissue->begin_group("push");
    const auto report = tissue->push(kTool, m_push);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(tissue->end_group(), 0);
    EXPECT_EQ(report->status, PushStatus::Applied);
    EXPECT_EQ(report->step_fraction, 1);
    const auto held = tissue->held_by(kTool);
    EXPECT_EQ(report->grabbed_elements, std::int64_t(held.size()));
    ASSERT_GT(held.size(), 3u);
    EXPECT_GT(report->moved_elements, report->grabbed_elements);
    const std::vector<double> pushed = numbers_of(*tissue);
    int whole_way = 0;  // nodes that were in the sphere at first; others joined on its way
    for (const std::int32_t n : held) {
        const Vec3d moved = place(pushed, n) - m_mesh.nodes_mm[std::size_t(n)];
        EXPECT_GT(dot(moved, m_push.push_mm), 0);
        whole_way += norm(moved - m_push.push_mm) < 1e-12;
    }
    EXPECT_EQ(whole_way,
              std::count_if(m_mesh.nodes_mm.begin(), m_mesh.nodes_mm.end(), [&](Vec3d p) {
                  return norm(p - m_push.point_mm) <= m_push.sphere_radius_mm;
              }));
    EXPECT_GT(norm(tissue->deformation().displacement_mm({15, 13, 18})), 1);
    EXPECT_GT(deform_volume(*tissue)->written_voxels, 1000);

    // Another tool takes the nodes; the tissue keeps its shape under it, and returns without.
    Push still = m_push;
    still.point_mm = m_push.point_mm + m_push.push_mm;
    still.push_mm = {0, 0, 0};
    still.sphere_radius_mm = 6;
    ASSERT_TRUE(tissue->push(kOther, still).ok());
    EXPECT_FALSE(tissue->is_touched_by(kTool));
    const std::vector<double> taken = numbers_of(*tissue);
    ASSERT_TRUE(tissue->undo().ok());
    EXPECT_EQ(tissue->hash(), at_rest);
    ASSERT_TRUE(tissue->redo().ok());
    EXPECT_EQ(numbers_of(*tissue), taken);
    EXPECT_FALSE(tissue->is_touched());
    ASSERT_TRUE(tissue->advance({.max_steps = 5000})->settled);
    EXPECT_EQ(tissue->hash(), at_rest);
    std::vector<double> far = pushed;
    far[3 * pushed.size() / 6] += 600;
    EXPECT_EQ(tissue->set_state(far).error().code, ErrorCode::InvalidArgument);
}

TEST_F(MeshTissues, APushGoesOnInFinerStridesWhereOneFolds) {
    const auto tissue = make();
    Push far = m_push;
    far.push_mm = {0, 0, -40};
    const auto report = tissue->push(kTool, far);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->status, PushStatus::Limited);
    EXPECT_EQ(report->limited_by, LimitedBy::Fold);
    EXPECT_NE(report->message.find("would fold"), std::string::npos);
    const double longest = std::min(tissue->at_rest().edge_mm / 4, far.sphere_radius_mm / 2);
    const double strides = report->step_fraction * std::ceil(40 / longest);
    EXPECT_GT(std::abs(strides - std::round(strides)), 0.1) << strides;
    EXPECT_EQ(8 * strides, std::round(8 * strides)) << "not finer than an eighth";
    const std::vector<double> x = numbers_of(*tissue);
    for (std::size_t c = 0; c < m_mesh.cells.size(); ++c) {
        const auto at = [&](std::size_t n) { return place(x, m_mesh.cells[c][n]); };
        EXPECT_GE(dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))) / 6,
                  0.1 * tissue->at_rest().volumes_mm3[c]);
    }
}

TEST_F(MeshTissues, ACallThatFailsAtAnyStepHasChangedNothing) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->push(kOther, m_push).ok());
    const std::vector<double> before = numbers_of(*tissue);
    const std::vector<std::int32_t> held(tissue->held_by(kOther).begin(),
                                         tissue->held_by(kOther).end());
    Push next = m_push;
    next.point_mm = {12, 12, 17};
    next.push_mm = {2, 0, -1};
    int failed = 0;
    for (;; ++failed) {
        tissue->failing_step = tissue->steps + failed + 1;
        const auto report = tissue->push(kTool, next);
        if (report.ok()) break;
        EXPECT_EQ(report.error().code, ErrorCode::LimitExceeded);
        EXPECT_EQ(numbers_of(*tissue), before) << failed;
        EXPECT_FALSE(tissue->is_touched_by(kTool));
        EXPECT_TRUE(std::equal(held.begin(), held.end(), tissue->held_by(kOther).begin(),
                               tissue->held_by(kOther).end()));
        ASSERT_LT(failed, 100);
    }
    EXPECT_GT(failed, 2);
    EXPECT_NE(numbers_of(*tissue), before);
    for (const Push& bad : {Push{{0, 0, 0}, {0, 0, 501}, 1}, Push{{0, 0, 0}, {0, 0, 1}, -1},
                            Push{{std::nan(""), 0, 0}, {0, 0, 1}, 1}})
        EXPECT_EQ(tissue->push(kTool, bad).error().code, ErrorCode::InvalidArgument);
}

TEST_F(MeshTissues, WithoutASurfaceNothingSlidesAndAnEyeHasNoEffect) {
    const auto tissue = make();
    EXPECT_EQ(tissue->slide(kTool, m_push, {}).error().code, ErrorCode::Unsupported);
    EXPECT_TRUE(tissue->place_eye(kOther, {15, 13, 20}, 2).ok());
    EXPECT_FALSE(tissue->has_eye(kOther));
    EXPECT_FALSE(inverted_cell(rest_mesh(m_mesh)).has_value());
    TetMesh inverted = m_mesh;
    std::swap(inverted.cells[3][0], inverted.cells[3][1]);
    EXPECT_EQ(inverted_cell(rest_mesh(inverted)), std::size_t(3));
}

}  // namespace
}  // namespace pliant::test
