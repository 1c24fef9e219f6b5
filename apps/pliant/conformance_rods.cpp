// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rods: the wire of a catheter in rigid lumens, where walls and friction are its loads, and wires
// whose tips are loaded or held.

#include <pliant/models/catheter.h>
#include <pliant/models/vessel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "conformance.h"
#include "conformance_value.h"

namespace pliant::app {
namespace {
namespace rods {

using std::numbers::pi;

using Numbers = std::vector<double>;
using Planes = std::array<Numbers, 3>;
/// Whether a cell of the grid is lumen.
using IsLumen = std::function<bool(Vec3i cell)>;

/// A rigid block between grid planes, with a lumen that is open at its lower end along z.
/// @param map  moves the nodes
VesselWall block_with_lumen(const Planes& planes, const IsLumen& is_lumen,
                            const std::function<Vec3d(Vec3d)>& map, const TaskArena& arena) {
    const Vec3i size{int(planes[0].size()), int(planes[1].size()), int(planes[2].size())};
    const auto node = [&](Vec3i at) { return at.x + size.x * (at.y + size.y * at.z); };
    TetMesh mesh;
    for (const double z : planes[2])
        for (const double y : planes[1])
            for (const double x : planes[0]) mesh.nodes_mm.push_back(map({x, y, z}));
    TriangleMesh lumen{mesh.nodes_mm, {}};
    // Six tetrahedra along the ways from the cell's lowest to its highest corner.
    constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                   {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int k = 0; k + 1 < size.z; ++k)
        for (int j = 0; j + 1 < size.y; ++j)
            for (int i = 0; i + 1 < size.x; ++i) {
                const Vec3i cell{i, j, k};
                if (is_lumen(cell)) continue;
                for (int way = 0; way < 6; ++way) {
                    std::array<std::int32_t, 4> tet{};
                    Vec3i at = cell;
                    tet[0] = node(at);
                    for (int step = 0; step < 3; ++step) {
                        ++at[kOrders[way][step]];
                        tet[std::size_t(step + 1)] = node(at);
                    }
                    if (way >= 3) std::swap(tet[1], tet[2]);
                    mesh.cells.push_back(tet);
                }
                for (int axis = 0; axis < 3; ++axis)
                    for (const int side : {0, 1}) {
                        Vec3i beside = cell;
                        beside[axis] += side == 0 ? -1 : 1;
                        if (beside[axis] < 0 || beside[axis] + 1 >= size[axis] || !is_lumen(beside))
                            continue;
                        Vec3i a = cell;
                        a[axis] += side;
                        Vec3i b = a, c = a, d = a;
                        ++b[(axis + 1) % 3];
                        ++c[(axis + 1) % 3];
                        ++c[(axis + 2) % 3];
                        ++d[(axis + 2) % 3];
                        std::array<std::int32_t, 3> first{node(a), node(b), node(c)},
                            second{node(a), node(c), node(d)};
                        if (side == 0) {
                            std::swap(first[1], first[2]);
                            std::swap(second[1], second[2]);
                        }
                        lumen.cells.push_back(first);
                        lumen.cells.push_back(second);
                    }
            }
    std::vector<std::int32_t> number(lumen.nodes_mm.size(), -1);
    TriangleMesh used;
    for (auto cell : lumen.cells) {
        for (std::int32_t& n : cell) {
            std::int32_t& to = number[std::size_t(n)];
            if (to < 0) {
                to = std::int32_t(used.nodes_mm.size());
                used.nodes_mm.push_back(lumen.nodes_mm[std::size_t(n)]);
            }
            n = to;
        }
        used.cells.push_back(cell);
    }
    return computed(wall_of_mesh(std::move(mesh), std::move(used), arena));
}

Numbers evenly(double from, double to, int steps) {
    Numbers planes;
    for (int n = 0; n <= steps; ++n) planes.push_back(from + (to - from) * n / steps);
    return planes;
}

/// A room from z = 0 to its end, of half the width along x and y.
VesselWall room(double half_x, double half_y, double end, const TaskArena& arena) {
    constexpr double kWall = 10;
    constexpr int kCells = 6;
    const auto across = [](double half) {
        Numbers planes = evenly(-half, half, kCells);
        planes.insert(planes.begin(), -half - kWall);
        planes.push_back(half + kWall);
        return planes;
    };
    Numbers along = evenly(0, end, kCells);
    along.push_back(end + kWall);
    return block_with_lumen(
        Planes{across(half_x), across(half_y), along},
        [](Vec3i c) {
            return c.x >= 1 && c.x <= kCells && c.y >= 1 && c.y <= kCells && c.z < kCells;
        },
        [](Vec3d x) { return x; }, arena);
}

/// A room with a narrow pocket in the middle of its end.
VesselWall room_with_pocket(double half, double end, double pocket_half, double pocket_end,
                            const TaskArena& arena) {
    const double t = 10;
    const Numbers across{-half - t, -half, -pocket_half, pocket_half, half, half + t};
    return block_with_lumen(
        Planes{across, across, Numbers{0, end, pocket_end, pocket_end + t}},
        [](Vec3i c) {
            const bool is_wide = c.x >= 1 && c.x <= 3 && c.y >= 1 && c.y <= 3;
            return (c.z == 0 && is_wide) || (c.z == 1 && c.x == 2 && c.y == 2);
        },
        [](Vec3d x) { return x; }, arena);
}

/// A round tube that is closed at its end; a square is bent to a disc.
VesselWall closed_tube(double radius, double end, int cells, const TaskArena& arena) {
    const double t = 0.5 * radius;
    auto across = evenly(-radius, radius, cells);
    across.insert(across.begin(), -radius - t);
    across.push_back(radius + t);
    auto along = evenly(0, end, std::max(1, int(end / (4 * radius))));
    along.push_back(end + t);
    const int last = int(along.size()) - 2;
    return block_with_lumen(
        Planes{across, across, along},
        [=](Vec3i c) { return c.z < last && c.x >= 1 && c.x <= cells && c.y >= 1 && c.y <= cells; },
        [](Vec3d x) {
            const double square = std::max(std::abs(x.x), std::abs(x.y)),
                         round = std::hypot(x.x, x.y);
            return round > 0 ? Vec3d{x.x * square / round, x.y * square / round, x.z} : x;
        },
        arena);
}

constexpr double kRadius = 0.5;  ///< of the wire [mm]
/// Distance of its axis from a wall that it touches: contact keeps its surface 0.05 mm off.
constexpr double kApart = kRadius + 0.05;
constexpr double kTube = 3;  ///< radius of a bent tube [mm]
constexpr double kInside =
    0.2;  ///< of the guide's end lies the node at which a wire is clamped [mm]
constexpr double kNudge_deg = 0.5;  ///< bend of a tip's rest shape, as an imperfection

CatheterSettings wire_settings(double length, double segment, double bend) {
    CatheterSettings s;
    s.catheter = {.length_mm = length,
                  .segment_mm = segment,
                  .radius_mm = kRadius,
                  .bend_n_mm2 = bend,
                  .twist_n_mm2 = bend,
                  .tip_mm = 0,
                  .tip_bend_n_mm2 = bend,
                  .mass_g_mm = 0.01,
                  .damping_per_s = 40,
                  .friction = 0,
                  .contact_mm_per_n = 1e-3};
    s.wall.model = WallModel::Rigid;
    s.entry = {{0, 0, 1}, {0, 0, 1}, segment};
    return s;
}

class Feed {
  public:
    Feed(VesselWall wall, const CatheterSettings& settings, const TaskArena& arena)
        : m_scene(computed(CatheterScene::create(std::move(wall), settings))), m_arena(arena) {}

    /// Feeds to a length at a speed, with a bent tip.
    void feed(double length_mm, double mm_s, double bend_deg = 0) {
        const double step_s = m_scene.settings().time_step_s,
                     way = length_mm - m_scene.quick_measures().inserted_mm;
        const int steps = std::max(1, int(std::lround(std::abs(way) / (mm_s * step_s))));
        wait_or_move(way / (steps * step_s), steps, bend_deg, 0);
    }
    void wait(double seconds, double bend_deg = 0) {
        wait_or_move(0, int(std::lround(seconds / m_scene.settings().time_step_s)), bend_deg, 0);
    }
    void turn(double deg, double seconds, double bend_deg) {
        wait_or_move(0, int(std::lround(seconds / m_scene.settings().time_step_s)), bend_deg,
                     deg / seconds);
    }
    void rig(const std::optional<TipRig>& rig) { computed(m_scene.rig_tip(rig)); }
    const CatheterScene& scene() const { return m_scene; }
    CatheterMeasures measures() const { return m_scene.quick_measures(); }

  private:
    void wait_or_move(double mm_s, int steps, double bend_deg, double deg_s) {
        computed(m_scene.command(
            {.insert_mm_s = mm_s, .rotate_deg_s = deg_s, .bend_first_deg = bend_deg}));
        computed(m_scene.step(steps, m_arena));
    }
    CatheterScene m_scene;
    const TaskArena& m_arena;
};

std::string segments_of(double segment) {
    return "segments of " + std::to_string(segment).substr(0, 3) + " mm";
}

// A rest-curved tip that touches nothing lies on an arc.
void add_arcs(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kTip = 60, kShaft = 12;
    for (const double deg : {90.0, 180.0, 360.0}) {
        const double angle = deg * pi / 180;
        ConformanceCase one{
            deg == 360 ? "wire bent to a circle"
                       : "rest-curved tip of " + std::to_string(int(deg)) + " degrees",
            deg == 360 ? "distance of the tip from the circle's beginning, of the length"
                       : "tip aside, of the length",
            "(1 - cos a) / a", deg == 360 ? 0 : (1 - std::cos(angle)) / angle,
            deg == 360 ? 0.01 : 0.01};
        for (const double segment : {3.0, 1.5}) {
            auto settings = wire_settings(120, segment, 20);
            settings.catheter.tip_mm = kTip;
            Feed feed(room(100, 100, 200, arena), settings, arena);
            feed.feed(kShaft + kTip, 400);
            for (int n = 1; n <= 20; ++n) feed.wait(0.02, deg * n / 20);
            feed.wait(0.4, deg);
            const Vec3d off = feed.scene().tip_mm() - Vec3d{0, 0, 1 + kShaft};
            one.results.push_back({"wire", segments_of(segment),
                                   (deg == 360 ? norm(off) : std::hypot(off.x, off.y)) / kTip});
        }
        cases.push_back(std::move(one));
    }
}

/// A clamped elastica whose tip is loaded by a force that keeps its direction: φ'' = −q sin φ,
/// φ'(L) = 0, with the angle φ from the load's direction.
struct Elastica {
    double along = 0;   ///< ∫ cos φ
    double across = 0;  ///< ∫ sin φ
};
/// @param q  load / EI. @param base  φ(0)
Elastica elastica_of(double q, double length, double base) {
    constexpr int kSteps = 400;
    const double h = length / kSteps;
    Elastica found;
    // From the tip to the base, by Runge and Kutta's method. @returns φ(0)
    const auto base_of = [&](double tip) {
        found = {};
        double phi = tip, rate = 0;
        for (int n = 0; n < kSteps; ++n) {
            const auto bend = [&](double p) { return -q * std::sin(p); };
            const double k1 = rate, l1 = bend(phi), k2 = rate + h / 2 * l1,
                         l2 = bend(phi + h / 2 * k1), k3 = rate + h / 2 * l2,
                         l3 = bend(phi + h / 2 * k2), k4 = rate + h * l3, l4 = bend(phi + h * k3);
            const double before = phi, middle = phi + h / 2 * k2;
            phi += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
            rate += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
            found.along += h / 6 * (std::cos(before) + 4 * std::cos(middle) + std::cos(phi));
            found.across += h / 6 * (std::sin(before) + 4 * std::sin(middle) + std::sin(phi));
        }
        return phi;
    };
    double low = base, high = pi;
    for (int n = 0; n < 60; ++n) {
        const double middle = 0.5 * (low + high);
        (base_of(middle) < base ? low : high) = middle;
    }
    return found;
}

// The guide is inclined to a smooth wall: the tip slides on it and bears a force across the wall. A
// node lies 0.2 mm inside of the guide's end, where the wire is clamped.
void add_elastica(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kLength = 95.8, kBend = 20;
    for (const auto& [deg, load] : {std::pair(60.0, 0.5), {45.0, 1.0}, {20.0, 1.5}}) {
        const double angle = deg * pi / 180;
        const Elastica exact = elastica_of(load / (kLength * kLength), kLength, angle);
        char name[120];
        std::snprintf(name, sizeof name, "elastica, tip on a wall at %g degrees, P L^2/EI %g", deg,
                      load);
        ConformanceCase force{name, "force of the hand along the guide [N]",
                              "EI a'' = -P sin a, by shooting",
                              load * kBend / (kLength * kLength) * std::cos(angle), 0.03};
        ConformanceCase aside{name, "tip from the guide along the wall [mm]",
                              "EI a'' = -P sin a, by shooting", exact.across, 0.01};
        for (const double segment : {6.0, 3.0, 1.5}) {
            auto settings = wire_settings(150, segment, kBend);
            settings.entry.position_mm = {-40, 0, 10};
            settings.entry.direction = {std::sin(angle), 0, std::cos(angle)};
            Feed feed(room(100, 40, 10 + exact.along + kApart, arena), settings, arena);
            feed.feed(kLength, 200);
            feed.wait(0.7);
            force.results.push_back({"wire", segments_of(segment), feed.measures().force_n});
            aside.results.push_back({"wire", segments_of(segment), feed.scene().tip_mm().x + 40});
        }
        cases.push_back(std::move(force));
        cases.push_back(std::move(aside));
    }
}

/// Complete elliptic integrals K and E of modulus k, by the arithmetic-geometric mean.
std::pair<double, double> elliptic_integrals(double k) {
    double a = 1, b = std::sqrt(1 - k * k), sum = k * k / 2, power = 1;
    while (a - b > 1e-15) {
        const double c = (a - b) / 2, mean = (a + b) / 2;
        b = std::sqrt(a * b);
        a = mean;
        sum += power * c * c;
        power *= 2;
    }
    const double first = pi / (2 * a);
    return {first, first * (1 - sum)};
}

// Columns whose slope is at most 20° after buckling: P = (n K)² EI / L² for n quarters of a wave.
void add_columns(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kLength = 95.8, kBend = 20, kPocket = 20;
    const auto [first, second] = elliptic_integrals(std::sin(pi / 18));
    const double height = (2 * second / first - 1) * kLength;
    for (const bool is_clamped : {false, true}) {
        const double quarters = is_clamped ? 4 : 1;
        ConformanceCase one{is_clamped ? "column, both ends clamped, 20 degrees after buckling"
                                       : "column on a smooth wall, 20 degrees after buckling",
                            "force of the hand over EI / L^2",
                            is_clamped ? "(4 K)^2; Euler's 4 pi^2" : "K^2; Euler's pi^2 / 4",
                            quarters * quarters * first * first, 0.03};
        for (const double segment : {6.0, 3.0, 1.5}) {
            auto settings = wire_settings(150, segment, kBend);
            settings.catheter.tip_mm = 0.5 * kLength;
            VesselWall wall = is_clamped ? room_with_pocket(60, 1 + height, kApart + 0.01,
                                                            1 + height + kPocket, arena)
                                         : room(60, 60, 1 + height + kApart, arena);
            Feed feed(std::move(wall), settings, arena);
            // An imperfection shows it the way, and goes.
            const double all = kLength + (is_clamped ? kPocket - kApart : 0);
            feed.feed(height + (is_clamped ? kPocket - 2 : -1), 200);
            feed.feed(all, 100, 2);
            feed.wait(0.2, 2);
            feed.wait(1);
            one.results.push_back({"wire", segments_of(segment),
                                   feed.measures().force_n * kLength * kLength / kBend});
        }
        cases.push_back(std::move(one));
    }
}

// A long column in a tube buckles to a helix, which lies on the wall. Half a pitch of 6.6 at each
// end does not, which makes the force some 8 % larger than that of the closed form.
void add_helix(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kGap = 3, kBend = 5, kEnd = 500, kSlope = 0.25;
    const double strain = 1 - std::cos(kSlope), length = kEnd / (1 - strain);
    const double force = 4 * kBend * strain / (kGap * kGap),
                 contact = kGap * force * force / (4 * kBend) * length;
    ConformanceCase axial{"column in a tube, buckled to a helix", "force of the hand [N]",
                          "4 EI e / r^2, e the shortening, r the gap", force, 0.05};
    ConformanceCase across{"column in a tube, buckled to a helix",
                           "sum of the contact forces on the side [N]", "r F^2 L / (4 EI)", contact,
                           0.05};
    for (const double segment : {6.0, 3.0}) {
        auto settings = wire_settings(700, segment, kBend);
        settings.catheter.tip_mm = 60;
        Feed feed(closed_tube(kGap + kApart, 1 + kEnd + kApart, 12, arena), settings, arena);
        feed.feed(kEnd - 5, 300);
        feed.feed(length, 60, 4);
        feed.wait(1);
        const CatheterMeasures m = feed.measures();
        axial.results.push_back({"wire", segments_of(segment), m.force_n});
        across.results.push_back({"wire", segments_of(segment), m.contact_n - m.force_n});
    }
    cases.push_back(std::move(axial));
    cases.push_back(std::move(across));
}

// The bent tip lies in a slot and can't turn, so the hand twists the shaft.
void add_torsion(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kShaft = 150, kTip = 30, kBend = 20, kTwist = 10, kTurn = pi / 4;
    const double hook = pi / 2 / kTip, ratio = kBend / kTwist * hook * hook;
    // ψ'' = EI κ²/GJ sin ψ cos ψ in the hook, ψ' = 0 at its end; ψ is linear in the shaft.
    double low = 0, high = kTurn, rate = 0;
    for (int turn = 0; turn < 60; ++turn) {
        const double tip = 0.5 * (low + high);
        double psi = tip;
        rate = 0;
        constexpr int kSteps = 2000;
        const double h = kTip / kSteps;
        for (int n = 0; n < kSteps; ++n) {
            const double middle = psi + h / 2 * rate;
            rate += h * ratio * std::sin(middle) * std::cos(middle);
            psi = middle + h / 2 * rate;
        }
        (psi + rate * kShaft < kTurn ? low : high) = tip;
    }
    ConformanceCase one{"torsion of a wire whose hooked tip lies in a slot",
                        "torque of the hand for 45 degrees [N mm]",
                        "a'' = EI k^2 / GJ sin a cos a in the hook", kTwist * rate, 0.05};
    for (const double segment : {6.0, 3.0}) {
        auto settings = wire_settings(220, segment, kBend);
        settings.catheter.twist_n_mm2 = kTwist;
        settings.catheter.tip_mm = kTip;
        Feed feed(room(60, kApart + 0.01, 250, arena), settings, arena);
        feed.feed(kShaft + kTip, 400);
        for (int n = 1; n <= 20; ++n) feed.wait(0.01, 4.5 * n);
        feed.wait(0.2, 90);
        feed.turn(kTurn * 180 / pi, 0.3, 90);
        feed.wait(0.5, 90);
        one.results.push_back({"wire", segments_of(segment), feed.measures().torque_n_mm});
    }
    cases.push_back(std::move(one));
}

/// Where a small bend of a twisted wire begins to grow: turn of the hand [rad] and torque [N mm].
/// The rate of growth is measured at turns of one part each, and its zero is interpolated.
/// @param feed  a wire at rest whose tip is held
/// @param aside  measures the bend
struct Buckling {
    double turn = 0, torque = 0;
};
Buckling buckling_of(Feed& feed, const std::function<double(Vec3d)>& aside, double part) {
    const auto size = [&] {
        double largest = 0;
        for (const Vec3d& x : feed.scene().wire_positions())
            largest = std::max(largest, std::abs(aside(x)));
        return largest;
    };
    Buckling before;
    double rate_before = 0;
    for (int n = 1; n <= 60; ++n) {
        feed.turn(part * 180 / pi, 0.05, 0);
        feed.wait(0.05, kNudge_deg);
        feed.wait(0.05);
        const double start = size();
        feed.wait(0.05);
        const double rate = std::log(size() / start);
        const Buckling now{n * part, feed.measures().torque_n_mm};
        if (rate > 0 && n > 1) {
            const double share = rate_before / (rate_before - rate);
            return {before.turn + share * part,
                    before.torque + share * (now.torque - before.torque)};
        }
        before = now;
        rate_before = rate;
    }
    throw ConformanceFailure{"a twisted wire has not buckled"};
}

// Both ends are clamped, and one may move along the axis: M L / EI = 2 x with tan x = x.
void add_twisted_column(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kLength = 96, kBend = 20, kRoot = 4.493409457909064;
    ConformanceCase one{"straight wire, twisted until it buckles, ends clamped (Greenhill)",
                        "critical torque of the hand, M L / EI", "2 x, tan x = x", 2 * kRoot, 0.02};
    for (const double segment : {6.0, 3.0, 1.5}) {
        auto settings = wire_settings(120, segment, kBend);
        settings.catheter.tip_mm = 0.5 * kLength;
        settings.catheter.damping_per_s = 400;
        settings.entry.position_mm = {0, 0, 50};
        Feed feed(room(100, 100, 250, arena), settings, arena);
        feed.feed(kLength - kInside, 400);
        feed.rig(TipRig{.hold = TipHold{.position_mm = feed.scene().tip_mm(), .slides = true}});
        const Buckling found = buckling_of(
            feed, [](Vec3d x) { return std::hypot(x.x, x.y); }, 2 * kRoot / 20.5);
        one.results.push_back({"wire", segments_of(segment), found.torque * kLength / kBend});
    }
    cases.push_back(std::move(one));
}

// A straight wire, bent to a ring that is closed with a twist, leaves its plane.
void add_twisted_ring(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kLength = 120, kBend = 20, kTwist = 25;
    ConformanceCase one{"ring, twisted until it leaves its plane (Michell, Zajac)",
                        "critical twist times GJ / EI", "2 pi sqrt 3", 2 * pi * std::sqrt(3.0),
                        0.02};
    for (const double segment : {6.0, 3.0, 1.5}) {
        auto settings = wire_settings(150, segment, kBend);
        settings.catheter.twist_n_mm2 = kTwist;
        settings.catheter.tip_mm = 0.25 * kLength;
        settings.catheter.damping_per_s = 400;
        settings.entry.position_mm = {0, 0, 100};
        Feed feed(room(100, 100, 300, arena), settings, arena);
        feed.feed(kLength - kInside, 400);
        constexpr int kParts = 60;
        for (int n = 1; n <= kParts; ++n) {
            const double angle = 2 * pi * n / kParts, radius = kLength / angle;
            feed.rig(TipRig{
                .hold = TipHold{.position_mm = Vec3d{radius * (1 - std::cos(angle)), 0,
                                                     100 - kInside + radius * std::sin(angle)},
                                .frame = rotation_by({0, angle, 0})}});
            feed.wait(0.01);
        }
        feed.wait(0.2);
        const Buckling found = buckling_of(
            feed, [](Vec3d x) { return x.y; }, 2 * pi * std::sqrt(3.0) * kBend / kTwist / 20.5);
        one.results.push_back({"wire", segments_of(segment), found.turn * kTwist / kBend});
    }
    cases.push_back(std::move(one));
}

/// A tube of radius 3 that goes straight, then along an arc in the plane of x and z, then straight.
std::vector<CentrePoint> bent_tube(double straight, double arc_radius, double angle, double end) {
    constexpr double kStep = 2;
    std::vector<CentrePoint> points;
    const auto add = [&](Vec3d at) { points.push_back({at, kTube}); };
    const auto on_arc = [&](double a) {
        return Vec3d{arc_radius * (1 - std::cos(a)), 0, straight + arc_radius * std::sin(a)};
    };
    for (double z = 0; z < straight; z += kStep) add({0, 0, z});
    const int parts = int(angle * arc_radius / kStep);
    for (int n = 0; n < parts; ++n) add(on_arc(angle * n / parts));
    const Vec3d ahead{std::sin(angle), 0, std::cos(angle)};
    for (double way = 0; way <= end; way += kStep) add(on_arc(angle) + way * ahead);
    return points;
}

// A force draws on the tip of a wire that lies on the inner side of a bend.
void add_capstan(ConformanceCases& cases, const TaskArena& arena) {
    constexpr double kRadius_mm = 40, kStraight = 20, kBeyond = 40, kLoad = 1, kBend = 5;
    for (const double deg : {90.0, 180.0})
        for (const double friction : {0.1, 0.3}) {
            const double angle = deg * pi / 180;
            char name[120];
            std::snprintf(name, sizeof name, "capstan, %g degrees, friction %g", deg, friction);
            ConformanceCase one{name, "force of the hand that draws it back, over that on the tip",
                                "exp(mu a) (Euler, Eytelwein)", std::exp(friction * angle), 0.03};
            for (const double segment : {3.0, 1.5}) {
                auto settings = wire_settings(300, segment, kBend);
                settings.catheter.friction = friction;
                settings.catheter.contact_mm_per_n = 0;
                settings.entry.position_mm = {kTube - kApart - 0.05, 0, 1};
                Feed feed(
                    computed(swept_tube(bent_tube(kStraight, kRadius_mm, angle, kBeyond + 20), {})),
                    settings, arena);
                const double all = kStraight + angle * kRadius_mm + kBeyond;
                for (double inserted = 2; inserted < all; inserted += 1) {
                    const Vec3d ahead = rotated(feed.scene().tip_frame(), {0, 0, 1});
                    feed.rig(TipRig{.force_n = kLoad * ahead});
                    feed.feed(inserted, 200);
                }
                feed.rig(TipRig{.force_n = kLoad * Vec3d{std::sin(angle), 0, std::cos(angle)}});
                feed.feed(all, 50);
                feed.wait(0.3);
                feed.feed(all - 5, 20);
                constexpr int kParts = 100;
                double force = 0;
                for (int n = 1; n <= kParts; ++n) {
                    feed.feed(all - 5 - 0.05 * n, 20);
                    force -= feed.measures().force_n / kParts;
                }
                one.results.push_back({"wire", segments_of(segment), force / kLoad});
            }
            cases.push_back(std::move(one));
        }
}

}  // namespace rods
}  // namespace

ConformanceCases rod_cases(const TaskArena& arena) {
    using namespace rods;
    ConformanceCases cases;
    add_arcs(cases, arena);
    add_elastica(cases, arena);
    add_columns(cases, arena);
    add_helix(cases, arena);
    add_torsion(cases, arena);
    return cases;
}

ConformanceCases rig_cases(const TaskArena& arena) {
    using namespace rods;
    ConformanceCases cases;
    add_twisted_column(cases, arena);
    add_twisted_ring(cases, arena);
    add_capstan(cases, arena);
    return cases;
}

}  // namespace pliant::app
