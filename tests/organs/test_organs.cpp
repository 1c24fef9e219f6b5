// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scenes of organs: their files, what is held, bodies that push each other, and the labelled organs
// of a scan in their surroundings.
// Covers: organs/*.cpp.

#include <gtest/gtest.h>
#include <pliant/core/files.h>
#include <pliant/mesh.h>
#include <pliant/mesh_files.h>
#include <pliant/models/organs.h>
#include <pliant/models/pbd.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "organs/label_names.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

constexpr std::uint32_t kHand = 1;

/// A block of 20 × 20 × 20 mm that begins at a corner.
TetMesh block_at(Vec3d corner) {
    TetMesh block = five_tet_block({4, 4, 4}, 5);
    for (Vec3d& p : block.nodes_mm) p = p + corner;
    return block;
}

std::vector<Vec3d> positions_of(const MeshTissue& tissue) {
    std::vector<Vec3d> positions(std::size_t(tissue.node_count()));
    tissue.positions_mm(positions);
    return positions;
}

/// Nodes of one mesh that lie in the tetrahedra of another by more than a depth: brute force.
int nodes_inside(std::span<const Vec3d> nodes, const TetMesh& other, double depth_mm) {
    const auto surface = SurfaceDistance::create(boundary_triangles(other));
    EXPECT_TRUE(surface.ok());
    return int(std::count_if(nodes.begin(), nodes.end(),
                             [&](Vec3d p) { return surface->signed_mm(p) < -depth_mm; }));
}

class Organs : public testing::Test {
  protected:
    Organs() {
        EXPECT_TRUE(write_vtu(m_folder / "left.vtu", block_at({0, 0, 0})).ok());
        EXPECT_TRUE(
            write_surface(m_folder / "right.stl", boundary_triangles(block_at({20.5, 2, 2}))).ok());
    }
    void write(const std::string& text) const { std::ofstream(m_folder / "scene.toml") << text; }
    Result<OrganFile> read() const { return read_organ_file((m_folder / "scene.toml").string()); }
    std::string fault() const {
        const auto file = read();
        if (file.ok()) return "none";
        const std::string place = (m_folder / "scene.toml").string() + ": ";
        EXPECT_EQ(file.error().message.substr(0, place.size()), place);
        return file.error().message.substr(place.size());
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
};

constexpr const char* kTwo = R"([organs]
tetrahedra = 2000
damping_per_s = 20

[[body]]
name = "left"
mesh = "left.vtu"
held_mm = [[-1, -1, -1], [1, 21, 21]]

[[body]]
mesh = "right.stl"
law = "distances"
young_modulus_pa = 8000
)";

TEST_F(Organs, AFileHasItsBodies) {
    write(kTwo);
    const auto file = read();
    ASSERT_TRUE(file.ok()) << file.error().message;
    EXPECT_TRUE(is_organ_file(m_folder / "scene.toml"));
    ASSERT_EQ(file->bodies.size(), 2u);
    EXPECT_EQ(file->bodies[0].name, "left");
    EXPECT_EQ(file->bodies[1].name, "body 2");
    EXPECT_EQ(file->bodies[1].law, BodyLaw::Distances);
    EXPECT_EQ(file->bodies[1].mesh, (m_folder / "right.stl").string());
    EXPECT_EQ(file->damping_per_s, 20);
}

TEST_F(Organs, FaultsNameTheKey) {
    const auto said = [&](const std::string& text) {
        write(text);
        return fault();
    };
    EXPECT_EQ(said("[organs]\nfriction = 0.1\n"),
              "[[body]]: expected one or more of these tables, found none");
    EXPECT_EQ(said("[[body]]\nname = \"a\"\n"),
              "[[body]] 1: expected a mesh, or labels of the label volume, found neither");
    EXPECT_EQ(said("[[body]]\nlabels = 3\n"),
              "[[body]] 1 labels: expected a label_volume in [organs], found none");
    EXPECT_EQ(said("[[body]]\nmesh = \"a\"\nheld_mm = [[0, 0, 0]]\n"),
              "[[body]] 1 held_mm: expected two opposite corners for each box, found 1 points");
    EXPECT_EQ(said("[wall]\n[[body]]\nmesh = \"a\"\n"),
              "[wall]: expected [organs], [[body]] and [[contents]], found another table");
    EXPECT_EQ(said("[organs]\nsurroundings = true\n[[body]]\nmesh = \"a\"\n"),
              "[organs] surroundings: expected a scan and a label_volume, found no scan");
    EXPECT_EQ(said("[[contents]]\nvalue_hu = 3\n[[body]]\nmesh = \"a\"\n"),
              "[[contents]] 1: expected a surface, in a scene without a scan, found no surface");
    EXPECT_NE(said("[[body]]\nmesh = \"a\"\nyoung = 3\n").find("[[body]] 1 young"),
              std::string::npos);
    write("[vessel]\nphantom = \"bend\"\n");
    EXPECT_FALSE(is_organ_file(m_folder / "scene.toml"));
}

TEST_F(Organs, ABodyPushesTheOtherWithoutOverlap) {
    write(kTwo);
    const auto made = make_organs(*read(), m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    const auto one = make_tissue(*made, made->scan, m_arena);
    ASSERT_TRUE(one.ok()) << one.error().message;
    MeshTissue& tissue = **one;
    const std::vector<Vec3d> rest = positions_of(tissue);
    const std::size_t left = made->organs[0].mesh.nodes_mm.size();
    ASSERT_EQ(rest.size(), left + made->organs[1].mesh.nodes_mm.size());

    // The right block is pushed to the left from its far side.
    const auto report = tissue.push(
        kHand, {.point_mm = {40, 12, 12}, .push_mm = {-3, 0, 0}, .sphere_radius_mm = 6});
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->status, PushStatus::Applied) << report->message;
    for (int n = 0; n < 30; ++n) ASSERT_TRUE(tissue.sweep().ok());
    const std::vector<Vec3d> now = positions_of(tissue);
    double moved_left = 0, held = 0;
    for (std::size_t n = 0; n < left; ++n) {
        moved_left = std::max(moved_left, rest[n].x - now[n].x);
        if (rest[n].x <= 1) held = std::max(held, norm(now[n] - rest[n]));
    }
    EXPECT_EQ(held, 0) << "the box's nodes don't move";
    EXPECT_GT(moved_left, 0.5) << "the left block gives way";
    const TetMesh moved{{now.begin(), now.begin() + std::ptrdiff_t(left)},
                        made->organs[0].mesh.cells};
    EXPECT_EQ(nodes_inside(std::span<const Vec3d>(now).subspan(left), moved, 0.3), 0);

    // The scan follows each body, and a return to rest is complete.
    ASSERT_TRUE(tissue.update_deformation().ok());
    const Vec3d at = voxel_from_world(made->scan.grid, {35, 12, 12});
    EXPECT_LT(tissue.deformation()
                  .displacement_mm(
                      {int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))})
                  .x,
              -1);
    ASSERT_TRUE(tissue.reset().ok());
    EXPECT_EQ(positions_of(tissue), rest);
    EXPECT_EQ(state_of(tissue)->moved_elements, 0);
}

TEST_F(Organs, OrgansThatOverlapAtRestDoNotMoveWithoutATool) {
    ASSERT_TRUE(write_vtu(m_folder / "over.vtu", block_at({19, 1.5, 0.7})).ok());
    write("[[body]]\nmesh = \"left.vtu\"\n[[body]]\nmesh = \"over.vtu\"\n");
    const auto made = make_organs(*read(), m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    auto tissue = make_tissue(*made, made->scan, m_arena).value();
    const std::vector<Vec3d> rest = positions_of(*tissue);
    for (int n = 0; n < 5; ++n) {
        // A tool in air that isn't pushed makes the tissue step.
        ASSERT_TRUE(tissue->push(kHand, {.point_mm = {80, 0, 0}, .sphere_radius_mm = 1}).ok());
        const auto swept = tissue->sweep();
        ASSERT_TRUE(swept.ok());
        EXPECT_FALSE(swept->settled);
    }
    const std::vector<Vec3d> now = positions_of(*tissue);
    double most = 0;
    for (std::size_t n = 0; n < rest.size(); ++n) most = std::max(most, norm(now[n] - rest[n]));
    EXPECT_LT(most, 5e-4) << "rounding alone moves nodes";
}

TEST_F(Organs, AFreeOrganGoesNoFartherThanTheToolAndRests) {
    // A bar of 80 mm that nothing else holds, pushed at an end.
    TetMesh bar = five_tet_block({16, 2, 2}, 5);
    ASSERT_TRUE(write_vtu(m_folder / "bar.vtu", bar).ok());
    write("[[body]]\nmesh = \"bar.vtu\"\nyoung_modulus_pa = 5000\n");
    const auto made = make_organs(*read(), m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    auto tissue = make_tissue(*made, made->scan, m_arena).value();
    const std::vector<Vec3d> rest = positions_of(*tissue);
    constexpr double kWay_mm = 10;
    const auto report = tissue->push(
        kHand, {.point_mm = {5, -2, 5}, .push_mm = {0, kWay_mm, 0}, .sphere_radius_mm = 8});
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->status, PushStatus::Applied) << report->message;
    double farthest = 0;
    bool settled = false;
    int sweeps = 0;
    for (; sweeps < 400 && !settled; ++sweeps) {
        const auto swept = tissue->sweep();
        ASSERT_TRUE(swept.ok());
        settled = swept->settled;
        const std::vector<Vec3d> now = positions_of(*tissue);
        for (std::size_t n = 0; n < rest.size(); ++n)
            farthest = std::max(farthest, norm(now[n] - rest[n]));
    }
    EXPECT_TRUE(settled);
    EXPECT_GT(farthest, 0.99 * kWay_mm);
    EXPECT_LT(farthest, 1.1 * kWay_mm);
    // Released, it stays or returns, and nothing is felt.
    tissue->release(kHand);
    EXPECT_EQ(*tissue->force_n(kHand), (Vec3d{0, 0, 0}));
    const auto released = tissue->advance({.max_steps = 600});
    ASSERT_TRUE(released.ok());
    EXPECT_TRUE(released->settled);
}

TEST_F(Organs, ASlideKeepsTheBodyOutOfTheSphereAndIsFelt) {
    std::string scene = kTwo;  // held from below, so that it can't tilt
    const std::string box = "[1, 21, 21]";
    write(scene.replace(scene.find(box), box.size(), "[21, 21, 1]"));
    const auto made = make_organs(*read(), m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    std::uint64_t hash = 0;
    for (const int threads : {1, 4}) {
        const TaskArena arena(threads);
        auto tissue = make_tissue(*made, made->scan, arena).value();
        tissue->begin_group("slide");
        const double radius = 5;
        const Push way{
            .point_mm = {10, 10, 32}, .push_mm = {0, 0, -10}, .sphere_radius_mm = radius};
        const auto report = tissue->slide(kHand, way, {});
        ASSERT_TRUE(report.ok()) << report.error().message;
        EXPECT_EQ(report->way_fraction, 1);
        EXPECT_GT(report->contacts, 0);
        EXPECT_FALSE(report->ends_in_tissue);
        for (int n = 0; n < 20; ++n) ASSERT_TRUE(tissue->sweep().ok());
        const auto now = positions_of(*tissue);
        const std::size_t left = made->organs[0].mesh.nodes_mm.size();
        const TetMesh moved{{now.begin(), now.begin() + std::ptrdiff_t(left)},
                            made->organs[0].mesh.cells};
        const double distance =
            SurfaceDistance::create(boundary_triangles(moved)).value().signed_mm(report->end_mm);
        EXPECT_GT(distance, radius - 0.1);
        EXPECT_LT(distance, radius + 0.2) << "the sphere is in contact";
        EXPECT_TRUE(tissue->is_touched_by(kHand));
        const auto force = tissue->force_n(kHand);
        ASSERT_TRUE(force.has_value());
        EXPECT_GT(force->z, 0.01) << "against the way";
        EXPECT_LT(std::hypot(force->x, force->y), 0.3 * force->z);
        // Away from the body nothing is felt any more.
        const auto away = tissue->slide(
            kHand, {.point_mm = report->end_mm, .push_mm = {0, 0, 30}, .sphere_radius_mm = radius},
            {});
        ASSERT_TRUE(away.ok());
        EXPECT_EQ(away->way_fraction, 1);
        EXPECT_EQ(*tissue->force_n(kHand), (Vec3d{0, 0, 0}));
        (void)tissue->end_group();
        if (hash != 0) {
            EXPECT_EQ(tissue->hash(), hash) << threads << " threads";
        }
        hash = tissue->hash();
        const auto rest = tissue->undo();
        ASSERT_TRUE(rest.ok());
        EXPECT_FALSE(tissue->is_touched());
        EXPECT_EQ(state_of(*tissue)->moved_elements, 0);

        // Beside the body nothing happens.
        const auto beside = tissue->slide(
            kHand, {.point_mm = {10, 10, 60}, .push_mm = {20, 0, 0}, .sphere_radius_mm = radius},
            {});
        ASSERT_TRUE(beside.ok());
        EXPECT_EQ(beside->contacts, 0);
        EXPECT_EQ(state_of(*tissue)->moved_elements, 0);
        EXPECT_FALSE(tissue->slide(kHand, {.push_mm = {1, 0, 0}}, {}).ok()) << "no sphere";
    }
}

// Each time step begins with the forces of the last sub-step, though these aren't in the state.
// Those of the present shape would throw the nodes of the small body in each step.
TEST_F(Organs, ASmallBodyThatOthersSqueezeComesToRest) {
    TetMesh small = five_tet_block({3, 3, 3}, 2);
    for (Vec3d& p : small.nodes_mm) p = p + Vec3d{20, 7, 7};
    ASSERT_TRUE(write_vtu(m_folder / "small.vtu", small).ok());
    ASSERT_TRUE(write_vtu(m_folder / "right.vtu", block_at({26, 0, 0})).ok());
    write(R"([organs]
friction = 0.5
damping_per_s = 20

[[body]]
mesh = "left.vtu"
held_mm = [[-1, -1, -1], [1, 21, 21]]

[[body]]
mesh = "small.vtu"
young_modulus_pa = 2000

[[body]]
mesh = "right.vtu"
)");
    const auto made = make_organs(*read(), m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    std::uint64_t hash = 0;
    for (const int threads : {1, 4}) {
        const TaskArena arena(threads);
        auto tissue = make_tissue(*made, made->scan, arena).value();
        const auto slid = tissue->slide(
            kHand, {.point_mm = {56, 10, 10}, .push_mm = {-16, 0, 0}, .sphere_radius_mm = 8}, {});
        ASSERT_TRUE(slid.ok());
        EXPECT_GT(slid->way_fraction, 0.4);
        const auto first = made->organs[0].mesh.nodes_mm.size();
        const auto width = [&] {
            const std::vector<Vec3d> x = positions_of(*tissue);
            double low = 1e9, high = -1e9;
            for (std::size_t n = first; n < first + small.nodes_mm.size(); ++n) {
                low = std::min(low, x[n].x);
                high = std::max(high, x[n].x);
            }
            return high - low;
        };
        int sweeps = 0;
        for (bool settled = false; sweeps < 100 && !settled; ++sweeps) {
            const auto swept = tissue->sweep();
            ASSERT_TRUE(swept.ok());
            EXPECT_EQ(swept->message, "");
            settled = swept->settled;
        }
        EXPECT_LT(sweeps, 100);
        EXPECT_LT(width(), 5) << "it is squeezed from 6 mm";
        if (hash != 0) {
            EXPECT_EQ(tissue->hash(), hash) << threads << " threads";
        }
        hash = tissue->hash();
    }
}

TEST_F(Organs, ABodyOfSpringsIsTheNetworkOfItsModuli) {
    write(R"([organs]
damping_per_s = 20
[[body]]
mesh = "left.vtu"
law = "springs"
young_modulus_pa = 9000
poisson_ratio = 0.4
density_kg_m3 = 1100
held_mm = [[-1, -1, -1], [21, 21, 1]]
)");
    const auto made = make_organs(*read(), m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    const auto tissue = make_tissue(*made, made->scan, m_arena);
    ASSERT_TRUE(tissue.ok()) << tissue.error().message;
    // Link by link: (√2/5)·µ·length for each tetrahedron around it; λ − µ.
    const TetMesh& mesh = made->organs[0].mesh;
    const double mu = 9000 / (2 * 1.4), lambda = 9000 * 0.4 / (1.4 * 0.2);
    SpringParts parts;
    for (const Vec3d& p : mesh.nodes_mm)
        parts.nodes.push_back({.rest = p, .mass = 0, .fixed = p.z <= 1});
    std::map<std::pair<std::int32_t, std::int32_t>, double> links;
    for (const auto& cell : mesh.cells) {
        const auto at = [&](std::size_t n) { return mesh.nodes_mm[std::size_t(cell[n])]; };
        const double volume = dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))) / 6;
        for (std::size_t a = 0; a < 4; ++a) {
            parts.nodes[std::size_t(cell[a])].mass += 1.1e-3 * volume / 4;
            for (std::size_t b = a + 1; b < 4; ++b)
                links[std::minmax(cell[a], cell[b])] +=
                    std::sqrt(2.0) / 5 * mu * norm(at(a) - at(b));
        }
        parts.cells.push_back(
            {.nodes = {cell[0], cell[1], cell[2], cell[3]}, .node_count = 4, .bulk = lambda - mu});
    }
    for (SpringNode& node : parts.nodes) node.damping = 20 * node.mass;
    for (const auto& [nodes, k] : links)
        parts.links.push_back({.a = nodes.first, .b = nodes.second, .stiffness = k});
    const auto plain = make_network(made->scan, parts, {}, m_arena);
    ASSERT_TRUE(plain.ok()) << plain.error().message;
    const Push push{.point_mm = {10, 10, 20}, .push_mm = {1.5, 0, -2}, .sphere_radius_mm = 6};
    for (Tissue* t : {static_cast<Tissue*>(tissue->get()), plain->get()}) {
        const auto report = t->push(kHand, push);
        ASSERT_TRUE(report.ok() && report->status == PushStatus::Applied);
        for (int n = 0; n < 10; ++n) ASSERT_TRUE(t->sweep().ok());
    }
    std::vector<double> ours, expected;
    dynamic_cast<NodeTissue&>(**tissue).state(ours);
    dynamic_cast<NodeTissue&>(**plain).state(expected);
    ASSERT_EQ(ours.size(), expected.size());
    for (std::size_t n = 0; n < ours.size(); ++n) ASSERT_NEAR(ours[n], expected[n], 1e-3) << n;
    EXPECT_LT(norm(*(*tissue)->force_n(kHand) - *(*plain)->force_n(kHand)),
              1e-3 * norm(*(*plain)->force_n(kHand)));
    EXPECT_EQ((*tissue)->node_count(), std::int32_t(mesh.nodes_mm.size()));
    const auto positions = positions_of(**tissue);
    EXPECT_EQ(positions[5], (Vec3d{ours[15], ours[16], ours[17]}));
}

TEST_F(Organs, ABodyOfOgdensLawIsStifferInCompression) {
    // A block of 20 mm between a held face and a sphere that pushes or pulls the other.
    const auto force_of = [&](const std::string& law, double push_mm, std::uint64_t& hash) {
        write(
            "[[body]]\nname = \"a\"\nmesh = \"left.vtu\"\nheld_mm = [[-1, -1, -1], [1, 21, 21]]\n"
            "young_modulus_pa = 4540\n" +
            law);
        const auto made = make_organs(*read(), m_arena);
        EXPECT_TRUE(made.ok()) << made.error().message;
        hash = made->hash;
        auto tissue = make_tissue(*made, made->scan, m_arena).value();
        const auto report = tissue->push(
            kHand, {.point_mm = {20, 10, 10}, .push_mm = {push_mm, 0, 0}, .sphere_radius_mm = 11});
        EXPECT_TRUE(report.ok() && report->status == PushStatus::Applied);
        EXPECT_TRUE(tissue->advance({.max_steps = 60}).ok());
        return tissue->force_n(kHand)->x;
    };
    std::uint64_t neo_hookean = 0, ogden = 0;
    const double plain = -force_of("", -2, neo_hookean) / force_of("", 2, neo_hookean);
    const std::string law = "law = \"ogden\"\n";
    const double ratio = -force_of(law, -2, ogden) / force_of(law, 2, ogden);
    EXPECT_NEAR(plain, 1.2, 0.2);
    EXPECT_GT(ratio, 1.8 * plain);
    EXPECT_NE(ogden, neo_hookean);
    write("[[body]]\nname = \"a\"\nmesh = \"left.vtu\"\nlaw = \"ogden\"\nogden_alpha = 0.5\n");
    const auto made = make_organs(*read(), m_arena);
    ASSERT_TRUE(made.ok());
    const auto tissue = make_tissue(*made, made->scan, m_arena);
    ASSERT_FALSE(tissue.ok());
    EXPECT_NE(tissue.error().message.find("a: solid 0: expected an Ogden exponent"),
              std::string::npos)
        << tissue.error().message;
}

TEST_F(Organs, ABoxThatHoldsNoNodeIsAnErrorAndABodyWithoutHeldNodesIsSaid) {
    for (const std::string law : {"solid", "distances", "springs"}) {
        const std::string body = "[[body]]\nmesh = \"left.vtu\"\nlaw = \"" + law + "\"\n";
        write(body + "held_mm = [[-1, -1, -1], [21, 21, 1], [500, 500, 500], [600, 600, 600]]\n");
        const auto beside = make_organs(*read(), m_arena);
        ASSERT_TRUE(beside.ok());
        const auto refused = make_tissue(*beside, beside->scan, m_arena);
        ASSERT_FALSE(refused.ok());
        EXPECT_EQ(refused.error().field, "held_mm");
        EXPECT_EQ(
            refused.error().message,
            "body 1: held_mm: expected boxes with a node of the body, which lies from 0, 0, 0 "
            "to 20, 20, 20 mm, found none in the box from 500, 500, 500 to 600, 600, 600");
        write(body);
        const auto free = make_organs(*read(), m_arena);
        ASSERT_TRUE(free.ok());
        const auto tissue = make_tissue(*free, free->scan, m_arena);
        ASSERT_TRUE(tissue.ok());
        std::string said;
        for (const NamedValue& value : (*tissue)->report())
            if (value.name == "summary" || value.name == "body.bodies")
                said += std::get<std::string>(value.value) + "\n";
        EXPECT_NE(said.find(law == "springs" ? "125 nodes (0 fixed)" : "125 particles (0 held)"),
                  std::string::npos)
            << said;
        EXPECT_EQ(said.find(", no node held") != std::string::npos, law != "springs") << said;
    }
}

TEST_F(Organs, APushOnHeldNodesOnlyIsRejectedAndChangesNothing) {
    for (const std::string law : {"solid", "distances", "springs"}) {
        write("[[body]]\nmesh = \"left.vtu\"\nlaw = \"" + law +
              "\"\nheld_mm = [[-1, -1, -1], [21, 21, 11]]\n");
        const auto made = make_organs(*read(), m_arena);
        const auto tissue = make_tissue(*made, made->scan, m_arena);
        ASSERT_TRUE(tissue.ok()) << tissue.error().message;
        const Push up{.point_mm = {10, 10, 20}, .push_mm = {0, 0, 2}, .sphere_radius_mm = 6};
        ASSERT_EQ((*tissue)->push(kHand, up)->status, PushStatus::Applied);
        const std::uint64_t hash = (*tissue)->hash();
        // A sphere on the held half, and a point in it.
        for (const double radius : {4.0, 0.0}) {
            const auto report = (*tissue)->push(
                2, {.point_mm = {10, 10, 4}, .push_mm = {1, 0, 0}, .sphere_radius_mm = radius});
            ASSERT_TRUE(report.ok()) << report.error().message;
            EXPECT_EQ(report->status, PushStatus::Rejected) << law;
            EXPECT_EQ(report->limited_by, LimitedBy::Bone);
            EXPECT_EQ(report->message, "every node there is fixed");
            EXPECT_EQ(report->moved_elements + report->grabbed_elements, 0);
            EXPECT_EQ((*tissue)->hash(), hash) << law;
            EXPECT_TRUE((*tissue)->is_touched_by(kHand));
        }
        // The tool that comes from elsewhere lets go, and the tissue returns.
        Push held = up;
        held.point_mm.z = 4;
        EXPECT_EQ((*tissue)->push(kHand, held)->status, PushStatus::Rejected);
        EXPECT_FALSE((*tissue)->is_touched_by(kHand));
        ASSERT_TRUE((*tissue)->sweep().ok());
        EXPECT_NE((*tissue)->hash(), hash);
    }
}

TEST_F(Organs, SpringsAreForASingleBodyAndAPoissonsRatioOfAQuarterOrMore) {
    const auto fault_of = [&](const std::string& scene) {
        write(scene);
        const auto made = make_organs(*read(), m_arena);
        EXPECT_TRUE(made.ok());
        const auto tissue = make_tissue(*made, made->scan, m_arena);
        return tissue.ok() ? std::string("accepted") : tissue.error().message;
    };
    std::string two = kTwo;
    EXPECT_EQ(fault_of(two.replace(two.find("distances"), 9, "springs")),
              "law: expected a single body with springs, found 2 bodies");
    EXPECT_EQ(fault_of("[[body]]\nmesh = \"left.vtu\"\nlaw = \"springs\"\n"
                       "poisson_ratio = 0.2\nheld_back = 0.1\n"),
              "body 1: poisson_ratio: expected 0.25 or more with springs, found 0.2");
}

TEST_F(Organs, EachVoxelOfTheirScanFollowsFromItsDistancesToAllSurfaces) {
    // Two organs that overlap, and two vessels that cross in one of them.
    EXPECT_TRUE(write_vtu(m_folder / "one.vtu", block_at({0, 0, 0})).ok());
    EXPECT_TRUE(write_vtu(m_folder / "two.vtu", block_at({14, 3, 4})).ok());
    const auto tube = [&](const char* name, Vec3d at, Vec3d shares) {
        TetMesh mesh = block_at({0, 0, 0});
        for (Vec3d& p : mesh.nodes_mm)
            for (int a = 0; a < 3; ++a) p[a] = at[a] + shares[a] * p[a];
        EXPECT_TRUE(write_surface(m_folder / name, boundary_triangles(mesh)).ok());
        return boundary_triangles(mesh);
    };
    const std::vector<TriangleMesh> tubes = {tube("a.stl", {2, 8, 8}, {0.7, 0.15, 0.15}),
                                             tube("b.stl", {8, 2, 9}, {0.15, 0.7, 0.15})};
    write(R"([[body]]
mesh = "one.vtu"

[[body]]
mesh = "two.vtu"

[[contents]]
surface = "a.stl"
value_hu = 200

[[contents]]
surface = "b.stl"
value_hu = 300
)");
    const auto file = read();
    ASSERT_TRUE(file.ok()) << file.error().message;
    const auto made = make_organs(*file, m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    std::vector<SurfaceDistance> organs, vessels;
    for (const Organ& organ : made->organs)
        organs.push_back(SurfaceDistance::create(boundary_triangles(organ.mesh)).value());
    for (const TriangleMesh& t : tubes) vessels.push_back(SurfaceDistance::create(t).value());
    const Volume& scan = made->scan;
    const double voxel = scan.grid.spacing_mm.x;
    int air = 0, one = 0, two = 0, vessel = 0;
    const Vec3i size = scan.grid.size;
    for (int k = 0; k < size.z; k += 3)
        for (int j = 0; j < size.y; j += 3)
            for (int i = 0; i < size.x; i += 3) {
                const Vec3d p = world_from_voxel(scan.grid, {double(i), double(j), double(k)});
                const double a = organs[0].signed_mm(p), b = organs[1].signed_mm(p);
                const double v = std::min(vessels[0].signed_mm(p), vessels[1].signed_mm(p));
                const auto value = double(scan.at({i, j, k}));
                if (std::min(a, b) > voxel) {
                    ++air;
                    ASSERT_EQ(value, -1000) << i << " " << j << " " << k;
                } else if (std::min(a, b) > -voxel) {
                    continue;
                } else if (v < -voxel) {
                    ++vessel;
                    ASSERT_EQ(value, vessels[0].signed_mm(p) <= v ? 200 : 300);
                } else if (v > voxel && a < b - 0.01) {
                    ++one;
                    ASSERT_NEAR(value, 60, 25) << i << " " << j << " " << k;
                } else if (v > voxel && b < a - 0.01) {
                    ++two;
                    ASSERT_NEAR(value, 40, 25) << i << " " << j << " " << k;
                }
            }
    for (const int count : {air, one, two, vessel}) EXPECT_GT(count, 100);
}

TEST_F(Organs, LabelsGetBodiesInTheirSurroundings) {
    // Two organs side by side in tissue, with bone behind and air in front.
    Grid grid{.size = {40, 36, 30}, .spacing_mm = {2, 2, 2}};
    Volume scan{grid, VoxelArray<std::int16_t>(), {}}, labels = scan;
    VoxelArray<std::int16_t> values(voxel_count(grid));
    VoxelArray<std::int16_t> numbers(voxel_count(grid));
    for (int k = 0; k < 30; ++k)
        for (int j = 0; j < 36; ++j)
            for (int i = 0; i < 40; ++i) {
                const std::size_t at = voxel_index(grid, {i, j, k});
                const bool inside = j >= 10 && j < 24 && k >= 8 && k < 22;
                numbers[at] = std::int16_t(inside && i >= 8 && i < 20    ? 5
                                           : inside && i >= 20 && i < 32 ? 7
                                                                         : 0);
                values[at] = std::int16_t(j < 4 ? -1000 : j >= 32 ? 800 : numbers[at] ? 60 : -90);
            }
    scan.voxels = std::move(values);
    labels.voxels = std::move(numbers);
    ASSERT_TRUE(write_volume(m_folder / "scan.nrrd", scan).ok());
    ASSERT_TRUE(write_volume(m_folder / "labels.nrrd", labels).ok());
    auto file = organ_file_of_labels((m_folder / "scan.nrrd").string(),
                                     (m_folder / "labels.nrrd").string(), {});
    ASSERT_TRUE(file.ok()) << file.error().message;
    ASSERT_EQ(file->bodies.size(), 2u);
    EXPECT_EQ(file->bodies[1].labels, std::vector<int>{7});
    EXPECT_GT(file->friction, 0) << "nothing else holds a body of a label";
    file->tetrahedra = 6000;
    std::ofstream(m_folder / "organs.ctbl") << "7 left_lobe 1 2 3 255\n";
    {
        OrganFile named = *file;
        named.tetrahedra = 2000;
        named.label_names = (m_folder / "organs.ctbl").string();
        const auto with_names = make_organs(named, m_arena);
        ASSERT_TRUE(with_names.ok()) << with_names.error().message;
        EXPECT_EQ(with_names->organs[0].name, "label 5") << "the table has no name for it";
        EXPECT_EQ(with_names->organs[1].name, "left lobe");
        named.label_names = (m_folder / "none.ctbl").string();
        const auto missing = make_organs(named, m_arena);
        ASSERT_FALSE(missing.ok());
        EXPECT_EQ(missing.error().field, "label_names");
    }
    const auto made = make_organs(*file, m_arena);
    ASSERT_TRUE(made.ok()) << made.error().message;
    ASSERT_EQ(made->organs.size(), 3u);
    EXPECT_EQ(made->organs[2].name, "surroundings");
    for (const Organ& organ : made->organs)
        EXPECT_TRUE(check_quality(tet_quality(organ.mesh)).ok()) << organ.name;
    const double organs_mm3 = 2.0 * 12 * 14 * 14 * 8;
    EXPECT_NEAR(
        tet_quality(made->organs[0].mesh).volume_mm3 + tet_quality(made->organs[1].mesh).volume_mm3,
        organs_mm3, 0.12 * organs_mm3);

    auto tissue = make_tissue(*made, made->scan, m_arena).value();
    const auto report = tissue->push(
        kHand, {.point_mm = {28, 34, 30}, .push_mm = {0, 1, 0}, .sphere_radius_mm = 9});
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->status, PushStatus::Applied) << report->message;
    ASSERT_TRUE(tissue->update_deformation().ok());
    const Deformation& moved = tissue->deformation();
    EXPECT_GT(moved.displacement_mm({14, 17, 15}).y, 0.8) << "the pushed organ";
    EXPECT_LT(norm(moved.displacement_mm({26, 17, 15})), norm(moved.displacement_mm({14, 17, 15})))
        << "the other one slides on it";
    EXPECT_GT(norm(moved.displacement_mm({14, 27, 15})), 0.05) << "what is behind";
    EXPECT_LT(norm(moved.displacement_mm({14, 33, 15})), 1e-6) << "bone";
    const auto carried = deform_volume(*tissue);
    ASSERT_TRUE(carried.ok());
    EXPECT_NE(hash_volume(carried->volume), hash_volume(made->scan));

    EXPECT_EQ(made->organs[0].name, "label 5") << "there are no names";
    ASSERT_EQ(made->file.bodies.size(), 2u);
    EXPECT_EQ(made->file.bodies[0].name, "label 5");

    OrganFile without = *file;
    without.bodies[0].labels = {6};
    const auto none = make_organs(without, m_arena);
    ASSERT_FALSE(none.ok());
    EXPECT_NE(none.error().message.find("expected labels of this map (5, 7), found 6"),
              std::string::npos)
        << none.error().message;

    EXPECT_EQ(made->notes.format, "NRRD");
    file->reading.frame = 3;
    const auto other = make_organs(*file, m_arena);
    ASSERT_FALSE(other.ok()) << "the scan has one image";
    EXPECT_NE(other.error().message.find("scan.nrrd"), std::string::npos) << other.error().message;
}

/// A NIfTI file with an extension between header and voxels.
void put_extension(const std::filesystem::path& nifti, const std::string& xml) {
    std::ifstream in(nifti, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    in.close();
    std::string extension(8, '\0');
    extension += xml;
    extension.resize((extension.size() + 15) / 16 * 16, ' ');
    const auto size = std::int32_t(extension.size());
    std::memcpy(extension.data(), &size, 4);
    bytes[348] = 1;
    const auto offset = float(352 + size);
    std::memcpy(bytes.data() + 108, &offset, 4);
    bytes.insert(352, extension);
    std::ofstream(nifti, std::ios::binary) << bytes;
}

TEST_F(Organs, LabelsHaveTheNamesOfATable) {
    const auto names_of = [&](const std::string& text) {
        std::ofstream(m_folder / "names.txt") << text;
        const auto names = read_label_names(m_folder / "names.txt");
        return names.ok() ? *names : LabelNames{};
    };
    const LabelNames two{{1, "spleen"}, {6, "left kidney"}};
    for (const char* text :
         {"{\"1\": \"spleen\", \"6\": \"left kidney\"}",
          "{\"spleen\": 1, \"background\": 0, \"left kidney\": 6}",
          "{\"labels\": {\"spleen\": 1, \"left kidney\": 6}, \"numTraining\": 40}",
          "[{\"value\": 1, \"name\": \"spleen\"}, {\"id\": 6, \"name\": \"left kidney\"}]",
          "# ITK-SNAP\n0 0 0 0 0 0 0 \"Clear Label\"\n1 255 0 0 1 1 1 \"spleen\"\n"
          "   6  0  255 0  1 1 1   \"left kidney\"\n",
          "# Slicer\n0 Background 0 0 0 0\n1 spleen 157 108 162 255\n6 left_kidney 1 2 3 255\n",
          "\xef\xbb\xbfvalue,name\r\n1,spleen\r\n6,\"left kidney\"\r\n",
          "1;spleen;red\n6;left kidney;blue\n", "1 spleen\n6: left kidney\n"})
        EXPECT_EQ(names_of(text), two) << text;
    EXPECT_EQ(names_of("7 lobe 3\n").at(7), "lobe 3") << "one number is no colour";
    EXPECT_EQ(names_of("# Organs\n\nThese were found:\n3 livers\nin all\n"), LabelNames{});
    std::ofstream(m_folder / "names.txt") << "no names\n";
    const auto none = read_label_names(m_folder / "names.txt");
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().message, (m_folder / "names.txt").string() +
                                        ": expected lines of a label's value and its "
                                        "name, or JSON of them, found none");
}

TEST_F(Organs, LabelsHaveTheNamesOfTheirMapAndOfATextBesideIt) {
    const std::filesystem::path map = m_folder / "map.nrrd", nifti = m_folder / "map.nii";
    const auto found = [](const std::filesystem::path& file, const KeyValues& pairs,
                          const std::filesystem::path& table = {}) {
        const auto names = find_label_names(file, pairs, table);
        EXPECT_TRUE(names.ok()) << names.error().message;
        return names.ok() ? *names : LabelNames{};
    };
    const KeyValues segments = {{"Segment0_LabelValue", "7"}, {"Segment0_Name", "liver"}};
    EXPECT_EQ(found(map, {}), LabelNames{});
    EXPECT_EQ(found(map, segments), (LabelNames{{7, "liver"}}));
    Grid grid{.size = {4, 4, 4}, .spacing_mm = {1, 1, 1}};
    ASSERT_TRUE(write_volume(nifti, {grid, VoxelArray<std::int16_t>(voxel_count(grid)), {}}).ok());
    EXPECT_EQ(found(nifti, {}), LabelNames{});
    put_extension(nifti,
                  "<CaretExtension><LabelTable><Label Key=\"2\" Red=\"0\">"
                  "<![CDATA[false_lumen]]></Label>\n<Label Key=\"3\">a &amp; b</Label>");
    EXPECT_EQ(found(nifti, {}), (LabelNames{{2, "false_lumen"}, {3, "a & b"}}));
    ASSERT_TRUE(read_volume(nifti).ok()) << "the voxels are behind the extension";
    // A text beside the map.
    std::ofstream(m_folder / "map.json") << "{\"EchoTime\": 4, \"SeriesNumber\": 7}";
    EXPECT_EQ(found(map, {}), LabelNames{}) << "this is about an image";
    std::ofstream(m_folder / "map.txt") << "7 liver\nNotes about the map.\n";
    EXPECT_EQ(found(map, {}), LabelNames{}) << "this is no table";
    std::ofstream(m_folder / "map.csv") << "value,name\n7,gall bladder\n";
    EXPECT_EQ(found(map, {}), (LabelNames{{7, "gall bladder"}}));
    const std::filesystem::path packed = m_folder / "map.nii.gz";
    EXPECT_FALSE(find_label_names(packed, {}, {}).ok()) << "there is no such map";
    ASSERT_TRUE(write_volume(packed, {grid, VoxelArray<std::int16_t>(voxel_count(grid)), {}}).ok());
    EXPECT_EQ(found(packed, {}), (LabelNames{{7, "gall bladder"}}));
    EXPECT_EQ(found(map, segments), (LabelNames{{7, "liver"}})) << "its own are preferred";
    std::ofstream(m_folder / "other.txt") << "7 spleen\n";
    EXPECT_EQ(found(map, segments, m_folder / "other.txt"), (LabelNames{{7, "spleen"}}));
}

}  // namespace
}  // namespace pliant::test
