// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The chest around the airway: skin, fat, muscle, ribs, spine, heart and great vessels, lungs with
// their vessels, liver. A small chest: it must fit the airway's cube with the airway at full size.
// The proportions are those of a chest with raised arms, cut off at the inlet and at the liver.
// Blood has some contrast (150 HU), far below the bone threshold.

#include "volume/phantom_bodies.h"
#include "volume/phantom_noise.h"
#include "volume/phantom_tubes.h"

namespace pliant::phantom {
namespace {

constexpr double kBlood_hu = 150;
constexpr double kRibPeriod_mm = 18;
constexpr double kVertebraPeriod_mm = 19;

double body(Vec3d p) {
    const double groove = 2 * bump(p.x, 7) * ramp(20, 50, p.y);
    const double waist = 2.5 * ramp(-10, -64, p.z);
    return stadium(p.x, p.y - 4.5, 10, 49.5) + groove + waist;
}

/// Inside of the ribs.
double cavity(Vec3d p) {
    const double apex = 17 * ramp(10, 80, p.z);
    return stadium(p.x, p.y - 2, 10 - 0.2 * apex, 37.5 - apex);
}

/// Right and left dome, with the upper face of the diaphragm as surface.
double domes(Vec3d p) {
    return std::min(ellipsoid(p, {-27, 4, -88}, {42, 46, 46}),
                    ellipsoid(p, {28, 6, -93}, {40, 44, 44}));
}

/// Wraps z to one period around 0.
double repeated(double z, double period) {
    return z - period * std::floor(z / period + 0.5);
}

double vertebra(Vec3d p) {
    const double z = repeated(p.z - 2, kVertebraPeriod_mm);
    const double waist = 1.3 * bump(z, 5);
    const double column = ellipsoid({p.x, p.y, 0}, {0, 31, 0}, {12, 8.6, 12}) + waist;
    const double trunk = smooth_intersection(column, std::abs(z) - 7.4, 2);
    const Vec3d q{std::abs(p.x), p.y, z};
    const double arch = torus({p.x, p.y, 0.55 * z}, {0, 42.5, 0}, 6.6, 1.8);
    const double wing = capsule(q, {6, 41, 1}, {16, 45.5, 3.5}, 2.6, 2.2);
    const double spine = capsule(q, {0, 48, -1}, {0, 50.5, -7}, 1.9, 1.6);
    const double back = smooth_union(smooth_union(arch, wing, 2), spine, 2);
    return smooth_union(trunk, back, 2);
}

double disc(Vec3d p) {
    return ellipsoid({p.x, p.y, 0}, {0, 31, 0}, {11.6, 8.2, 11.6});
}

double ribs(Vec3d p) {
    const double slanted = p.z - 0.5 * p.y + 4;
    const double z = repeated(slanted, kRibPeriod_mm);
    const double out = cavity(p) - 3.1;
    const double rib = std::sqrt(out * out + 0.42 * z * z) - 2.3;
    return std::max(rib, (p.y < 0 ? 8 : 14) - std::abs(p.x));
}

double scapulae(Vec3d p) {
    const double sheet = std::abs(cavity(p) - 8.2 - 2.5 * ramp(10, 60, p.z)) - 1.0;
    const Vec3d q = mirrored_x(p);
    const double outline = ellipsoid(q, {41, 27, 44}, {18, 17, 34});
    return std::max(sheet, outline);
}

double sternum(Vec3d p) {
    return box(p, {0, -40.5, 12}, {8.5 - 0.05 * p.z, 2.7, 46}, 2.4);
}

struct Vessel {
    std::vector<TubePoint> row;
    double hu;
};

std::vector<Vessel> great_vessels() {
    using Row = std::vector<TubePoint>;
    const Row aorta = {{{3, -14, -24}, 8.5},   {{-5, -19, -8}, 8.6}, {{-7, -21, 8}, 8.2},
                       {{-2, -21.5, 19}, 8},   {{8, -17, 25}, 7.8},  {{16.5, -6, 25}, 7.5},
                       {{18.5, 5, 20}, 7.3},   {{17, 14, 9}, 7.2},   {{15.5, 17.5, -10}, 7},
                       {{14, 18.5, -35}, 6.8}, {{10, 18, -70}, 6.6}};
    const Row trunk = {{{9, -26.5, -26}, 8.4}, {{13, -22.5, -13}, 8.2}, {{18, -12.5, -5}, 6.8},
                       {{26, -2.5, -6}, 6.2},  {{31.5, 8.5, -12}, 5.4}, {{33, 14, -24}, 4.2}};
    const Row right_artery = {{{12, -22.5, -12}, 7},
                              {{0, -16.5, -14}, 6.4},
                              {{-13, -13, -16}, 6},
                              {{-24, -7.5, -20}, 5},
                              {{-29, -0.5, -30}, 4}};
    const Row cava = {
        {{-8, -17, 70}, 4.8}, {{-14, -14, 40}, 5.2}, {{-15.5, -13, 10}, 5.4}, {{-14, -13, -26}, 6}};
    const Row innominate = {{{0, -21, 20}, 4.6}, {{-5, -15, 40}, 4.2}, {{-9, -10, 70}, 3.8}};
    const Row carotid = {{{8, -18, 26}, 3.4}, {{10.5, -12, 45}, 3.1}, {{11.5, -8, 70}, 3}};
    const Row subclavian = {{{16, -7, 25}, 3.8}, {{17, 0, 45}, 3.6}, {{19, 2, 70}, 3.4}};
    const Row azygos = {{{-6.5, 17.5, -70}, 2.2},
                        {{-7, 16.5, -10}, 2.4},
                        {{-11, 13, 7}, 2.6},
                        {{-15.5, 2, 10}, 2.8},
                        {{-15, -12, 8}, 2.8}};
    const Row veins_right = {{{-6, -3, -32}, 5}, {{-20, -3, -31}, 3.8}, {{-31, 2, -38}, 2.8}};
    const Row veins_left = {{{12, 1, -32}, 5}, {{24, 1, -29}, 3.8}, {{34, -2, -27}, 2.8}};
    std::vector<Vessel> vessels;
    for (const Row& row : {aorta, trunk, right_artery, cava, innominate, carotid, subclavian,
                           azygos, veins_right, veins_left})
        vessels.push_back({smooth_row(row, 5), kBlood_hu});
    return vessels;
}

/// The tissue between the lungs, with fat.
ScalarField mediastinum(const std::vector<Vessel>& vessels, const ScalarField& airway_outer) {
    constexpr double kSheath_mm = 1.2;
    std::vector<TubeRow> tubes;
    for (const Vessel& v : vessels) tubes.emplace_back(v.row);
    return [=](Vec3d p) {
        const double width = 12.5 - 8 * ramp(-16, -30, p.y);
        double d = 0.8 * (std::abs(p.x) - width);
        d = smooth_union(d, ellipsoid({p.x, p.y, 0}, {0, 31, 0}, {14.5, 12, 14}), 4);
        d = smooth_union(d, ellipsoid(p, {13, -15, -36}, {31, 23.5, 27}), 5);
        d = std::min(d, TubeTree::kFar_mm);
        for (const TubeRow& tube : tubes)
            if (tube.least_distance(p) - kSheath_mm < d)
                d = tube.find(p, d + kSheath_mm).distance_mm - kSheath_mm;
        const double hilum = 0.7 * (std::abs(p.x) - 27);
        return hilum < d ? std::min(d, std::max(airway_outer(p) - 1, hilum)) : d;
    };
}

/// A node of a lung's vessel tree.
struct Node {
    Vec3d x;
    std::size_t parent;
    double path_mm;  ///< from the root
    double leaves;   ///< number of ends supplied through this node
};

/// Grows a vessel tree in a lung: random points join, nearest to the root first, the node with the
/// shortest path to the root. Radii follow Murray's law [Murray1926]: their cubes add up where
/// vessels join.
std::vector<Node> grow_vessels(const ScalarField& lung, Vec3d root, Vec3d middle, Vec3d half,
                               std::uint64_t seed) {
    constexpr int kTries = 900;
    Chance chance(seed);
    std::vector<Node> nodes;
    for (int n = 0; n < kTries; ++n) {
        const Vec3d x = middle + scaled(half, chance.vector());
        if (lung(x) < -1.5) nodes.push_back({x, 0, 0, 1});
    }
    std::sort(nodes.begin(), nodes.end(),
              [=](const Node& a, const Node& b) { return norm(a.x - root) < norm(b.x - root); });
    nodes.insert(nodes.begin(), {root, 0, 0, 0});
    for (std::size_t n = 1; n < nodes.size(); ++n) {
        double least = 1e9;
        for (std::size_t m = 0; m < n; ++m) {
            const double step = norm(nodes[n].x - nodes[m].x);
            const double cost = step + 0.4 * nodes[m].path_mm;
            if (cost >= least) continue;
            least = cost;
            nodes[n].parent = m;
            nodes[n].path_mm = nodes[m].path_mm + step;
        }
    }
    for (std::size_t n = nodes.size() - 1; n > 0; --n)
        nodes[nodes[n].parent].leaves += nodes[n].leaves;
    return nodes;
}

double cube_root(double v) {
    double r = v > 1 ? 0.3 * v + 1 : 1;
    for (int n = 0; n < 40; ++n) r = (2 * r + v / (r * r)) / 3;
    return r;
}

void add_lung_vessels(LayerStack& stack, const ScalarField& lung, Vec3d root, Vec3d middle,
                      Vec3d half, std::uint64_t seed) {
    constexpr double kEnd_mm = 0.42;  // radius of the smallest vessels visible in a scan
    const std::vector<Node> nodes = grow_vessels(lung, root, middle, half, seed);
    Chance chance(seed + 1);
    for (std::size_t n = 1; n < nodes.size(); ++n) {
        const Node& from = nodes[nodes[n].parent];
        const double ra = std::min(kEnd_mm * cube_root(nodes[n].leaves + 0.5), 3.4);
        const double rb = kEnd_mm * cube_root(nodes[n].leaves);
        const Vec3d a = from.x, b = nodes[n].x;
        const Vec3d bent = 0.5 * (a + b) + (0.1 * norm(b - a)) * chance.vector();
        const double rm = 0.5 * (ra + rb);
        stack.add(
            [=](Vec3d p) {
                return std::min(capsule(p, a, bent, ra, rm), capsule(p, bent, b, rm, rb));
            },
            tissue(60, 10));
    }
}

void add_chest_wall(LayerStack& stack) {
    stack.add([](Vec3d p) { return box(p, {0, 58.5, 0}, {50, 2.6, 90}, 2); }, uniform(-120));
    stack.add([](Vec3d p) { return box(p, {0, 58.5, 0}, {49, 1.9, 90}, 1.5); }, uniform(-930));
    stack.add(body, tissue(25, 8));
    stack.add([](Vec3d p) { return body(p) + 1.5; }, tissue(-102, 9, 9, 5));
    const auto muscle = [](Vec3d p) {
        return 0.8 * (body(p) + 4.2 + 1.6 * value_noise(p * 0.09, 31));
    };
    stack.add(muscle, tissue(52, 9, 6, 3));
    const auto streak = [](Vec3d p) {
        const double depth = cavity(p) - 6.4 - 1.4 * value_noise(p * 0.07, 32);
        return 0.75 * (std::abs(depth) - 0.55);
    };
    stack.add(streak, tissue(-70, 9));
    const auto cortex = [](Vec3d p) { return p.y < -24 ? 115.0 : 650.0; };
    stack.add(scapulae, tissue(520, 25, 60, 3), 1.2);
    stack.add(ribs, cortex, 1.3);
    stack.add([](Vec3d p) { return ribs(p) + 1.1; },
              [](Vec3d p) { return p.y < -24 ? 95.0 : 240 + 60 * value_noise(p * 0.5, 33); }, 1.3);
    stack.add(cavity, tissue(-98, 9, 8, 5), 1.1);
    stack.add(sternum, tissue(480, 20));
    stack.add([](Vec3d p) { return sternum(p) + 1; }, tissue(150, 20, 50, 2));
}

void add_spine(LayerStack& stack) {
    stack.add(disc, tissue(85, 8));
    stack.add([](Vec3d p) { return stadium(p.x, p.y - 42.5, 1.5, 5.8); }, tissue(12, 8));
    stack.add([](Vec3d p) { return stadium(p.x, p.y - 43.5, 0.8, 2.9); }, tissue(42, 8));
    stack.add(vertebra, tissue(640, 20, 60, 3), 1.3);
    stack.add([](Vec3d p) { return vertebra(p) + 1.3; }, tissue(215, 22, 70, 1.8), 1.3);
}

void add_belly(LayerStack& stack) {
    const auto below = [](Vec3d p) { return std::max(cavity(p) + 0.6, domes(p)); };
    stack.add(below, tissue(50, 8), 1.1);
    const auto liver = [](Vec3d p) { return std::max(cavity(p) + 1.6, domes(p) + 1.8); };
    stack.add([=](Vec3d p) { return std::max(liver(p), 0.8 * (p.x - 14 - 0.2 * p.y)); },
              tissue(105, 9, 10, 5));
    stack.add(
        [=](Vec3d p) {
            return std::max(liver(p), ellipsoid(p, {34, 20, -62}, {15, 17, 14}));
        },
        tissue(118, 9, 8, 3));
    stack.add(
        [=](Vec3d p) {
            return std::max(liver(p) + 1, ellipsoid(p, {30, -12, -66}, {16, 17, 13}));
        },
        tissue(45, 9));
    stack.add(
        [=](Vec3d p) {
            return std::max(
                {liver(p) + 3, ellipsoid(p, {30, -12, -66}, {13.5, 14.5, 11}), p.y + 12});
        },
        uniform(-985));
}

void add_heart(LayerStack& stack) {
    stack.add(
        [](Vec3d p) {
            return ellipsoid(p, {13, -15, -36}, {28, 20.5, 24}) + 0.6 * value_noise(p * 0.12, 34);
        },
        tissue(95, 9, 6, 4), 1.1);
    const auto chamber = [&stack](Vec3d centre, Vec3d radii) {
        stack.add(
            [=](Vec3d p) {
                return 0.85 * (ellipsoid(p, centre, radii) + 0.8 * value_noise(p * 0.22, 35));
            },
            tissue(kBlood_hu, 9));
    };
    chamber({25, -15, -42}, {10, 8.5, 13});
    chamber({4, -25, -42}, {12, 7.5, 13});
    chamber({-7, -13, -34}, {9, 10, 13});
    chamber({10, 0, -31}, {15, 7, 10});
}

void add_great_vessels(LayerStack& stack, const std::vector<Vessel>& vessels) {
    for (const Vessel& v : vessels) {
        const ScalarField inside = row_of_capsules(v.row);
        stack.add([=](Vec3d p) { return inside(p) - 0.8; }, tissue(50, 9));
    }
    for (const Vessel& v : vessels) stack.add(row_of_capsules(v.row), tissue(v.hu, 10));
    const ScalarField oesophagus = row_of_capsules(smooth_row(
        {{{4, 11.5, 70}, 4.4}, {{3.5, 12, 30}, 4.4}, {{3, 13, -5}, 4.2}, {{5, 10, -70}, 4.6}}, 5));
    const auto flattened = [=](Vec3d p) { return 0.8 * oesophagus({p.x, p.y, p.z}); };
    stack.add(flattened, tissue(42, 9));
    stack.add([=](Vec3d p) { return flattened(p) + 2.9; }, uniform(-420));
    Chance chance(41);
    for (int n = 0; n < 9; ++n) {
        const Vec3d c{chance.between(-10, 10), chance.between(-16, 12), chance.between(-22, 10)};
        const double r = chance.between(1.4, 2.8);
        stack.add([=](Vec3d p) { return ellipsoid(p, c, {r, 1.2 * r, 1.7 * r}); }, tissue(48, 9));
    }
}

void add_lungs(LayerStack& stack, const ScalarField& between) {
    const ScalarField lung = [=](Vec3d p) {
        return std::max({cavity(p) + 0.8, -between(p), -(domes(p) - 1.6)});
    };
    const auto parenchyma = [](Vec3d p) {
        return -868 + 0.7 * p.y + 22 * value_noise(p * 0.55, 36) + 14 * value_noise(p * 0.2, 37) +
               10 * value_noise(p * (1 / 1.3), 11);
    };
    stack.add(lung, parenchyma, 1.1);
    stack.add(
        [=](Vec3d p) {
            const double major = (p.z - 2 - 0.9 * p.y) * 0.74 + 1.5 * value_noise(p * 0.06, 38);
            const double minor = p.z + 12 - 0.1 * p.y + 1.5 * value_noise(p * 0.06, 39);
            const double right = std::max({std::abs(minor), -major, p.x + 5});
            const double sheet = std::min(std::abs(major), right);
            return std::max(sheet - 0.28, lung(p) + 0.3);
        },
        uniform(-600), 1.2);
    // arteries, then veins, on both sides
    const Vec3d right{-32, 2, 5}, left{34, 2, 5}, half{20, 38, 58};
    add_lung_vessels(stack, lung, {-25, 0, -19}, right, half, 51);
    add_lung_vessels(stack, lung, {-25, -2, -33}, right, half, 53);
    add_lung_vessels(stack, lung, {31, 8, -10}, left, half, 55);
    add_lung_vessels(stack, lung, {27, -1, -29}, left, half, 57);
}

}  // namespace

void add_chest(LayerStack& stack, const ScalarField& airway_outer) {
    const std::vector<Vessel> vessels = great_vessels();
    add_chest_wall(stack);
    add_spine(stack);
    add_belly(stack);
    add_lungs(stack, mediastinum(vessels, airway_outer));
    add_heart(stack);
    add_great_vessels(stack, vessels);
}

}  // namespace pliant::phantom
