// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Rounded limits against brute force, and their roundness.
// Covers: propagate/propagate_rounded.cpp.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <set>

#include "chainmail/chainmail_impl.h"
#include "chainmail/instances.h"
#include "lattice/lattice.h"
#include "support/random.h"

namespace pliant::test {
namespace {

using Whole = std::int64_t;

/// The definition, on a dense grid with a margin of air: elements are updated in rounds until
/// nothing changes, each position found by bisection.
class RoundedOracle {
  public:
    RoundedOracle(const Volume& volume, const MaterialLaw& law, int margin)
        : m_grid(volume.grid), m_margin(margin) {
        m_size = m_grid.size + Vec3i{2 * margin, 2 * margin, 2 * margin};
        for_each([&](Vec3i e) {
            const bool inside = contains(voxel_box(m_grid), e);
            m_limits.push_back(law(inside ? int(volume.at(e)) : kAirHu));
        });
        for (auto& u : m_u) u.assign(m_limits.size(), 0);
    }

    template <class Visit>
    void for_each(const Visit& visit) const {
        for (int z = -m_margin; z < m_grid.size.z + m_margin; ++z)
            for (int y = -m_margin; y < m_grid.size.y + m_margin; ++y)
                for (int x = -m_margin; x < m_grid.size.x + m_margin; ++x) visit(Vec3i{x, y, z});
    }
    Whole displacement(Vec3i e, int axis) const { return m_u[std::size_t(axis)][index(e)]; }

    void push(std::span<const Vec3i> grabbed, Vec3<Whole> shift) {
        for (int axis = 0; axis < 3; ++axis)
            if (shift[axis] != 0) push_component(grabbed, axis, shift[axis]);
    }

  private:
    std::size_t index(Vec3i e) const {
        const Vec3i p = e + Vec3i{m_margin, m_margin, m_margin};
        return std::size_t(p.x) + std::size_t(m_size.x) *
                                      (std::size_t(p.y) + std::size_t(m_size.y) * std::size_t(p.z));
    }
    bool is_inside(Vec3i e) const {
        for (int a = 0; a < 3; ++a)
            if (e[a] < -m_margin || e[a] >= m_grid.size[a] + m_margin) return false;
        return true;
    }
    /// Largest lag of `e` behind its neighbour `f` on axis b, when `sign`·u_axis rises.
    Whole lag(Vec3i e, Vec3i f, int b, int axis, int sign) const {
        const auto half = [&](Vec3i g) {
            const ElementLimits& limits = m_limits[index(g)];
            // f below e: the lower end leads, so the link gets shorter.
            const bool shorter = (f[b] < e[b]) == (sign > 0);
            const double fraction = b != axis ? limits.shear[b]
                                    : shorter ? limits.compress[b]
                                              : limits.stretch[b];
            return Whole(std::floor(m_grid.spacing_mm[b] * fraction / 2 * (1 << 20)));
        };
        return half(e) + half(f);
    }
    struct Link {
        std::size_t to;
        Whole lag;
        int axis;
    };
    static double sum(const std::vector<Link>& links, const std::vector<Whole>& w, Whole v) {
        double largest[3] = {0, 0, 0};
        for (const Link& link : links)
            if (link.lag > 0)
                largest[link.axis] =
                    std::max(largest[link.axis], double(w[link.to] - v) * (1.0 / double(link.lag)));
        double total = 0;
        for (const double t : largest) total += t * t;
        return total;
    }
    void push_component(std::span<const Vec3i> grabbed, int axis, Whole shift) {
        const int sign = shift > 0 ? 1 : -1;
        auto& u = m_u[std::size_t(axis)];
        std::vector<Whole> w(u.size());
        for (std::size_t n = 0; n < u.size(); ++n) w[n] = sign * u[n];
        std::vector<std::vector<Link>> links(u.size());
        std::vector<double> bound(u.size());
        for_each([&](Vec3i e) {
            for (int side = 0; side < 6; ++side) {
                Vec3i f = e;
                f[side / 2] += side % 2 ? 1 : -1;
                if (is_inside(f))
                    links[index(e)].push_back(
                        {index(f), lag(e, f, side / 2, axis, sign), side / 2});
            }
            bound[index(e)] = std::max(1.0, sum(links[index(e)], w, w[index(e)]));
        });
        for (const Vec3i& e : grabbed) w[index(e)] = sign * u[index(e)] + sign * shift;
        for (bool changed = true; changed;) {
            changed = false;
            for (std::size_t n = 0; n < w.size(); ++n) {
                const Whole place = least_place(links[n], w, bound[n], w[n]);
                changed |= place != w[n];
                w[n] = place;
            }
        }
        for (std::size_t n = 0; n < u.size(); ++n) u[n] = sign * w[n];
    }
    static Whole least_place(const std::vector<Link>& links, const std::vector<Whole>& w,
                             double bound, Whole v) {
        Whole highest = v;
        for (const Link& link : links) {
            v = std::max(v, w[link.to] - link.lag);
            highest = std::max(highest, w[link.to]);
        }
        if (sum(links, w, v) <= bound) return v;
        Whole low = v;  // violates the bound
        highest = std::max(highest, v);
        while (highest - low > 1) {
            const Whole middle = low + (highest - low) / 2;
            (sum(links, w, middle) <= bound ? highest : low) = middle;
        }
        return highest;
    }

    Grid m_grid;
    int m_margin;
    Vec3i m_size;
    std::vector<ElementLimits> m_limits;
    std::array<std::vector<Whole>, 3> m_u;
};

ChainMail rounded_tissue(const Volume& volume, const MaterialLaw& law, int brick_size,
                         const TaskArena& arena) {
    ChainMailSettings settings;
    settings.custom_law = law;
    settings.limits = LinkLimits::Rounded;
    settings.brick_size = brick_size;
    return std::move(ChainMail::create(volume, settings, arena)).value();
}

Vec3<Fixed> units_of(Vec3d mm) {
    return {units_from_mm(mm.x), units_from_mm(mm.y), units_from_mm(mm.z)};
}

TEST(Rounded, EqualsTheBruteForceFixedPointBitForBit) {
    std::int64_t moved = 0;
    for (std::uint64_t seed = 3000; seed < 3040 && !::testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        const TaskArena arena(2);
        const Instance instance = random_instance(random, 4, 7, false);
        ChainMail tissue = rounded_tissue(instance.volume, instance.law, random.whole(2, 9), arena);
        RoundedOracle oracle(instance.volume, instance.law, kInstanceMargin);
        Vec3d last{1, 1, 1};
        for (int step = 0; step < 3; ++step) {
            const auto grabbed = random_grab(random, instance.volume.grid);
            // The last push reverses the previous one: links lag further than rounded limits allow
            // in the new direction.
            last = step == 2 ? -1.0 * last : random.vector(instance.push_limit_mm.x);
            const auto report = tissue.push_elements(grabbed, last);
            ASSERT_EQ(report->status, PushStatus::Applied);
            const Vec3<Fixed> shift = units_of(last);
            oracle.push(grabbed, Vec3<Whole>{shift.x, shift.y, shift.z});
            std::int64_t differing = 0;
            oracle.for_each([&](Vec3i e) {
                const Vec3<Fixed> u = lattice_of(tissue).displacement_at(e);
                for (int a = 0; a < 3; ++a) differing += u[a] != oracle.displacement(e, a);
                moved += !(u == Vec3<Fixed>{0, 0, 0});
            });
            EXPECT_EQ(differing, 0) << "step " << step;
            EXPECT_LT(tissue.state().max_violation_mm, 1e-5) << "the box holds too";
        }
    }
    EXPECT_GT(moved, 10000);
}

TEST(Rounded, IsTheSameForEveryBrickSizeAndThreadCount) {
    Random random(77);
    const Instance instance = random_instance(random, 18, 22, false);
    const std::vector<Vec3i> first = {{9, 9, 9}, {10, 9, 9}}, second = {{12, 8, 10}};
    std::set<std::uint64_t> hashes;
    for (const int threads : {1, 2, 4})
        for (const int brick_size : {4, 8, 16}) {
            const TaskArena arena(threads);
            ChainMail tissue = rounded_tissue(instance.volume, instance.law, brick_size, arena);
            ASSERT_TRUE(tissue.push_elements(first, {2, -1.25, 0.75}).ok());
            ASSERT_TRUE(tissue.push_elements(second, {-2, 1, 1}).ok());
            hashes.insert(tissue.hash());
        }
    EXPECT_EQ(hashes.size(), 1u);
}

class RoundedBlock : public ::testing::Test {
  protected:
    static Volume block(int size, Vec3d spacing_mm) {
        Volume volume;
        volume.grid.size = {size, size, size};
        volume.grid.spacing_mm = spacing_mm;
        volume.voxels = std::vector<std::int16_t>(voxel_count(volume.grid), 40);
        return volume;
    }
    static MaterialLaw uniform(double fraction, double max_movement_mm = 500) {
        return [=](int) {
            const Vec3d v{fraction, fraction, fraction};
            return ElementLimits{v, v, v, max_movement_mm, false};
        };
    }
    TaskArena arena{2};
};

TEST_F(RoundedBlock, OnePushEqualsManyInTheSameDirection) {
    const Volume volume = block(24, {1, 1, 1.5});
    const std::vector<Vec3i> grabbed = {{12, 12, 12}, {12, 13, 12}};
    ChainMail once = rounded_tissue(volume, uniform(0.25), 8, arena);
    ChainMail often = rounded_tissue(volume, uniform(0.25), 8, arena);
    ASSERT_TRUE(once.push_elements(grabbed, {2, -1, 1.5}).ok());
    for (int n = 0; n < 8; ++n)
        ASSERT_TRUE(often.push_elements(grabbed, {0.25, -0.125, 0.1875}).ok());
    EXPECT_EQ(once.hash(), often.hash());
}

TEST_F(RoundedBlock, AFractionOfAPushFromRestIsTheShorterPush) {
    // Every element moves only when the tool is close to its end: raise(f) = raise − (1 − f)·δ.
    const Volume volume = block(24, {1, 1, 1.5});
    const std::vector<Vec3i> grabbed = {{12, 12, 12}};
    ChainMail limited = rounded_tissue(volume, uniform(0.25, 1.5), 8, arena);
    ChainMail shorter = rounded_tissue(volume, uniform(0.25), 8, arena);
    const auto report = limited.push_elements(grabbed, {4, 0, 0});
    EXPECT_EQ(report->limited_by, LimitedBy::Movement);
    const double done = limited.displacement_mm({12, 12, 12}).x;
    EXPECT_NEAR(done, 1.5, 1e-4);
    ASSERT_TRUE(shorter.push_elements(grabbed, {done, 0, 0}).ok());
    EXPECT_EQ(limited.hash(), shorter.hash());
}

/// Spread of the radius at which u_x falls to half of the push, (max − min)/mean, in a plane
/// through the pushed element.
double spread_of_radius(const ChainMail& tissue, Vec3i centre, double push_mm, int normal) {
    const int a = (normal + 1) % 3, b = (normal + 2) % 3;
    const Vec3d h = tissue.volume().grid.spacing_mm;
    const auto u = [&](double p, double q) {
        const int ip = int(std::floor(p)), iq = int(std::floor(q));
        double sum = 0;
        for (int c = 0; c < 4; ++c) {
            Vec3i e = centre;
            e[a] += ip + (c & 1);
            e[b] += iq + (c >> 1);
            const double wp = c & 1 ? p - ip : 1 - (p - ip), wq = c >> 1 ? q - iq : 1 - (q - iq);
            sum += wp * wq * tissue.displacement_mm(e).x;
        }
        return sum;
    };
    double least = 1e9, most = 0, total = 0;
    constexpr int kRays = 120;
    for (int k = 0; k < kRays; ++k) {
        const double angle = 2 * M_PI * k / kRays;
        double radius = 0;
        while (u(radius * std::cos(angle) / h[a], radius * std::sin(angle) / h[b]) > push_mm / 2)
            radius += 0.01;
        least = std::min(least, radius);
        most = std::max(most, radius);
        total += radius;
    }
    return (most - least) / (total / kRays);
}

TEST_F(RoundedBlock, ContoursAreRoundInAllPlanesAndForThickSlices) {
    for (const double z_scale : {1.0, 2.2}) {
        const Volume volume = block(40, {1, 1, z_scale});
        const Vec3i centre{20, 20, 20};
        const std::vector<Vec3i> grabbed = {centre};
        const double push_mm = 5;
        ChainMailSettings box;
        box.custom_law = uniform(0.25);
        ChainMail boxed = std::move(ChainMail::create(volume, box, arena)).value();
        ChainMail rounded = rounded_tissue(volume, uniform(0.25), 8, arena);
        ASSERT_TRUE(boxed.push_elements(grabbed, {push_mm, 0, 0}).ok());
        ASSERT_TRUE(rounded.push_elements(grabbed, {push_mm, 0, 0}).ok());
        for (int normal = 0; normal < 3; ++normal) {
            const double box_spread = spread_of_radius(boxed, centre, push_mm, normal);
            const double spread = spread_of_radius(rounded, centre, push_mm, normal);
            EXPECT_GT(box_spread, 0.3);
            // Measured: 0.075, and 0.101 in planes with thick slices; the box has 0.369.
            EXPECT_LT(spread, z_scale > 1 && normal != 2 ? 0.11 : 0.085);
        }
    }
}

}  // namespace
}  // namespace pliant::test
