// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail on graphs: against brute force on random graphs and lattices, and against ChainMail's
// own solver on lattices.

#include <gtest/gtest.h>
#include <pliant/research/graph.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "chainmail/chainmail_impl.h"
#include "chainmail/instances.h"
#include "lattice/lattice.h"
#include "material/limit_units.h"

namespace pliant::test {
namespace {

constexpr std::uint64_t kGraphSeed = 20260301;

using Int = std::int64_t;

/// low ≤ u(b) − u(a) ≤ high [2⁻²⁰ mm].
struct OracleLink {
    int a, b;
    Vec3<Int> low, high;
};

/// The closed form of the minimal move, all links relaxed until nothing changes [Bellman1958].
class GraphOracle {
  public:
    GraphOracle(int element_count, std::vector<OracleLink> links)
        : m_links(std::move(links)), m_u(std::size_t(element_count), Vec3<Int>{0, 0, 0}) {}

    void push(std::span<const std::int32_t> grabbed, Vec3<Int> shift) {
        for (int a = 0; a < 3; ++a) push_component(grabbed, a, shift[a]);
    }
    Vec3<Int> u(int element) const { return m_u[std::size_t(element)]; }

  private:
    void push_component(std::span<const std::int32_t> grabbed, int a, Int shift) {
        constexpr Int kFar = Int(1) << 50;
        std::vector<Int> least(m_u.size(), -kFar), most(m_u.size(), kFar);
        for (const int e : grabbed)
            least[std::size_t(e)] = most[std::size_t(e)] = m_u[std::size_t(e)][a] + shift;
        for (bool changed = true; changed;) {
            changed = false;
            const auto relax = [&](Int& value, Int to, bool up) {
                if (up ? to > value : to < value) value = to, changed = true;
            };
            for (const OracleLink& link : m_links) {
                const auto i = std::size_t(link.a), j = std::size_t(link.b);
                relax(least[j], least[i] + link.low[a], true);
                relax(least[i], least[j] - link.high[a], true);
                relax(most[j], most[i] + link.high[a], false);
                relax(most[i], most[j] - link.low[a], false);
            }
        }
        for (std::size_t e = 0; e < m_u.size(); ++e)
            m_u[e][a] = std::min(std::max(m_u[e][a], least[e]), most[e]);
    }

    std::vector<OracleLink> m_links;
    std::vector<Vec3<Int>> m_u;
};

Vec3<Int> units(Vec3d mm) {
    return {std::llround(mm.x * 0x1p20), std::llround(mm.y * 0x1p20), std::llround(mm.z * 0x1p20)};
}
Vec3d millimetres(Vec3<Int> u) {
    return {double(u.x) * 0x1p-20, double(u.y) * 0x1p-20, double(u.z) * 0x1p-20};
}

struct GraphInstance {
    std::vector<ChainElement> elements;
    std::vector<ChainLink> links;
    GraphOracle oracle;
};

/// A tree that joins all elements, and as many random links again, some of them duplicates.
GraphInstance random_graph(Random& random) {
    const int count = random.whole(2, 60);
    std::vector<ChainElement> elements;
    for (int e = 0; e < count; ++e)
        elements.push_back({.rest_mm = random.vector(10),
                            .max_movement_mm = random.whole(0, 2) ? 500 : random.real(0.5, 6),
                            .fixed = random.whole(0, 30) == 0});
    std::vector<OracleLink> oracle_links;
    std::vector<ChainLink> links;
    const auto join = [&](int a, int b) {
        OracleLink link{a, b, {}, {}};
        for (int c = 0; c < 3; ++c) {
            link.low[c] = -random.whole(0, 1 << random.whole(1, 20));
            link.high[c] = random.whole(0, 1 << random.whole(1, 20));
        }
        oracle_links.push_back(link);
        // With up to one extra unit, which is rounded away.
        const double more = random.real(0, 0.9) * 0x1p-20;
        links.push_back({a, b, millimetres(link.low) - Vec3d{more, more, more},
                         millimetres(link.high) + Vec3d{more, more, more}});
    };
    for (int e = 1; e < count; ++e) join(random.whole(0, e - 1), e);
    for (int n = random.whole(0, count); n > 0; --n) {
        const int a = random.whole(0, count - 1), b = random.whole(0, count - 1);
        if (a != b) join(a, b);
    }
    return {elements, links, GraphOracle(count, oracle_links)};
}

std::vector<std::int32_t> random_elements(Random& random, int count) {
    std::vector<std::int32_t> chosen;
    for (int n = random.whole(1, 3); n > 0; --n) chosen.push_back(random.whole(0, count - 1));
    return chosen;
}

void run_random_graph(std::uint64_t seed) {
    Random random(seed);
    GraphInstance instance = random_graph(random);
    const int count = int(instance.elements.size());
    const auto graph = ChainGraph::create(instance.elements, instance.links);
    ASSERT_TRUE(graph.ok());
    const TaskArena arena(2), alone(1);
    GraphChainMail buckets(*graph), heap(*graph, GraphQueue::Heap), fifo(*graph, GraphQueue::Fifo);
    Vec3d push_mm{0, 0, 0};
    std::vector<std::int32_t> grabbed;
    for (int step = 0; step < 5; ++step) {
        push_mm = step == 3 ? -1.0 * push_mm : random.vector(4);
        if (step != 3) grabbed = random_elements(random, count);
        const Vec3d before = buckets.displacement_mm(grabbed[0]);
        const auto report = buckets.push(grabbed, push_mm, arena);
        const auto same = heap.push(grabbed, push_mm, alone);
        ASSERT_TRUE(report.ok() && same.ok() && fifo.push(grabbed, push_mm, arena).ok());
        EXPECT_EQ(report->step_fraction, same->step_fraction);
        EXPECT_EQ(report->moved_elements, same->moved_elements);
        instance.oracle.push(grabbed, units(buckets.displacement_mm(grabbed[0]) - before));
        for (int e = 0; e < count; ++e) {
            const Vec3d u = buckets.displacement_mm(e);
            ASSERT_EQ(units(u), instance.oracle.u(e)) << "element " << e;
            const ChainElement& element = instance.elements[std::size_t(e)];
            EXPECT_LE(norm(u), element.fixed ? 0 : element.max_movement_mm);
        }
        EXPECT_EQ(buckets.hash(), heap.hash());
        EXPECT_EQ(buckets.hash(), fifo.hash());
        EXPECT_EQ(check_links(*graph, buckets.displacements_mm(), 0).violated_links, 0);
    }
}

TEST(Graph, AllQueuesEqualBruteForceOnRandomGraphs) {
    for (std::uint64_t n = 0; n < 300 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kGraphSeed + n));
        run_random_graph(kGraphSeed + n);
    }
}

Vec3d random_fractions(Random& random) {
    return {random.ratio(0.01, 0.5), random.ratio(0.01, 0.5), random.ratio(0.01, 0.5)};
}

/// Two or three materials at random, about a fifth of the elements missing.
ChainLattice random_lattice(Random& random, bool plane) {
    ChainLattice lattice;
    lattice.size = {random.whole(2, 7), random.whole(2, 7), plane ? 1 : random.whole(2, 6)};
    lattice.spacing_mm = {random.real(0.5, 2), random.real(0.5, 2), random.real(0.5, 2)};
    for (int m = random.whole(2, 3); m > 0; --m)
        lattice.materials.push_back({random_fractions(random), random_fractions(random),
                                     random_fractions(random), 500, false});
    for (int n = lattice.size.x * lattice.size.y * lattice.size.z; n > 0; --n) {
        lattice.material.push_back(
            std::uint8_t(random.whole(0, int(lattice.materials.size()) - 1)));
        lattice.present.push_back(random.whole(0, 4) != 0);
    }
    return lattice;
}

/// One end's share of a link's limits, by the header's formula.
Vec3<Int> share(const ElementLimits& m, Vec3d d, bool high) {
    Vec3<Int> units{};
    for (int a = 0; a < 3; ++a) {
        double sum = std::abs(d[a]) * ((d[a] > 0) == high ? m.stretch[a] : m.compress[a]);
        for (int b = 0; b < 3; ++b)
            if (b != a) sum += std::abs(d[b]) * m.shear[b];
        units[a] = Int(std::floor(sum / 2 * 0x1p20));
    }
    return units;
}

/// Tests every pair of elements: are they neighbours?
std::vector<OracleLink> lattice_links(const ChainLattice& lattice, int longest) {
    const Vec3i size = lattice.size;
    const int count = size.x * size.y * size.z;
    const auto place = [&](int e) {
        return Vec3i{e % size.x, e / size.x % size.y, e / (size.x * size.y)};
    };
    std::vector<OracleLink> links;
    for (int i = 0; i < count; ++i)
        for (int j = i + 1; j < count; ++j) {
            const Vec3i step = place(j) - place(i);
            const int x = std::abs(step.x), y = std::abs(step.y), z = std::abs(step.z);
            if (std::max({x, y, z}) > 1 || x + y + z > longest) continue;
            if (!lattice.present[std::size_t(i)] || !lattice.present[std::size_t(j)]) continue;
            const Vec3d d{step.x * lattice.spacing_mm.x, step.y * lattice.spacing_mm.y,
                          step.z * lattice.spacing_mm.z};
            const ElementLimits& one = lattice.materials[lattice.material[std::size_t(i)]];
            const ElementLimits& other = lattice.materials[lattice.material[std::size_t(j)]];
            links.push_back({i, j, -(share(one, d, false) + share(other, d, false)),
                             share(one, d, true) + share(other, d, true)});
        }
    return links;
}

void run_random_lattice(std::uint64_t seed) {
    Random random(seed);
    const ChainLattice lattice = random_lattice(random, seed % 2 == 0);
    const int count = int(lattice.material.size());
    const TaskArena arena(1);
    const std::pair<Neighbours, int> kinds[] = {
        {Neighbours::Faces, 1}, {Neighbours::Edges, 2}, {Neighbours::All, 3}};
    for (const auto& [neighbours, longest] : kinds) {
        const auto graph = graph_of_lattice(lattice, neighbours);
        ASSERT_TRUE(graph.ok());
        const std::vector<OracleLink> links = lattice_links(lattice, longest);
        EXPECT_EQ(graph->link_count(), std::int64_t(links.size()));
        GraphOracle oracle(count, links);
        GraphChainMail tissue(*graph);
        for (int step = 0; step < 3; ++step) {
            const auto grabbed = random_elements(random, count);
            const Vec3d push_mm = millimetres(units(random.vector(3)));
            ASSERT_TRUE(tissue.push(grabbed, push_mm, arena).ok());
            oracle.push(grabbed, units(push_mm));
            for (int e = 0; e < count; ++e)
                ASSERT_EQ(units(tissue.displacement_mm(e)), oracle.u(e)) << "element " << e;
        }
    }
}

TEST(Graph, LatticesInTwoAndThreeDimensionsWithHolesAndAnyNeighboursEqualBruteForce) {
    for (std::uint64_t n = 0; n < 80 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kGraphSeed + n));
        run_random_lattice(kGraphSeed + n);
    }
}

TEST(Graph, AnElementOfALatticeHasTheNeighboursThatWereAskedFor) {
    const auto degree = [](Vec3i size, Neighbours neighbours, std::int32_t e) {
        const auto graph = graph_of_lattice({.size = size, .materials = {{}}}, neighbours);
        return graph->neighbours(e).size();
    };
    const Vec3i cube{3, 3, 3}, plane{3, 3, 1};
    EXPECT_EQ(degree(cube, Neighbours::Faces, 13), 6u);
    EXPECT_EQ(degree(cube, Neighbours::Edges, 13), 18u);
    EXPECT_EQ(degree(cube, Neighbours::All, 13), 26u);
    EXPECT_EQ(degree(cube, Neighbours::All, 0), 7u);
    EXPECT_EQ(degree(plane, Neighbours::Faces, 4), 4u);
    EXPECT_EQ(degree(plane, Neighbours::All, 4), 8u);
}

/// The instance's lattice with a margin of air beyond the motion's reach.
ChainLattice lattice_of(const Instance& instance, int margin) {
    const Grid& grid = instance.volume.grid;
    ChainLattice lattice;
    lattice.size = grid.size + Vec3i{2 * margin, 2 * margin, 2 * margin};
    lattice.spacing_mm = grid.spacing_mm;
    for (int value = 0; value <= 10; ++value)
        lattice.materials.push_back(instance.law(value == 10 ? kAirHu : value));
    for (int k = 0; k < lattice.size.z; ++k)
        for (int j = 0; j < lattice.size.y; ++j)
            for (int i = 0; i < lattice.size.x; ++i) {
                const Vec3i e = Vec3i{i, j, k} - Vec3i{margin, margin, margin};
                const bool inside = contains(voxel_box(grid), e);
                lattice.material.push_back(inside ? std::uint8_t(instance.volume.at(e))
                                                  : std::uint8_t(10));
            }
    return lattice;
}

void run_against_chainmail(std::uint64_t seed, bool bounded) {
    Random random(seed);
    Instance instance = random_instance(random, 4, 7, true);
    instance.law = [law = instance.law, tightest = random.real(0.2, 2)](int value) {
        ElementLimits limits = law(value);
        if (value >= 0 && value < 9) limits.max_movement_mm = tightest * (1 + value % 3);
        return limits;
    };
    const int margin = bounded ? 0 : kInstanceMargin;
    const ChainLattice lattice = lattice_of(instance, margin);
    const Grid numbering{.size = lattice.size};
    const auto number = [&](Vec3i e) {
        return std::int32_t(voxel_index(numbering, e + Vec3i{margin, margin, margin}));
    };
    const auto graph = graph_of_lattice(lattice, Neighbours::Faces);
    ASSERT_TRUE(graph.ok());
    GraphChainMail tissue(*graph);
    const TaskArena arena(2);
    ChainMailSettings settings;
    settings.custom_law = instance.law;
    settings.bounded = bounded;
    ChainMail chainmail = std::move(ChainMail::create(instance.volume, settings, arena)).value();
    for (int step = 0; step < 4; ++step) {
        const std::vector<Vec3i> grabbed = random_grab(random, instance.volume.grid);
        std::vector<std::int32_t> numbers;
        for (const Vec3i e : grabbed) numbers.push_back(number(e));
        const Vec3d push_mm = random.vector((bounded ? 5 : 1) * instance.push_limit_mm.x);
        const auto expected = chainmail.push_elements(grabbed, push_mm);
        const auto found = tissue.push(numbers, push_mm, arena);
        ASSERT_TRUE(expected.ok() && found.ok());
        EXPECT_EQ(found->status, expected->status);
        EXPECT_EQ(found->limited_by, expected->limited_by);
        EXPECT_EQ(found->step_fraction, expected->step_fraction);
        EXPECT_EQ(found->moved_elements, expected->moved_elements);
        for (std::int32_t e = 0; e < graph->element_count(); ++e) {
            const Vec3i ijk{e % lattice.size.x, e / lattice.size.x % lattice.size.y,
                            e / (lattice.size.x * lattice.size.y)};
            const Vec3<Fixed> u =
                lattice_of(chainmail).displacement_at(ijk - Vec3i{margin, margin, margin});
            ASSERT_EQ(units(tissue.displacement_mm(e)), (Vec3<Int>{u.x, u.y, u.z}));
        }
    }
}

TEST(Graph, ALatticeGivesTheSameBitsAsChainMailItself) {
    for (std::uint64_t n = 0; n < 80 && !::testing::Test::HasFailure(); ++n) {
        SCOPED_TRACE("seed " + std::to_string(kGraphSeed + n));
        run_against_chainmail(kGraphSeed + n, n % 2 == 0);
    }
}

TEST(Graph, LargePushIsTheSameForEveryQueueAndThreadCount) {
    Random random(kGraphSeed);
    const Instance instance = random_instance(random, 40, 44, false);
    const auto graph = graph_of_lattice(lattice_of(instance, 0), Neighbours::All);
    ASSERT_TRUE(graph.ok());
    const std::vector<std::int32_t> first = {40'000, 40'001}, second = {31'234};
    std::set<std::uint64_t> hashes;
    for (const GraphQueue queue : {GraphQueue::Buckets, GraphQueue::Heap})
        for (const int threads : {1, 2, 4}) {
            const TaskArena arena(threads);
            GraphChainMail tissue(*graph, queue);
            ASSERT_TRUE(tissue.push(first, {3, -2, 1.5}, arena).ok());
            const auto report = tissue.push(second, {-2, 2.5, 1}, arena);
            ASSERT_TRUE(report.ok());
            EXPECT_GT(report->moved_elements, 1000);
            hashes.insert(tissue.hash());
        }
    EXPECT_EQ(hashes.size(), 1u);
}

TEST(Graph, LimitsOfAnObliqueLinkFollowTheGeneralisedFormulaWithItsSigns) {
    const std::vector<Vec3d> rest = {{0, 0, 0}, {2, -3, 0}};
    const std::vector<ElementLimits> materials = {
        {{0.1, 0.2, 0.3}, {0.5, 0.25, 0.4}, {0.01, 0.02, 0.03}, 500, false}};
    const auto graph = ChainGraph::create(rest, materials, {}, std::vector<ChainEdge>{{0, 1}});
    ASSERT_TRUE(graph.ok());
    const ChainNeighbour from_0 = graph->neighbours(0)[0], from_1 = graph->neighbours(1)[0];
    const auto expect_mm = [](Vec3i found, Vec3d expected) {
        for (int a = 0; a < 3; ++a) EXPECT_NEAR(found[a] * 0x1p-20, expected[a], 3e-6);
    };
    // Along y the link points down: its compression raises u(1) − u(0).
    expect_mm(from_0.low, {-(0.2 + 0.06), -(0.75 + 0.02), -(0.02 + 0.06)});
    expect_mm(from_0.high, {1.0 + 0.06, 0.6 + 0.02, 0.02 + 0.06});
    EXPECT_EQ(from_1.low, -from_0.high);
    EXPECT_EQ(from_1.high, -from_0.low);
    EXPECT_EQ(from_1.element, 0);
}

TEST(Graph, MeshesHaveEachEdgeOnce) {
    const std::vector<std::array<std::int32_t, 3>> triangles = {{0, 1, 2}, {2, 1, 3}};
    const std::vector<ChainEdge> square = {{0, 1}, {0, 2}, {1, 2}, {1, 3}, {2, 3}};
    EXPECT_EQ(edges_of_triangles(triangles), square);
    const std::vector<std::array<std::int32_t, 4>> tetrahedra = {{0, 1, 2, 3}, {4, 3, 2, 1}};
    EXPECT_EQ(edges_of_tetrahedra(tetrahedra).size(), 9u);
}

TEST(Graph, APushThroughATetrahedralMeshLeavesNoLinkOutsideOfItsLimits) {
    // Cubes of a block, split into five tetrahedra each.
    constexpr int kSide = 8;
    std::vector<Vec3d> rest;
    for (int n = 0; n < kSide * kSide * kSide; ++n)
        rest.push_back({double(n % kSide), double(n / kSide % kSide), double(n / kSide / kSide)});
    std::vector<std::array<std::int32_t, 4>> tetrahedra;
    constexpr int kSplit[5][4] = {
        {0, 1, 2, 4}, {3, 1, 2, 7}, {5, 1, 4, 7}, {6, 2, 4, 7}, {1, 2, 4, 7}};
    for (int c = 0; c < kSide * kSide * kSide; ++c) {
        const Vec3i p{c % kSide, c / kSide % kSide, c / kSide / kSide};
        if (std::max({p.x, p.y, p.z}) == kSide - 1) continue;
        for (const auto& corners : kSplit) {
            std::array<std::int32_t, 4> cell{};
            for (std::size_t n = 0; n < 4; ++n) {
                const int k = corners[n] ^ ((p.x + p.y + p.z) % 2 ? 1 : 0);
                cell[n] = c + (k & 1) + kSide * (k >> 1 & 1) + kSide * kSide * (k >> 2);
            }
            tetrahedra.push_back(cell);
        }
    }
    const std::vector<ElementLimits> materials = {
        {{0.2, 0.2, 0.2}, {0.2, 0.2, 0.2}, {0.2, 0.2, 0.2}, 500, false}};
    const auto graph = ChainGraph::create(rest, materials, {}, edges_of_tetrahedra(tetrahedra));
    ASSERT_TRUE(graph.ok());
    GraphChainMail tissue(*graph);
    const TaskArena arena(1);
    const auto report = tissue.push(std::array{0}, {-1, -1.5, 0.5}, arena);
    ASSERT_TRUE(report.ok());
    EXPECT_GT(report->moved_elements, 20);
    EXPECT_LT(report->moved_elements, kSide * kSide * kSide);
    EXPECT_EQ(check_links(*graph, tissue.displacements_mm(), 0).violated_links, 0);
    std::vector<Vec3d> wrong = tissue.displacements_mm();
    wrong[0].x -= 0x1p-20;
    EXPECT_GT(check_links(*graph, wrong, 0).violated_links, 0);
}

TEST(Graph, ResetBringsEverythingBackToItsRestPlace) {
    const auto graph = graph_of_lattice(
        {.size = {9, 9, 1}, .materials = {{.max_movement_mm = 500}}}, Neighbours::All);
    GraphChainMail tissue(*graph), untouched(*graph);
    const TaskArena arena(1);
    ASSERT_TRUE(tissue.push(std::array{40}, {1, 2, 3}, arena).ok());
    EXPECT_NE(tissue.hash(), untouched.hash());
    tissue.reset();
    EXPECT_EQ(tissue.hash(), untouched.hash());
}

void expect_refused(const Error& error, const std::string& part) {
    EXPECT_EQ(error.code, ErrorCode::InvalidArgument);
    EXPECT_NE(error.message.find(part), std::string::npos) << error.message;
}

TEST(Graph, WhatIsNotWellFormedIsRefusedWithItsNumber) {
    const std::vector<ChainElement> two(2);
    const auto refuse_link = [&](ChainLink link, const char* part) {
        const auto graph = ChainGraph::create(two, std::vector<ChainLink>{link});
        ASSERT_FALSE(graph.ok());
        expect_refused(graph.error(), part);
    };
    refuse_link({0, 2, {0, 0, 0}, {0, 0, 0}}, "link 0: expected two different elements");
    refuse_link({1, 1, {0, 0, 0}, {0, 0, 0}}, "link 0: expected two different elements");
    refuse_link({-1, 1, {0, 0, 0}, {0, 0, 0}}, "found -1 and 1");
    refuse_link({0, 1, {0.1, 0, 0}, {1, 0, 0}}, "low <= 0 <= high");
    refuse_link({0, 1, {0, NAN, 0}, {1, 0, 0}}, "low <= 0 <= high");
    EXPECT_FALSE(ChainGraph::create({}, {}).ok());
    const auto refuse_lattice = [](ChainLattice lattice, const char* part) {
        const auto graph = graph_of_lattice(lattice, Neighbours::Faces);
        ASSERT_FALSE(graph.ok());
        expect_refused(graph.error(), part);
    };
    refuse_lattice({.size = {0, 1, 1}, .materials = {{}}}, "size");
    refuse_lattice({.size = {70000, 70000, 1}, .materials = {{}}}, "size");
    refuse_lattice({.size = {2, 1, 1}}, "materials: expected 1 to 256, found 0");
    refuse_lattice({.size = {2, 1, 1}, .materials = {{}}, .material = {0}}, "found 1");
    refuse_lattice({.size = {2, 1, 1}, .materials = {{}}, .material = {0, 1}}, "below 1");
    refuse_lattice({.size = {2, 1, 1}, .materials = {{{-1, 0, 0}}}}, "materials[0].compress");
}

TEST(Graph, APushThatIsNoPushIsRefusedAndChangesNothing) {
    const auto graph = graph_of_lattice({.size = {3, 3, 3}, .materials = {{}}}, Neighbours::Faces);
    GraphChainMail tissue(*graph);
    const TaskArena arena(1);
    const std::uint64_t before = tissue.hash();
    EXPECT_FALSE(tissue.push(std::array{27}, {1, 0, 0}, arena).ok());
    EXPECT_FALSE(tissue.push(std::array{-1}, {1, 0, 0}, arena).ok());
    EXPECT_FALSE(tissue.push(std::array{0}, {NAN, 0, 0}, arena).ok());
    EXPECT_FALSE(tissue.push(std::array{0}, {501, 0, 0}, arena).ok());
    EXPECT_EQ(tissue.hash(), before);
}

}  // namespace
}  // namespace pliant::test
