// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Covers: springs/builders_*.cpp, springs/network*.cpp, springs/state.cpp.

#include <pliant/models/springs.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "springs/cell_volume.h"
#include "springs/random_networks.h"

namespace pliant::test {
namespace {

std::string error_of(SpringParts parts) {
    const auto network = SpringNetwork::create(std::move(parts));
    if (network.ok()) return "no error";
    EXPECT_EQ(network.error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(network.error().message.find('\n'), std::string::npos);
    return network.error().message;
}

SpringParts two_nodes() {
    return {{{.rest = {0, 0, 0}}, {.rest = {1, 0, 0}}}, {{.a = 0, .b = 1}}, {}};
}

TEST(Networks, WhatIsNotWellFormedIsRefusedWithItsNumber) {
    const auto expect = [](const auto& change, const std::string& message) {
        SpringParts parts = two_nodes();
        change(parts);
        EXPECT_EQ(error_of(parts), message);
    };
    expect([](SpringParts& p) { p.nodes[1].mass = 0; },
           "network: node 1: expected a mass above 0, found 0.000000");
    expect([](SpringParts& p) { p.nodes[0].damping = -1; },
           "network: node 0: expected a damping of 0 or more, found -1.000000");
    expect([](SpringParts& p) { p.nodes[1].rest.y = NAN; },
           "network: node 1: expected a rest position of three numbers");
    expect([](SpringParts& p) { p.links[0].stiffness = -2; },
           "network: link 0: expected a stiffness of 0 or more, found -2.000000");
    expect([](SpringParts& p) { p.links[0].damping = -2; },
           "network: link 0: expected a damping of 0 or more, found -2.000000");
    expect([](SpringParts& p) { p.links[0].b = 2; },
           "network: link 0: expected two different nodes below 2, found 0 and 2");
    expect([](SpringParts& p) { p.links[0].b = 0; },
           "network: link 0: expected two different nodes below 2, found 0 and 0");
    expect(
        [](SpringParts& p) {
            p.nodes.push_back({.rest = {2, 0, 0}});
        },
        "network: node 2: expected a chain of links to node 0; the network is in 2 pieces");
    expect([](SpringParts& p) { p.nodes.clear(); },
           "network: expected 1 to 1073741823 nodes, found 0");
    expect(
        [](SpringParts& p) {
            p.cells.push_back({.nodes = {0, 1, 0, 1}, .node_count = 4});
        },
        "network: cell 0: expected a volume above 0, found 0.000000");
    expect(
        [](SpringParts& p) {
            p.cells.push_back({.nodes = {0, 1, 7}, .node_count = 4});
        },
        "network: cell 0: expected nodes below 2, found 7");
    expect([](SpringParts& p) { p.cells.push_back({.node_count = 5}); },
           "network: cell 0: expected 4 or 8 nodes, found 5");
    EXPECT_EQ(error_of(two_nodes()), "no error");
}

TEST(Networks, LatticesHaveTheLinksOfTheirKind) {
    const auto count = [](LatticeLinks links, Vec3i size) {
        return springs_of_lattice({.size = size, .links = links})->links.size();
    };
    const auto expected = [](int x, int y, int z, int kinds) {
        const int edges = (x - 1) * y * z + x * (y - 1) * z + x * y * (z - 1);
        const int faces =
            2 * ((x - 1) * (y - 1) * z + (x - 1) * y * (z - 1) + x * (y - 1) * (z - 1));
        const int body = 4 * (x - 1) * (y - 1) * (z - 1);
        return std::size_t(edges + (kinds > 1 ? faces : 0) + (kinds > 2 ? body : 0));
    };
    for (const Vec3i size : {Vec3i{2, 2, 2}, Vec3i{4, 3, 5}, Vec3i{7, 4, 1}, Vec3i{1, 1, 3}}) {
        EXPECT_EQ(count(LatticeLinks::Edges, size), expected(size.x, size.y, size.z, 1));
        EXPECT_EQ(count(LatticeLinks::EdgesAndFaces, size), expected(size.x, size.y, size.z, 2));
        EXPECT_EQ(count(LatticeLinks::EdgesFacesAndBody, size),
                  expected(size.x, size.y, size.z, 3));
    }
    EXPECT_FALSE(springs_of_lattice({.size = {0, 2, 2}}).ok());
    EXPECT_FALSE(springs_of_lattice({.stiffness = {1, -1, 1}}).ok());
}

TEST(Networks, ALinkHasTheStiffnessOfItsDirection) {
    const auto parts = springs_of_lattice({.size = {2, 2, 2},
                                           .spacing = {1, 2, 1},
                                           .links = LatticeLinks::EdgesFacesAndBody,
                                           .stiffness = {10, 1, 100}});
    ASSERT_TRUE(parts.ok());
    for (const SpringLink& link : parts->links) {
        const Vec3d r =
            parts->nodes[std::size_t(link.b)].rest - parts->nodes[std::size_t(link.a)].rest;
        const double expected = (10 * r.x * r.x + 1 * r.y * r.y + 100 * r.z * r.z) / dot(r, r);
        EXPECT_NEAR(link.stiffness, expected, 1e-12 * expected);
        EXPECT_NEAR(link.rest_length, norm(r), 1e-15);
    }
}

TEST(Networks, MassesFromADensityAddUpToTheBlock) {
    const auto parts =
        springs_of_lattice({.size = {10, 10, 10}, .spacing = {1, 2, 3}, .density = 0.25});
    double sum = 0;
    for (const SpringNode& node : parts->nodes) sum += node.mass;
    EXPECT_NEAR(sum, 0.25 * 9 * 18 * 27, 1e-9);
    EXPECT_NEAR(parts->nodes[0].mass, 0.25 * 6 / 8, 1e-12);
}

TEST(Networks, RaisedMassesMakeATimeStepStableAndKeepEquilibria) {
    Random random(4);
    SpringParts parts = random_block(random, {5, 5, 4}, 3, true);
    const SpringParts before = parts;
    const auto slow = SpringNetwork::create(parts);
    ASSERT_TRUE(slow.ok());
    const double step = 1.1 * slow->stable_time_step();
    const auto raised = raise_masses(parts, step);
    ASSERT_TRUE(raised.ok());
    const auto fast = SpringNetwork::create(parts);
    EXPECT_GE(fast->stable_time_step(), step);
    EXPECT_LT(fast->stable_time_step(), 1.001 * step);
    std::int64_t changed = 0;
    double added = 0, mass = 0;
    for (std::size_t n = 0; n < parts.nodes.size(); ++n) {
        EXPECT_GE(parts.nodes[n].mass, before.nodes[n].mass);
        changed += parts.nodes[n].mass != before.nodes[n].mass;
        added += parts.nodes[n].mass - before.nodes[n].mass;
        mass += before.nodes[n].mass;
        if (before.nodes[n].fixed) {
            EXPECT_EQ(parts.nodes[n].mass, before.nodes[n].mass);
        }
    }
    EXPECT_GT(changed, 0);
    EXPECT_LT(changed, 20);
    EXPECT_EQ(raised->nodes, changed);
    EXPECT_NEAR(raised->share, added / mass, 1e-12);
    std::array<Vec3d, 2> moved;
    for (const bool heavy : {false, true}) {
        auto tissue = SpringTissue::create(heavy ? *fast : *slow, {.depth = 9});
        ASSERT_TRUE(tissue->load(std::array{87}, std::array{Vec3d{0.1, 0, -0.3}}).ok());
        ASSERT_TRUE(tissue->find_equilibrium().ok());
        moved[heavy] = tissue->displacement(87);
    }
    EXPECT_EQ(moved[0], moved[1]);
    EXPECT_EQ(raise_masses(parts, 0.5 * step)->nodes, 0);
    EXPECT_EQ(raise_masses(parts, 0).error().message,
              "raise_masses: expected a time step above 0, found 0");
}

TEST(Networks, TheSheetHasSixNeighboursAllAtOneSpacing) {
    const auto network =
        SpringNetwork::create(*springs_of_sheet({.columns = 9, .rows = 8, .spacing = 2}));
    ASSERT_TRUE(network.ok());
    EXPECT_EQ(network->neighbours(4 + 9 * 3).size(), 6u);
    EXPECT_EQ(network->neighbours(4 + 9 * 4).size(), 6u);
    for (const SpringLink& link : network->links())
        EXPECT_NEAR(norm(network->nodes()[std::size_t(link.a)].rest -
                         network->nodes()[std::size_t(link.b)].rest),
                    2, 1e-12);
    EXPECT_EQ(network->links().size(), std::size_t(8 * 8 + 7 * (2 * 9 - 1)));
}

TEST(Networks, MeshesHaveEachEdgeOnce) {
    const std::vector<Vec3d> nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    const std::vector<std::array<std::int32_t, 4>> two = {{0, 1, 2, 3}, {1, 4, 2, 3}};
    EXPECT_EQ(springs_of_tetrahedra(nodes, two, {})->links.size(), 9u);
    const std::vector<std::array<std::int32_t, 3>> triangles = {{0, 1, 2}, {2, 1, 4}};
    EXPECT_EQ(springs_of_triangles(nodes, triangles, {})->links.size(), 5u);
    const std::vector<std::array<std::int32_t, 3>> wrong = {{0, 1, 5}};
    const auto refused = springs_of_triangles(nodes, wrong, {});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().message, "mesh: cell 0: expected nodes below 5, found 5");
}

TEST(Networks, ACubeOfAMeshIsThatOfALattice) {
    const auto lattice = springs_of_lattice({.size = {2, 2, 2}, .density = 1});
    std::vector<Vec3d> nodes;
    for (const SpringNode& node : lattice->nodes) nodes.push_back(node.rest);
    const std::vector<std::array<std::int32_t, 8>> cell = {lattice->cells[0].nodes};
    const auto mesh = springs_of_hexahedra(nodes, cell, {.density = 1});
    ASSERT_TRUE(mesh.ok());
    std::set<std::pair<int, int>> expected, found;
    for (const SpringLink& link : lattice->links) expected.insert(std::minmax({link.a, link.b}));
    for (const SpringLink& link : mesh->links) found.insert({link.a, link.b});
    EXPECT_EQ(found, expected);
    for (std::size_t n = 0; n < 8; ++n) EXPECT_EQ(mesh->nodes[n].mass, 0.125);
}

// Test case 23 of the references: 2√2/25 · E for an edge of length 1 at Poisson's ratio 1/4.
TEST(Networks, ARegularTetrahedronHasTheStiffnessOfLloyd) {
    const std::vector<Vec3d> nodes = {{0, 0, 0},
                                      {1, 0, 0},
                                      {0.5, std::sqrt(0.75), 0},
                                      {0.5, std::sqrt(0.75) / 3, std::sqrt(2.0 / 3)}};
    const std::vector<std::array<std::int32_t, 4>> cell = {{0, 1, 2, 3}};
    const double young = 7, shear = young / 2.5;
    const auto parts = springs_of_elastic_tetrahedra(nodes, cell, {.stiffness = shear});
    for (const SpringLink& link : parts->links) EXPECT_NEAR(link.stiffness / young, 0.11314, 1e-5);
}

TEST(Networks, VolumesAndTheirGradientsAreRight) {
    const std::uint64_t seed = 11;
    SCOPED_TRACE(seed);
    Random random(seed);
    for (int turn = 0; turn < 50; ++turn) {
        const bool tet = turn % 2;
        std::vector<Vec3d> x;
        for (int n = 0; n < 8; ++n)
            x.push_back(
                Vec3d{double((n & 3) == 1 || (n & 3) == 2), double((n & 3) >= 2), double(n >= 4)} +
                random.vector(0.2) + Vec3d{100, -50, 20});
        SpringCell cell{.nodes = {0, 1, 2, 3, 4, 5, 6, 7}, .node_count = 8};
        if (tet) cell = {.nodes = {0, 1, 2, 5}, .node_count = 4};
        const auto place = [&](std::int32_t n) { return x[std::size_t(n)]; };
        const double volume = cell_volume(cell, place);
        if (tet) {
            EXPECT_NEAR(volume, dot(cross(x[1] - x[0], x[2] - x[0]), x[5] - x[0]) / 6, 1e-12);
        } else {
            // The Jacobian of the trilinear map, by Gauss' rule: exact for its degree.
            double sum = 0;
            for (int g = 0; g < 8; ++g) {
                const double p = 0.5 - std::sqrt(1.0 / 12), q = 1 - p;
                const double t[3] = {g & 1 ? p : q, g & 2 ? p : q, g & 4 ? p : q};
                Mat3d jacobian{};
                for (int n = 0; n < 8; ++n) {
                    const bool up[3] = {(n & 3) == 1 || (n & 3) == 2, (n & 3) >= 2, n >= 4};
                    for (int a = 0; a < 3; ++a) {
                        double weight = up[a] ? 1 : -1;
                        for (int b = 0; b < 3; ++b)
                            if (b != a) weight *= up[b] ? t[b] : 1 - t[b];
                        jacobian.columns[a] = jacobian.columns[a] + weight * x[std::size_t(n)];
                    }
                }
                sum += determinant(jacobian) / 8;
            }
            EXPECT_NEAR(volume, sum, 1e-11);
        }
        for (int corner = 0; corner < cell.node_count; ++corner) {
            const Vec3d gradient = volume_gradient(cell, corner, place);
            for (int a = 0; a < 3; ++a) {
                Vec3d& moved = x[std::size_t(cell.nodes[std::size_t(corner)])];
                const double kept = moved[a], step = 1e-4;
                moved[a] = kept + step;
                const double more = cell_volume(cell, place);
                moved[a] = kept - step;
                const double less = cell_volume(cell, place);
                moved[a] = kept;
                EXPECT_NEAR(gradient[a], (more - less) / (2 * step), 1e-7);
            }
        }
        std::vector<Vec3d> move;
        for (int n = 0; n < 8; ++n) move.push_back(random.vector(1));
        for (int corner = 0; corner < cell.node_count; ++corner) {
            const auto moved = [&](double way) {
                return volume_gradient(cell, corner, [&](std::int32_t n) {
                    return x[std::size_t(n)] + way * move[std::size_t(n)];
                });
            };
            const Vec3d change = volume_gradient_change(
                cell, corner, place, [&](std::int32_t n) { return move[std::size_t(n)]; });
            EXPECT_LT(norm(0.5 * (moved(1) - moved(-1)) - change), 1e-12);
        }
    }
}

TEST(Networks, AScanGivesPlacesStiffnessAndFixedNodes) {
    Volume volume;
    volume.grid = {.size = {21, 21, 21},
                   .spacing_mm = {1, 1, 2},
                   .origin_mm = {5, -7, 3},
                   .direction = {{{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}}};  // left-handed
    std::vector<std::int16_t> values(voxel_count(volume.grid), 40);
    for (int k = 0; k < 21; ++k)
        for (int j = 0; j < 21; ++j)
            for (int i = 0; i < 21; ++i) {
                if (i > 12 && i < 18) values[voxel_index(volume.grid, {i, j, k})] = 1000;
                if (i < 3) values[voxel_index(volume.grid, {i, j, k})] = -1000;
            }
    volume.voxels = values;
    const SpringScan scan{.size = {5, 5, 5}, .fixed_share = 1, .fixed_border = false};
    auto parts = springs_of_scan(volume, scan);
    ASSERT_TRUE(parts.ok());
    // Bone is in two of five voxels along i of the cells from node 2 to 3, three of those to 4.
    const auto with_share = [&](double share) {
        return springs_of_scan(volume,
                               {.size = {5, 5, 5}, .fixed_share = share, .fixed_border = false});
    };
    const auto two_fifths = with_share(0.39), three_fifths = with_share(0.41);
    ASSERT_TRUE(two_fifths.ok() && three_fifths.ok());
    EXPECT_FALSE(with_share(-0.1).ok());
    const Grid nodes{.size = {5, 5, 5}};
    for (int i = 0; i < 5; ++i) {
        const SpringNode& node = parts->nodes[voxel_index(nodes, {i, 2, 2})];
        EXPECT_EQ(node.fixed, i == 3) << i;
        EXPECT_EQ(two_fifths->nodes[voxel_index(nodes, {i, 2, 2})].fixed, i >= 2) << i;
        EXPECT_EQ(three_fifths->nodes[voxel_index(nodes, {i, 2, 2})].fixed, i >= 3) << i;
        EXPECT_NEAR(norm(node.rest - world_from_voxel(volume.grid, {5.0 * i, 10, 10})), 0, 1e-12);
    }
    const auto network = SpringNetwork::create(*parts);
    ASSERT_TRUE(network.ok()) << network.error().message;
    const auto along = [&](int i) {
        for (const auto& neighbour :
             network->neighbours(std::int32_t(voxel_index(nodes, {i, 2, 2}))))
            if (neighbour.node == std::int32_t(voxel_index(nodes, {i + 1, 2, 2})))
                return network->links()[std::size_t(neighbour.link)].stiffness;
        return 0.0;
    };
    const double edge = std::cbrt(5.0 * 5 * 10);
    EXPECT_NEAR(along(1), 0.4 * 15e3 * edge, 1e-6);
    EXPECT_NEAR(along(0), 0.4 * (15e3 + 150) / 2 * edge, 1e-6);
    EXPECT_FALSE(springs_of_scan(volume, {.size = {30, 5, 5}}).ok());
    EXPECT_FALSE(springs_of_scan(volume, {.region = {{0, 0, 0}, {22, 5, 5}}}).ok());
    EXPECT_FALSE(
        springs_of_scan(volume, {.size = {5, 5, 5}, .young_modulus_pa = [](double) { return 0.0; }})
            .ok());
}

TEST(Networks, AnOrganHasItsOwnStiffnessAndNodesBetweenTwoTakeTheMean) {
    Volume volume;
    volume.grid = {.size = {21, 21, 21}};
    std::vector<std::int16_t> values(voxel_count(volume.grid), 40);
    for (std::size_t n = 0; n < values.size(); ++n)
        if (n % 21 == 3 && n / 21 % 5 == 0) values[n] = 2000;  // stones: 4 % of a cell
    volume.voxels = values;
    // Nodes at 0, 5 … 20: that at 5 has 3 … 7, of which the organ has two.
    const auto parts_with = [&](const SpringOrgan& organ) {
        return springs_of_scan(volume, {.size = {5, 5, 5},
                                        .fixed_hu = 1000,
                                        .fixed_share = 0.02,
                                        .fixed_border = false,
                                        .organs = {organ},
                                        .organ_at = [](Vec3i v) { return v.x < 5 ? 0 : -1; }});
    };
    const auto parts = parts_with({.young_modulus_pa = 3000, .poisson_ratio = 0.45});
    ASSERT_TRUE(parts.ok()) << parts.error().message;
    const SpringMaterial organ = closed_form(3000, 0.45, 5);
    const double other = 0.4 * 15e3 * 5, between = 0.4 * organ.stiffness + 0.6 * other;
    const double nodes[] = {organ.stiffness, between, other, other, other};
    const double bulks[] = {organ.bulk, 0.4 * organ.bulk, 0, 0, 0};
    const auto is_at = [&](std::int32_t n, double x) {
        return parts->nodes[std::size_t(n)].rest.x == x;
    };
    int found = 0;
    for (const SpringLink& link : parts->links)
        for (int i = 0; i < 4; ++i)
            if (is_at(link.a, 5.0 * i) && is_at(link.b, 5.0 * (i + 1))) {
                EXPECT_NEAR(link.stiffness, (nodes[i] + nodes[i + 1]) / 2, 1e-6) << i;
                ++found;
            }
    EXPECT_GT(found, 100);
    for (const SpringCell& cell : parts->cells) {
        const int i = int(parts->nodes[std::size_t(cell.nodes[0])].rest.x / 5);
        EXPECT_NEAR(cell.bulk, (bulks[i] + bulks[i + 1]) / 2, 1e-6);
    }
    const auto fixed = [&](const SpringOrgan& own) {
        std::vector<int> at(5, 0);
        const auto made = parts_with(own);
        for (std::size_t n = 0; n < made->nodes.size(); ++n) at[n % 5] += made->nodes[n].fixed;
        return at;
    };
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    // Cells up to 5 have stones; nodes up to 5 are theirs.
    EXPECT_EQ(fixed({}), (std::vector{25, 25, 0, 0, 0}));
    EXPECT_EQ(fixed({.fixed_hu = kInfinity}), (std::vector{0, 0, 0, 0, 0}));
    EXPECT_EQ(fixed({.fixed_hu = -kInfinity}), (std::vector{25, 25, 0, 0, 0}));
    EXPECT_EQ(fixed({.fixed_hu = 3000}), (std::vector{0, 0, 0, 0, 0}));
}

TEST(Networks, ACutLeavesBothEndsOfEachLinkAlike) {
    const std::uint64_t seed = 23;
    SCOPED_TRACE(seed);
    Random random(seed);
    auto network = SpringNetwork::create(random_block(random, {5, 4, 4}, 1, false));
    ASSERT_TRUE(network.ok());
    std::vector<std::uint8_t> cut(network->links().size(), 0);
    for (int turn = 0; turn < 20; ++turn) {
        std::vector<std::int32_t> links;
        for (int n = 0; n < 10; ++n) links.push_back(random.whole(0, int(cut.size()) - 1));
        std::int64_t fresh = 0;
        for (const std::int32_t l : links) {
            fresh += !cut[std::size_t(l)];
            cut[std::size_t(l)] = 1;
        }
        const auto report = network->cut_links(links);
        ASSERT_TRUE(report.ok());
        EXPECT_EQ(report->cut_links, fresh);
        std::vector<int> seen(cut.size(), 0);
        for (std::int32_t n = 0; n < network->node_count(); ++n)
            for (const auto& neighbour : network->neighbours(n)) {
                const SpringLink& link = network->links()[std::size_t(neighbour.link)];
                EXPECT_TRUE(neighbour.node == (link.a == n ? link.b : link.a));
                ++seen[std::size_t(neighbour.link)];
            }
        for (std::size_t l = 0; l < cut.size(); ++l) EXPECT_EQ(seen[l], cut[l] ? 0 : 2);
        for (std::size_t c = 0; c < network->cells().size(); ++c) {
            const auto& corners = network->cells()[c].nodes;
            bool whole = true;
            for (std::size_t l = 0; l < cut.size(); ++l) {
                const SpringLink& link = network->links()[l];
                if (cut[l] && std::count(corners.begin(), corners.end(), link.a) &&
                    std::count(corners.begin(), corners.end(), link.b))
                    whole = false;
            }
            EXPECT_EQ(network->is_cell_cut(c), !whole);
        }
    }
    EXPECT_FALSE(network->cut_links(std::array{-1}).ok());
    EXPECT_FALSE(network->cut_cells(std::array{1000}).ok());
}

TEST(Networks, ACellCutOutTakesTheLinksThatNoOtherCellHas) {
    auto parts = springs_of_lattice({.size = {3, 2, 2}});
    parts->nodes[0].fixed = true;
    auto network = SpringNetwork::create(std::move(*parts));
    const auto cut = network->cut_cells(std::array{1});
    ASSERT_TRUE(cut.ok());
    EXPECT_EQ(cut->cut_cells, 1);
    EXPECT_EQ(cut->cut_links, 24 - 6);  // all but those of the face between the two cells
    EXPECT_EQ(cut->pieces, 5);
    EXPECT_EQ(cut->loose_nodes, 4);
    EXPECT_EQ(network->neighbours(2).size(), 0u);
    EXPECT_EQ(network->neighbours(0).size(), 6u);
}

}  // namespace
}  // namespace pliant::test
