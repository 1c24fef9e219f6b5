// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cuts of bodies: conserved mass, the gap that opens, and undo.
// Covers: tissue/body_cut.cpp, tissue/body_tissue_cuts.cpp.

#include <gtest/gtest.h>
#include <pliant/mesh.h>
#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/hash.h"
#include "support/each_allocation.h"
#include "support/temporary_folder.h"
#include "tissue/body_tissue.h"

namespace pliant::test {
namespace {

constexpr std::uint32_t kHand = 3;
constexpr double kAir = -1000, kTissue = 50;
/// The bar that is cut: its left end lies in bone.
constexpr Vec3d kLow_mm{6, 6, 6}, kHigh_mm{30, 18, 18};
constexpr double kNoise_mm = 2e-5;  ///< of steps of a body at rest, in single precision
constexpr double kCut_mm = 17.3;    ///< plane of the cut along x, through tetrahedra and not nodes

Volume scan_of_bar() {
    Volume scan;
    scan.grid = {{40, 26, 26}, {1, 1, 1}};
    scan.background = float(kAir);
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < 26; ++k)
        for (int j = 0; j < 26; ++j)
            for (int i = 0; i < 40; ++i) {
                const bool inside = i >= 6 && i <= 30 && j >= 6 && j <= 18 && k >= 6 && k <= 18;
                voxels.push_back(std::int16_t(!inside ? kAir : i < 8 ? 900 : kTissue));
            }
    scan.voxels = std::move(voxels);
    return scan;
}

TetMesh bar() {
    TetMesh mesh = five_tet_block({8, 4, 4}, 3);
    for (Vec3d& node : mesh.nodes_mm) node = node + kLow_mm;
    return mesh;
}

/// A blade at kCut_mm from above. @param to_z  its lower edge
CutSurface blade(double to_z) {
    return {{{kCut_mm, 0, 25}, {kCut_mm, 25, 25}}, {0, 0, to_z - 25}};
}
const CutSurface kThrough = blade(0);

/// The right end of the bar, drawn away.
const Push kPull{.point_mm = {28, 12, 12}, .push_mm = {4, 0, 0}, .sphere_radius_mm = 4};

class BodyCuts : public testing::Test {
  protected:
    std::unique_ptr<BodyTissue> make(const TaskArena& arena) const {
        auto made = make_body(m_scan, m_mesh, m_settings, arena);
        EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
        return std::unique_ptr<BodyTissue>(dynamic_cast<BodyTissue*>(made->release()));
    }
    std::unique_ptr<BodyTissue> make() const { return make(m_arena); }
    static std::vector<double> numbers_of(const BodyTissue& tissue) {
        std::vector<double> numbers;
        tissue.state(numbers);
        return numbers;
    }
    static std::vector<Vec3d> positions_of(const BodyTissue& tissue) {
        std::vector<Vec3d> positions(std::size_t(tissue.node_count()));
        tissue.positions_mm(positions);
        return positions;
    }
    /// Whether a node belongs to the part to the left of the blade.
    static std::vector<bool> left_nodes(const BodyTissue& tissue) {
        const std::vector<std::int32_t> piece = pieces(tissue.cut_mesh()->mesh);
        const std::int32_t left = piece[0];  // node 0 is the corner at kLow_mm
        std::vector<bool> is_left;
        for (const std::int32_t p : piece) is_left.push_back(p == left);
        return is_left;
    }
    static double value(const Volume& volume, Vec3i p) { return double(volume.at(p)); }
    static std::int64_t tissue_voxels(const Volume& volume) {
        std::int64_t count = 0;
        for (int k = 0; k < 26; ++k)
            for (int j = 0; j < 26; ++j)
                for (int i = 0; i < 40; ++i) count += value(volume, {i, j, k}) > -500;
        return count;
    }

    const TaskArena m_arena{1};
    const Volume m_scan = scan_of_bar();
    const TetMesh m_mesh = bar();
    const BodySettings m_settings{.young_modulus_pa = 3000, .reach_mm = 12};
};

TEST(CutParts, MassAndStiffnessAreThoseOfTheWholeBody) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        TetMesh mesh = five_tet_block({3, 3, 3}, 3);
        PbdParts whole = *pbd_of_mesh(mesh, {.density = random.real(0.5, 2),
                                             .edge_compliance = 2e-4,
                                             .volume_compliance = 3e-5,
                                             .solids = true});
        for (const std::int32_t held : {0, 5, 6, 11}) whole.inverse_masses[std::size_t(held)] = 0;
        const std::vector<std::int32_t> solids(mesh.cells.size(), 0);
        std::optional<CutMesh> cut;
        for (int n = 0; n < 3; ++n) {
            const Vec3d from = Vec3d{4.5, 4.5, 4.5} + random.vector(3),
                        along = 20.0 * normalized(random.vector(1)),
                        depth = random.whole(0, 1) ? random.vector(20) : random.vector(4);
            const CutSurface surface{{from - along, from + along}, depth};
            auto next = cut ? cut_tetrahedra(*cut, cut->mesh.nodes_mm, surface)
                            : cut_tetrahedra(mesh, mesh.nodes_mm, surface);
            ASSERT_TRUE(next.ok()) << next.error().message;
            cut = std::move(*next);
        }
        ASSERT_GT(cut->mesh.cells.size(), mesh.cells.size());
        const PbdParts parts = cut_parts(whole, mesh.cells, solids, *cut);
        ASSERT_TRUE(PbdBody::create(parts, {}).ok());

        std::vector<double> masses(mesh.nodes_mm.size(), 0);
        for (std::size_t n = 0; n < parts.positions.size(); ++n) {
            const auto uncut = std::size_t(cut->uncut_node_of[n]);
            EXPECT_EQ(parts.positions[n], whole.positions[uncut]);
            if (whole.inverse_masses[uncut] > 0) masses[uncut] += 1 / parts.inverse_masses[n];
        }
        int held = 0;
        for (std::size_t n = 0; n < masses.size(); ++n) {
            if (whole.inverse_masses[n] > 0) {
                EXPECT_NEAR(masses[n] * whole.inverse_masses[n], 1, 1e-12) << "node " << n;
            }
            held += parts.inverse_masses[n] == 0;
        }
        EXPECT_EQ(held, 4) << "nodes keep the numbers of their material, which stays held";
        for (std::size_t n = masses.size(); n < parts.positions.size(); ++n)
            EXPECT_GT(parts.inverse_masses[n], 0) << "a copy without the node's material moves";

        std::vector<double> moduli(mesh.cells.size(), 0), bulk(mesh.cells.size(), 0);
        ASSERT_EQ(parts.solids.size(), cut->mesh.cells.size());
        ASSERT_EQ(parts.volumes.size(), cut->mesh.cells.size());
        std::map<std::array<std::int32_t, 4>, std::size_t> uncut_of;
        for (std::size_t c = 0; c < cut->mesh.cells.size(); ++c)
            uncut_of[cut->mesh.cells[c]] = std::size_t(cut->uncut_cell_of[c]);
        for (const PbdSolid& s : parts.solids) moduli[uncut_of.at(s.nodes)] += s.young_modulus;
        for (const PbdVolume& v : parts.volumes) bulk[uncut_of.at(v.nodes)] += 1 / v.compliance;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            EXPECT_NEAR(moduli[c] / 1e5, 1, 1e-12);
            EXPECT_NEAR(bulk[c] * 3e-5, 1, 1e-12);
        }
        std::map<std::pair<std::int32_t, std::int32_t>, double> stiffness;
        for (const PbdDistance& d : parts.distances)
            stiffness[std::minmax(cut->uncut_node_of[std::size_t(d.nodes[0])],
                                  cut->uncut_node_of[std::size_t(d.nodes[1])])] += 1 / d.compliance;
        EXPECT_EQ(stiffness.size(), whole.distances.size());
        EXPECT_GT(parts.distances.size(), whole.distances.size());
        for (const auto& [nodes, k] : stiffness) EXPECT_NEAR(k * 2e-4, 1, 1e-12);
    }
}

TEST(CutParts, AnAttachmentPullsTheCopyWithItsMaterial) {
    const TetMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
    PbdParts whole = *pbd_of_mesh(mesh, {.solids = true});
    whole.attachments = {{.nodes = {2, 3, 0, 1}, .weights = {0.1, 0.1, 0.7, 0.1}},
                         {.nodes = {1, 0, 2, 3}, .weights = {0.8, 0.1, 0.1, 0}},
                         {.nodes = {1, 0, 0, 0}}};
    const auto cut =
        cut_tetrahedra(mesh, mesh.nodes_mm, {{{0.5, -1, -1}, {0.5, 2, -1}}, {0, 0, 3}});
    ASSERT_TRUE(cut.ok());
    ASSERT_EQ(cut->mesh.cells.size(), 2u);
    const PbdParts parts = cut_parts(whole, mesh.cells, std::vector<std::int32_t>{0}, *cut);
    const auto holds = [&](const PbdAttachment& a, Vec3d at) {
        const std::int32_t copy = cut->copy_of(0, at);
        const auto& cell = cut->mesh.cells[std::size_t(copy)];
        for (std::size_t n = 0; n < 4; ++n)
            if (a.weights[n] != 0 && std::find(cell.begin(), cell.end(), a.nodes[n]) == cell.end())
                return false;
        return true;
    };
    EXPECT_TRUE(holds(parts.attachments[0], {0.1, 0.1, 0.1}));
    EXPECT_TRUE(holds(parts.attachments[1], {0.8, 0.1, 0}));
    EXPECT_TRUE(holds(parts.attachments[2], {1, 0, 0}));
    EXPECT_NE(cut->copy_of(0, {0.1, 0.1, 0.1}), cut->copy_of(0, {0.8, 0.1, 0}));
}

TEST_F(BodyCuts, ATissueWithoutCutsHasTheStateAndHashThatItAlwaysHad) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->push(kHand, kPull).ok());
    const std::vector<double> numbers = numbers_of(*tissue);
    ASSERT_EQ(numbers.size(), 6 * m_mesh.nodes_mm.size());
    EXPECT_EQ(tissue->cut_mesh(), nullptr);
    Hash64 hash;
    for (std::size_t n = 0; n < numbers.size(); n += 6) {
        const Vec3d pair[2] = {{numbers[n], numbers[n + 1], numbers[n + 2]},
                               {numbers[n + 3], numbers[n + 4], numbers[n + 5]}};
        hash.add(std::span<const Vec3d>(pair));
    }
    EXPECT_EQ(tissue->hash(), hash.value());
}

TEST_F(BodyCuts, AHalfThatIsCutOffLeavesTheOtherAtRest) {
    const auto tissue = make();
    const auto report = tissue->cut(kThrough);
    ASSERT_TRUE(report.ok()) << report.error().message;
    // One link for each voxel of the section, and some around it that the bar carries.
    EXPECT_GE(report->cut_links, 13 * 13);
    EXPECT_LE(report->cut_links, 26 * 26);
    ASSERT_NE(tissue->cut_mesh(), nullptr);
    EXPECT_EQ(tissue->cut_mesh()->pieces, 2);
    const std::vector<Vec3d> rest = positions_of(*tissue);
    EXPECT_EQ(state_of(*tissue)->moved_elements, 0) << "nothing jumps";
    EXPECT_EQ(hash_volume(deform_volume(*tissue)->volume), hash_volume(m_scan));

    const auto pulled = tissue->push(kHand, kPull);
    ASSERT_TRUE(pulled.ok());
    ASSERT_EQ(pulled->status, PushStatus::Applied) << pulled->message;
    for (int n = 0; n < 40; ++n) ASSERT_TRUE(tissue->sweep().ok());
    const std::vector<Vec3d> now = positions_of(*tissue);
    const std::vector<bool> is_left = left_nodes(*tissue);
    double least = 1e9, most = 0;
    for (std::size_t n = 0; n < rest.size(); ++n) {
        if (is_left[n]) {
            ASSERT_LT(norm(now[n] - rest[n]), kNoise_mm) << "node " << n;
        } else {
            least = std::min(least, now[n].x - rest[n].x);
            most = std::max(most, now[n].x - rest[n].x);
        }
    }
    EXPECT_NEAR(least, 4, 0.1) << "the free half moves as a whole";
    EXPECT_NEAR(most, 4, 0.1);

    // The scan: the left voxels rest, the gap is air, and no tissue is lost beside it.
    ASSERT_TRUE(tissue->update_deformation().ok());
    const Volume deformed = deform_volume(*tissue)->volume;
    for (int k = 6; k <= 18; ++k)
        for (int j = 6; j <= 18; ++j) {
            for (int i = 6; i <= 17; ++i) {
                EXPECT_LT(norm(tissue->deformation().displacement_mm({i, j, k})), kNoise_mm);
                EXPECT_EQ(value(deformed, {i, j, k}), value(m_scan, {i, j, k}));
            }
            for (int i = 18; i <= 21; ++i) EXPECT_EQ(value(deformed, {i, j, k}), kAir) << i;
        }
    for (int i = 23; i <= 33; ++i) EXPECT_NEAR(value(deformed, {i, 12, 12}), kTissue, 1) << i;
    EXPECT_GE(tissue_voxels(deformed), tissue_voxels(m_scan) - 13 * 13);
}

TEST_F(BodyCuts, ACutEndOpensUnderAPullAndTheRestHangsTogether) {
    const Push up{.point_mm = {29, 12, 16}, .push_mm = {4, 0, 0}, .sphere_radius_mm = 5};
    const auto air_near = [&](const Volume& volume, int k) {
        int count = 0;
        for (int i = 10; i <= 26; ++i) count += value(volume, {i, 12, k}) < -500;
        return count;
    };
    const auto whole = make(), half = make();
    const auto report = half->cut(blade(11.5));
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_GT(report->cut_links, 5 * 13);
    EXPECT_LT(report->cut_links, 20 * 26) << "the tip ends between two tetrahedra";
    EXPECT_EQ(half->cut_mesh()->pieces, 1);
    for (BodyTissue* tissue : {whole.get(), half.get()}) {
        ASSERT_TRUE(tissue->push(kHand, up).ok());
        for (int n = 0; n < 40; ++n) ASSERT_TRUE(tissue->sweep().ok());
    }
    const Volume uncut = deform_volume(*whole)->volume, open = deform_volume(*half)->volume;
    for (int k = 7; k <= 17; ++k) EXPECT_EQ(air_near(uncut, k), 0) << k;
    EXPECT_GE(air_near(open, 17), 2) << "the gap";
    EXPECT_GE(air_near(open, 17), air_near(open, 14));
    for (int k = 7; k <= 8; ++k) EXPECT_EQ(air_near(open, k), 0) << k;
    // The left end is held, and the bar still pulls.
    EXPECT_GT(norm(*half->force_n(kHand)), 1e-3);
    EXPECT_LT(norm(*half->force_n(kHand)), norm(*whole->force_n(kHand)));
    EXPECT_GT(tissue_voxels(open), tissue_voxels(m_scan) - 2 * 13 * 13);
}

TEST_F(BodyCuts, SeparatedPartsPushEachOther) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->cut(kThrough).ok());
    Push press = kPull;
    press.push_mm = {-3, 0, 0};
    const auto pressed = tissue->push(kHand, press);
    ASSERT_TRUE(pressed.ok());
    ASSERT_EQ(pressed->status, PushStatus::Applied) << pressed->message;
    for (int n = 0; n < 40; ++n) ASSERT_TRUE(tissue->sweep().ok());
    const std::vector<Vec3d> now = positions_of(*tissue), rest = tissue->cut_mesh()->mesh.nodes_mm;
    const std::vector<bool> is_left = left_nodes(*tissue);
    double left = 0;
    for (std::size_t n = 0; n < now.size(); ++n)
        if (is_left[n]) left = std::max(left, rest[n].x - now[n].x);
    EXPECT_GT(left, 0.5) << "the left part gives way";
    EXPECT_GT(tissue->force_n(kHand)->x, 1e-3);
}

TEST_F(BodyCuts, AHeldNodesCopyWithoutItsMaterialIsFree) {
    // Between the held nodes at x = 6 and the next ones at 9.
    const auto tissue = make();
    ASSERT_TRUE(tissue->cut({{{7.5, 0, 25}, {7.5, 25, 25}}, {0, 0, -25}}).ok());
    ASSERT_EQ(tissue->cut_mesh()->pieces, 2);
    ASSERT_TRUE(tissue->push(kHand, kPull).ok());
    for (int n = 0; n < 60; ++n) ASSERT_TRUE(tissue->sweep().ok());
    const std::vector<Vec3d> now = positions_of(*tissue);
    const std::vector<bool> is_left = left_nodes(*tissue);
    for (std::size_t n = 0; n < now.size(); ++n) {
        const Vec3d by = now[n] - tissue->cut_mesh()->mesh.nodes_mm[n];
        if (is_left[n]) {
            EXPECT_LT(norm(by), kNoise_mm);
        } else {
            EXPECT_NEAR(by.x, 4, 0.1);
        }
    }
}

TEST_F(BodyCuts, AToolHoldsThePartThatItHeldAndGrabsMaterialAlone) {
    const auto tissue = make();
    Push middle{.point_mm = {18, 12, 18}, .push_mm = {0, 0, 1}, .sphere_radius_mm = 3.5};
    const auto held = tissue->push(kHand, middle);
    ASSERT_TRUE(held.ok());
    ASSERT_TRUE(tissue->cut(kThrough).ok());
    EXPECT_TRUE(tissue->is_touched_by(kHand));
    const std::vector<Vec3d> before = positions_of(*tissue);
    ASSERT_TRUE(tissue->sweep().ok());
    int still = 0;
    for (std::size_t n = 0; n < before.size(); ++n)
        still += positions_of(*tissue)[n] == before[n] && before[n].z > 18.5;
    EXPECT_GT(still, held->grabbed_elements) << "and the copies of its nodes";
    // A point in the right half of a tetrahedron that the blade splits.
    const auto fresh = make();
    ASSERT_TRUE(fresh->cut(kThrough).ok());
    ASSERT_TRUE(fresh->push(kHand, {.point_mm = {17.6, 12.2, 12.3}, .push_mm = {2, 0, 0}}).ok());
    for (int n = 0; n < 40; ++n) ASSERT_TRUE(fresh->sweep().ok());
    const std::vector<bool> is_left = left_nodes(*fresh);
    const std::vector<Vec3d> now = positions_of(*fresh);
    for (std::size_t n = 0; n < now.size(); ++n) {
        if (is_left[n]) {
            ASSERT_LT(norm(now[n] - fresh->cut_mesh()->mesh.nodes_mm[n]), kNoise_mm);
        } else {
            EXPECT_GT(now[n].x - fresh->cut_mesh()->mesh.nodes_mm[n].x, 1);
        }
    }
}

TEST_F(BodyCuts, AreUndoneRedoneSavedAndLoaded) {
    const TemporaryFolder folder;
    const auto tissue = make();
    const std::uint64_t at_rest = tissue->hash();
    std::vector<std::uint64_t> hashes, volumes;
    const auto step = [&](const char* name, const auto& work) {
        tissue->begin_group(name);
        work();
        EXPECT_EQ(tissue->end_group(), 0);
        ASSERT_TRUE(tissue->rest().ok());
        hashes.push_back(tissue->hash());
        volumes.push_back(hash_volume(deform_volume(*tissue)->volume));
    };
    step("push", [&] { ASSERT_TRUE(tissue->push(kHand, kPull).ok()); });
    step("cut", [&] { ASSERT_TRUE(tissue->cut(blade(11.5)).ok()); });
    step("push", [&] { ASSERT_TRUE(tissue->push(kHand, kPull).ok()); });
    step("cut", [&] { ASSERT_TRUE(tissue->cut(kThrough).ok()); });
    step("pull", [&] { ASSERT_TRUE(tissue->push(kHand, kPull).ok()); });
    ASSERT_EQ(tissue->undo_steps(), 5);
    EXPECT_EQ(hashes.size(), 5u);
    ASSERT_TRUE(tissue->save_state(folder / "cut").ok());
    for (int round = 0; round < 2; ++round) {
        for (std::size_t n = 4; n-- > 0;) {
            ASSERT_TRUE(tissue->undo().ok());
            EXPECT_EQ(tissue->hash(), hashes[n]) << n;
            EXPECT_EQ(hash_volume(deform_volume(*tissue)->volume), volumes[n]) << n;
        }
        ASSERT_TRUE(tissue->undo().ok());
        EXPECT_EQ(tissue->hash(), at_rest);
        EXPECT_EQ(tissue->cut_mesh(), nullptr);
        EXPECT_EQ(hash_volume(deform_volume(*tissue)->volume), hash_volume(m_scan));
        EXPECT_EQ(state_of(*tissue)->cut_links, 0);
        for (std::size_t n = 0; n < 5; ++n) {
            ASSERT_TRUE(tissue->redo().ok());
            EXPECT_EQ(tissue->hash(), hashes[n]) << n;
            EXPECT_EQ(hash_volume(deform_volume(*tissue)->volume), volumes[n]) << n;
        }
    }
    // Another tissue makes all cuts anew, and goes on alike.
    for (const int threads : {1, 2}) {
        const TaskArena arena(threads);
        const auto twin = make(arena), original = make();
        ASSERT_TRUE(twin->load_state(folder / "cut").ok());
        ASSERT_TRUE(original->load_state(folder / "cut").ok());
        EXPECT_EQ(twin->hash(), hashes[4]);
        EXPECT_EQ(numbers_of(*twin), numbers_of(*tissue));
        EXPECT_EQ(hash_volume(deform_volume(*twin)->volume), volumes[4]);
        for (int n = 0; n < 4; ++n) {
            ASSERT_TRUE(original->sweep().ok());
            ASSERT_TRUE(twin->sweep().ok());
            ASSERT_EQ(twin->hash(), original->hash()) << threads << " threads, sweep " << n;
        }
    }
    // A free body returns to rest, with its cuts.
    const auto settled = tissue->advance({.max_steps = 5000});
    ASSERT_TRUE(settled.ok());
    ASSERT_TRUE(tissue->reset().ok());
    EXPECT_EQ(state_of(*tissue)->moved_elements, 0);
    EXPECT_GT(state_of(*tissue)->cut_links, 100);
}

TEST_F(BodyCuts, HaveTheSameBitsForAnyNumberOfThreads) {
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 4}) {
        const TaskArena arena(threads);
        const auto tissue = make(arena);
        ASSERT_TRUE(
            tissue
                ->push(kHand,
                       {.point_mm = {20, 12, 18}, .push_mm = {1, 0, 2}, .sphere_radius_mm = 4})
                .ok());
        ASSERT_TRUE(tissue->cut(blade(8)).ok());
        ASSERT_TRUE(tissue->push(kHand, kPull).ok());
        for (int n = 0; n < 5; ++n) ASSERT_TRUE(tissue->sweep().ok());
        hashes.push_back(tissue->hash());
        hashes.push_back(tissue->deformation().hash());
        hashes.push_back(hash_volume(deform_volume(*tissue)->volume));
    }
    for (std::size_t n = 3; n < hashes.size(); ++n) EXPECT_EQ(hashes[n], hashes[n % 3]);
}

TEST_F(BodyCuts, ABadCutLeavesAllAsItWas) {
    const auto tissue = make();
    ASSERT_TRUE(tissue->push(kHand, kPull).ok());
    ASSERT_TRUE(tissue->cut(blade(11.5)).ok());
    const std::vector<double> before = numbers_of(*tissue);
    const std::uint64_t hash = tissue->hash(), field = tissue->deformation().hash();
    for (const CutSurface& bad :
         {CutSurface{{{1, 2, 3}}, {0, 0, 1}}, CutSurface{{{1, 2, 3}, {1, 2, 4}}, {0, 0, 1}},
          CutSurface{{{1, 2, 3}, {std::nan(""), 2, 4}}, {0, 0, 1}},
          CutSurface{{{1, 2, 3}, {1, 5, 4}}, {0, 0, 1e9}}}) {
        const auto report = tissue->cut(bad);
        ASSERT_FALSE(report.ok());
        EXPECT_EQ(report.error().field, "cut") << report.error().message;
    }
    // Beside the body, and again along the same ribbon, nothing happens.
    const auto beside = tissue->cut({{{1, 0, 0}, {1, 25, 0}}, {0, 0, 25}});
    ASSERT_TRUE(beside.ok());
    EXPECT_EQ(beside->cut_links, 0);
    EXPECT_EQ(numbers_of(*tissue), before);
    EXPECT_EQ(tissue->hash(), hash);
    EXPECT_EQ(tissue->deformation().hash(), field);
    EXPECT_TRUE(tissue->is_touched_by(kHand));
    // States with damaged cuts.
    const std::size_t at = 6 * m_mesh.nodes_mm.size();
    for (const auto& [place, number] : {std::pair<std::size_t, double>{at, -1.0},
                                        {at, 1e300},
                                        {at, before[at] - 1},
                                        {at, std::nan("")},
                                        {at + 1, 7},
                                        {at + 1, 1e18},
                                        {at + 2, std::nan("")},
                                        {at + 11, 3},
                                        {at + 13, 1e7}}) {
        std::vector<double> damaged = before;
        damaged[place] = number;
        const Status set = tissue->set_state(damaged);
        ASSERT_FALSE(set.ok()) << place - at;
        EXPECT_EQ(set.error().code, ErrorCode::InvalidArgument);
        EXPECT_EQ(numbers_of(*tissue), before);
    }
    std::vector<double> shorter = before;
    shorter.resize(shorter.size() - 6);
    EXPECT_FALSE(tissue->set_state(shorter).ok());
    EXPECT_EQ(tissue->hash(), hash);
    // Bends have no copies.
    auto parts = *pbd_of_mesh(m_mesh, {.density = 1e-3, .bend_compliance = 1, .bends = true});
    auto bent =
        make_body(m_scan, PbdBody::create(std::move(parts), {}).value(), m_settings, m_arena);
    ASSERT_TRUE(bent.ok());
    EXPECT_EQ((*bent)->cut(kThrough).error().code, ErrorCode::Unsupported);
}

TEST_F(BodyCuts, ACutThatRanOutOfMemoryLeavesNoTrace) {
    const auto make = [&] {
        auto tissue = this->make();
        tissue->begin_group("push");
        EXPECT_TRUE(tissue->push(kHand, kPull).ok());
        EXPECT_EQ(tissue->end_group(), 0);
        return tissue;
    };
    const auto state = [](const BodyTissue& tissue) {
        return std::tuple(tissue.hash(), tissue.deformation().hash(), tissue.node_count(),
                          tissue.is_touched_by(kHand), tissue.undo_steps());
    };
    const EachAllocation some{.all_up_to = 40, .of_the_rest = 80};
    const CutSurface surface = blade(11.5);
    const auto cut = [&](BodyTissue& tissue) { return tissue.cut(surface); };
    const Failures failures = fail_each_allocation(make, cut, state, some);
    EXPECT_GT(failures.failed, 60);
    const auto later = [](BodyTissue& tissue) {
        for (int n = 0; n < 3; ++n) EXPECT_TRUE(tissue.sweep().ok());
        return std::pair(tissue.hash(), hash_volume(deform_volume(tissue)->volume));
    };
    const auto calm = make();
    const auto expected = later(*calm);
    for (const std::int64_t n : chosen(failures.allocations, {.all_up_to = 5, .of_the_rest = 20})) {
        auto tissue = make();
        bool ok = false;
        {
            const FailingAllocation failing(n);
            ok = cut(*tissue).ok();
        }
        if (!ok) {
            ASSERT_EQ(later(*tissue), expected) << "allocation " << n;
        }
    }
    const auto made_and_cut = [&] {
        auto tissue = make();
        tissue->begin_group("cut");
        EXPECT_TRUE(tissue->cut(kThrough).ok());
        EXPECT_EQ(tissue->end_group(), 0);
        return tissue;
    };
    fail_each_allocation(
        made_and_cut, [](BodyTissue& tissue) { return tissue.undo(); }, state, some);
}

}  // namespace
}  // namespace pliant::test
