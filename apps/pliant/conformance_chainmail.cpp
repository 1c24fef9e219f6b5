// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// ChainMail: numbers of elements, chains, and the least move against a relaxation of all links.

#include <pliant/chainmail.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "conformance.h"
#include "conformance_value.h"

namespace pliant::app {
namespace {
namespace mail {

constexpr double kFar_mm = 500;
constexpr double kVisible_mm = 1e-3;  ///< moved by more than rounding
constexpr int kFixedValue = 1000;

ElementLimits even_limits(double range, double shear) {
    return {.compress = {range, range, range},
            .stretch = {range, range, range},
            .shear = {shear, shear, shear},
            .max_movement_mm = kFar_mm};
}

struct Mail {
    std::unique_ptr<Volume> scan;
    std::unique_ptr<ChainMail> tissue;

    double moved_mm(Vec3i element) const { return norm(tissue->displacement_mm(element)); }
    std::int64_t visibly_moved() const {
        const Vec3i size = scan->grid.size;
        std::int64_t count = 0;
        for (int k = 0; k < size.z; ++k)
            for (int j = 0; j < size.y; ++j)
                for (int i = 0; i < size.x; ++i) count += moved_mm({i, j, k}) > kVisible_mm;
        return count;
    }
};

Mail mail_of(
    Vec3i size, ChainMailSettings settings, const TaskArena& arena, double z_spacing = 1,
    const std::function<int(Vec3i)>& value = [](Vec3i) { return 0; }) {
    Mail mail{std::make_unique<Volume>(), nullptr};
    mail.scan->grid.size = size;
    mail.scan->grid.spacing_mm = {1, 1, z_spacing};
    std::vector<std::int16_t> voxels;
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) voxels.push_back(std::int16_t(value({i, j, k})));
    mail.scan->voxels = std::move(voxels);
    mail.tissue =
        std::make_unique<ChainMail>(computed(ChainMail::create(*mail.scan, settings, arena)));
    return mail;
}

/// The same limits everywhere, except fixed elements; the scan's border is the object's.
ChainMailSettings even_mail(double range, double shear, double yield = 0) {
    ChainMailSettings settings;
    settings.max_movement_mm = kFar_mm;
    settings.bounded = true;
    settings.custom_law = [=](int value) {
        ElementLimits limits = even_limits(range, shear);
        limits.fixed = value == kFixedValue;
        limits.yield = yield;
        return limits;
    };
    return settings;
}

// Numbers of moved elements of the thesis's figure 6.2, and of the text below it. They are those of
// slices 2.22 to 2.25 pixels apart, where it says 2.2, and of links of exactly the offset.
void add_thesis(ConformanceCases& cases, const TaskArena& arena) {
    const struct {
        const char* name;
        double offset, scale;
        int moved;
    } rows[] = {{"Dräger's figure 6.2, offset 0.40", 0.40, 1, 56},
                {"Dräger's figure 6.2, offset 0.20", 0.20, 1, 224},
                {"Dräger's section 6.1, offset 0.20, scale 1.2", 0.20, 1.2, 328},
                {"Dräger's figure 6.2, offset 0.15", 0.15, 1, 392},
                {"Dräger's figure 6.2, offset 0.10", 0.10, 1, 1000},
                {"Dräger's figure 6.2, offset 0.08", 0.08, 1, 1888}};
    for (const auto& row : rows) {
        ChainMailSettings settings;
        settings.scale = row.scale;
        settings.custom_law = [=](int) { return even_limits(row.offset, row.offset); };
        const Mail mail = mail_of({64, 64, 32}, settings, arena, 2.23);
        const auto report = computed(
            mail.tissue->push({.point_mm = world_from_voxel(mail.scan->grid, {31.5, 31.5, 15.5}),
                               .push_mm = {0, 1, 0}}));
        cases.push_back({row.name,
                         "moved elements",
                         "Draeger2005",
                         double(row.moved),
                         1e-9,
                         {{"ChainMail", "all that moved", double(report.moved_elements)},
                          {"ChainMail", "by more than 1 um", double(mail.visibly_moved())}}});
    }
}

void add_chains(ConformanceCases& cases, const TaskArena& arena) {
    // Links between 0.6 and 1.4 mm: each takes 0.4 mm of the motion.
    const Mail even = mail_of({9, 1, 1}, even_mail(0.4, 0.4), arena);
    computed(even.tissue->push_elements(std::array{Vec3i{4, 0, 0}}, {2.4, 0, 0}));
    for (const auto& [name, at] : {std::pair("ahead of the push", 8), {"behind it", 1}})
        cases.push_back({std::string("chain, element ") + name,
                         "displacement [mm] for a push of 2.4",
                         "Gibson1996",
                         2.4 - 0.4 * std::abs(at - 4),
                         1e-4,
                         {{"ChainMail", "9 elements", even.moved_mm({at, 0, 0})}}});

    // Elements of three materials: a link takes the mean of its ends' limits.
    ChainMailSettings settings = even_mail(0, 0);
    settings.custom_law = [](int value) {
        return even_limits(0.1 * (1 + std::clamp(value, 0, 2)), 0.1);
    };
    const auto value = [](Vec3i e) { return e.x % 3; };
    const Mail mixed = mail_of({20, 1, 1}, settings, arena, 1, value);
    computed(mixed.tissue->push_elements(std::array{Vec3i{0, 0, 0}}, {-6, 0, 0}));
    double slack = 0;
    for (int n = 0; n < 17; ++n) slack += 0.1 + 0.05 * (n % 3 + (n + 1) % 3);
    cases.push_back({"chain of three materials",
                     "displacement of the 18th element [mm] for a pull of 6",
                     "pull - sum of the links' slack",
                     6 - slack,
                     1e-4,
                     {{"ChainMail", "20 elements", mixed.moved_mm({17, 0, 0})}}});

    // Fixed at one end, a chain can be drawn out by the slack of its links and no farther.
    const Mail held = mail_of({9, 1, 1}, even_mail(0.4, 0.4), arena, 1,
                              [](Vec3i e) { return e.x == 0 ? kFixedValue : 0; });
    const auto report =
        computed(held.tissue->push_elements(std::array{Vec3i{8, 0, 0}}, {10, 0, 0}));
    cases.push_back({"chain fixed at its end",
                     "fraction of a pull by 10 mm that is done",
                     "sum of the links' slack / pull",
                     0.32,
                     1e-4,
                     {{"ChainMail", "9 elements", report.step_fraction}}});

    // What stays is the strain beyond the yield limit.
    Mail plastic = mail_of({2, 1, 1}, even_mail(0.5, 0.5, 0.4), arena);
    computed(plastic.tissue->push_elements(std::array{Vec3i{0, 0, 0}}, {-5, 0, 0}));
    const auto length = [&] {
        return 1 + plastic.tissue->displacement_mm({1, 0, 0}).x -
               plastic.tissue->displacement_mm({0, 0, 0}).x;
    };
    computed(plastic.tissue->relax({}));
    cases.push_back({"plastic link, drawn to its limit 1.5 mm and let go",
                     "length at rest [mm] for a yield of 0.4",
                     "1 + (1 - yield) limit",
                     1.3,
                     1e-3,
                     {{"ChainMail", "2 elements, relaxed", length()}}});
}

void add_regions(ConformanceCases& cases, const TaskArena& arena) {
    // A push of 4.5 limits reaches four links: a diamond, an octahedron.
    const double limit = 0.2;
    for (const int depth : {1, 21}) {
        const Mail mail = mail_of({21, 21, depth}, even_mail(limit, limit), arena);
        const auto report = computed(
            mail.tissue->push_elements(std::array{Vec3i{10, 10, depth / 2}}, {4.5 * limit, 0, 0}));
        const double n = 4;
        cases.push_back(
            {depth == 1 ? "reach of a push in a sheet" : "reach of a push in a solid",
             "moved elements, four links away",
             depth == 1 ? "2 n^2 + 2 n + 1" : "(2 n + 1)(2 n^2 + 2 n + 3) / 3",
             depth == 1 ? 2 * n * n + 2 * n + 1 : (2 * n + 1) * (2 * n * n + 2 * n + 3) / 3,
             1e-9,
             {{"ChainMail", depth == 1 ? "21 x 21" : "21 x 21 x 21",
               double(report.moved_elements)}}});
    }
    // Gibson's largest cube: a corner moves 49.7 links away, on all axes.
    const Mail cube = mail_of({50, 50, 50}, even_mail(0.3, 0.3), arena);
    const auto report =
        computed(cube.tissue->push_elements(std::array{Vec3i{49, 49, 49}}, {14.9, 14.9, 14.9}));
    cases.push_back({"Gibson's cube of 125 000 elements, pulled by a corner",
                     "moved elements",
                     "number of i + j + k < 50: 50 x 51 x 52 / 6",
                     22100,
                     1e-9,
                     {{"ChainMail", "50 x 50 x 50", double(report.moved_elements)}}});

    // Tissue is as stiff along a diagonal as along an axis.
    ConformanceCase one{"isotropy of a push in homogeneous tissue",
                        "reach of half the push along a diagonal over that along an axis",
                        "1 in an isotropic solid", 1, 0.1};
    for (const LinkLimits limits : {LinkLimits::Box, LinkLimits::Rounded}) {
        ChainMailSettings settings = even_mail(0.1, 0.1);
        settings.limits = limits;
        const Mail mail = mail_of({61, 61, 61}, settings, arena);
        const double push = 4;
        computed(mail.tissue->push_elements(std::array{Vec3i{30, 30, 30}}, {0, 0, push}));
        const auto reach = [&](Vec3i step) {
            for (int n = 1; n < 30; ++n) {
                const auto moved = [&](int count) {
                    return mail.tissue
                        ->displacement_mm({30 + count * step.x, 30 + count * step.y, 30})
                        .z;
                };
                const double a = moved(n - 1), b = moved(n);
                if (b <= push / 2)
                    return (n - 1 + (a - push / 2) / (a - b)) *
                           norm(Vec3d{double(step.x), double(step.y), 0});
            }
            return 0.0;
        };
        one.results.push_back(
            {limits == LinkLimits::Box ? "ChainMail, box limits" : "ChainMail, rounded limits",
             "61 x 61 x 61", reach({1, 1, 0}) / reach({1, 0, 0})});
    }
    cases.push_back(std::move(one));
}

/// Limits by value that differ for compression, stretch and shear.
ElementLimits mixed_limits(int value) {
    const double v = std::clamp(value, 0, 6);
    return {.compress = {0.05 + 0.02 * v, 0.04 + 0.03 * v, 0.06 + 0.01 * v},
            .stretch = {0.10 + 0.03 * v, 0.05 + 0.02 * v, 0.08 + 0.04 * v},
            .shear = {0.12 + 0.02 * v, 0.07 + 0.05 * v, 0.03 + 0.06 * v},
            .max_movement_mm = kFar_mm};
}
int mixed_value(Vec3i e) {
    return int((std::uint32_t(e.x) * 73856093U ^ std::uint32_t(e.y) * 19349663U ^
                std::uint32_t(e.z) * 83492791U) >>
               5) %
           7;
}

/// Least displacement along an axis: all links are relaxed until none changes anything. A link from
/// x to y requires u(y) ≥ u(x) − slack for a push along the positive axis.
std::vector<double> relaxed(int side, int axis, Vec3i pushed, double push) {
    const auto index = [&](Vec3i e) {
        return std::size_t(e.x) +
               std::size_t(side) * (std::size_t(e.y) + std::size_t(side) * std::size_t(e.z));
    };
    std::vector<double> u(index({0, 0, side}), 0);
    u[index(pushed)] = push;
    for (bool changed = true; changed;) {
        changed = false;
        for (int k = 0; k < side; ++k)
            for (int j = 0; j < side; ++j)
                for (int i = 0; i < side; ++i)
                    for (int b = 0; b < 3; ++b) {
                        const Vec3i low{i, j, k};
                        Vec3i high = low;
                        ++high[b];
                        if (high[b] == side) continue;
                        const ElementLimits p = mixed_limits(mixed_value(low)),
                                            q = mixed_limits(mixed_value(high));
                        const auto mean = [&](const Vec3d ElementLimits::*limit) {
                            return 0.5 * ((p.*limit)[b] + (q.*limit)[b]);
                        };
                        const double up = mean(axis == b ? &ElementLimits::compress
                                                         : &ElementLimits::shear),
                                     down = mean(axis == b ? &ElementLimits::stretch
                                                           : &ElementLimits::shear);
                        double &x = u[index(low)], &y = u[index(high)];
                        if (y < x - up) y = x - up, changed = true;
                        if (x < y - down) x = y - down, changed = true;
                    }
    }
    return u;
}

void add_least_move(ConformanceCases& cases, const TaskArena& arena) {
    constexpr int kSide = 16;
    const Vec3d push{1.3, 0.9, 1.7};
    const Vec3i at{7, 8, 6};
    std::array<std::vector<double>, 3> expected;
    for (int axis = 0; axis < 3; ++axis)
        expected[std::size_t(axis)] = relaxed(kSide, axis, at, push[axis]);
    ConformanceCase least{"least move of seven materials at random",
                          "largest difference of an element [mm]",
                          "relaxation of all links, one by one", 0, 2e-5};
    ConformanceCase valid{"links after 40 pushes at random", "largest distance from a limit [mm]",
                          "Gibson1996", 0, 2e-5};
    for (const auto& [solver, name] : {std::pair(ChainMailSolver::Sweep, "ChainMail, sweeps"),
                                       {ChainMailSolver::Heap, "ChainMail, heap"}}) {
        ChainMailSettings settings = even_mail(0, 0);
        settings.custom_law = mixed_limits;
        settings.solver = solver;
        const Mail mail = mail_of({kSide, kSide, kSide}, settings, arena, 1, mixed_value);
        computed(mail.tissue->push_elements(std::array{at}, push));
        double worst = 0;
        std::size_t n = 0;
        for (int k = 0; k < kSide; ++k)
            for (int j = 0; j < kSide; ++j)
                for (int i = 0; i < kSide; ++i, ++n)
                    for (int axis = 0; axis < 3; ++axis)
                        worst =
                            std::max(worst, std::abs(mail.tissue->displacement_mm({i, j, k})[axis] -
                                                     expected[std::size_t(axis)][n]));
        least.results.push_back({name, "16 x 16 x 16", worst});
        std::uint32_t seed = 12345;
        const auto random = [&](int count) {
            seed = seed * 1664525U + 1013904223U;
            return int((seed >> 8) % std::uint32_t(count));
        };
        for (int turn = 0; turn < 40; ++turn) {
            const Vec3i element{random(kSide), random(kSide), random(kSide)};
            const Vec3d by{0.01 * (random(400) - 200), 0.01 * (random(400) - 200),
                           0.01 * (random(400) - 200)};
            computed(mail.tissue->push_elements(std::array{element}, by));
        }
        valid.results.push_back({name, "16 x 16 x 16", mail.tissue->state().max_violation_mm});
    }
    cases.push_back(std::move(least));
    cases.push_back(std::move(valid));
}

}  // namespace mail
}  // namespace

ConformanceCases chainmail_cases(const TaskArena& arena) {
    using namespace mail;
    ConformanceCases cases;
    add_chains(cases, arena);
    add_least_move(cases, arena);
    add_regions(cases, arena);
    add_thesis(cases, arena);
    return cases;
}

}  // namespace pliant::app
