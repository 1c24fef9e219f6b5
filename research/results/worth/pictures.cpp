// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "pictures.h"

#include <cmath>

#include "bodies.h"
#include "chart.h"

namespace pliant::results {
namespace {

constexpr int kOfNu045 = 2;  ///< in blocks()

/// Share of the push [%] of the nodes below the middle of the tool, by depth [mm].
std::vector<Point2> below_tool(const Displacements& u, const Body& body, const Load& load) {
    std::vector<Point2> points;
    const int top = body.lattice.size.z - 1;
    for (int k = top; k >= 0; --k) {
        const Vec3i node{int(load.centre.x), int(load.centre.y), k};
        points.push_back({double(top - k),
                          100 * u[std::size_t(node_index(body.lattice, node))].z / load.push.z});
    }
    return points;
}

}  // namespace

void add_profile(Page& page, const TaskArena& arena) {
    Body body = blocks()[kOfNu045];
    hold_block(body, false);
    const Load load{{16, 16, 24}, 4, {0, 0, -2}};
    const ChainBody chain(body, arena);
    const Answer fem = finite_elements(body, load, kConverged, arena);
    double offset = 0;
    best_offset(chain, fem.displacement_mm, body, load, &offset);
    Chart chart(760, 420, {"depth below the tool's centre [mm]", 0, 24, 4},
                {"displacement along the push [% of the push]", 0, 100, 20});
    const auto curve = [&](const Answer& answer, Rgb8 colour, const std::string& name) {
        chart.curve(below_tool(answer.displacement_mm, body, load), {colour, 2, 1}, name);
    };
    curve(fem, kDark, "finite elements");
    curve(chain.push(load, {.offset = kDefaultOffset}), kRed, "ChainMail, default (offset 0.2)");
    curve(chain.push(load, {.offset = offset}), kOrange,
          "ChainMail, best offset (" + fixed_text(offset, 2) + ")");
    page.picture("depth", "displacement by depth of finite elements and of ChainMail",
                 chart.image());
}

void add_error_over_time(Page& page, const Study& study) {
    Chart chart(760, 420, {"log10 of the time of a solve [ms], one thread", -2, 3, 1},
                {"mean error [% of the push]", 0, 20, 5});
    std::vector<Point2> stopped;
    for (const Timed& timed : study.stopped)
        stopped.push_back({std::log10(timed.mean_ms()), timed.errors.mean().mean});
    chart.curve(stopped, {kDark, 2, 1}, "finite elements, stopped at residuals of 0.3 to 0.001");
    const std::vector<Point2> by_default = {
        {std::log10(study.by_default.mean_ms()), study.by_default.errors.mean().mean}};
    chart.dots(by_default, {kRed, 5, 1}, "ChainMail, default");
    page.picture("time", "mean error over the time of a solve", chart.image());
}

void add_refinement(Page& page, const TaskArena& arena) {
    std::vector<std::vector<std::string>> rows;
    for (const int material : {0, kOfNu045, kOfNu045 + 1}) {
        Body body = blocks()[std::size_t(material)];
        const Vec3i size = body.lattice.size;
        Body fine = make_body(body.name,
                              {{2 * size.x - 1, 2 * size.y - 1, 2 * size.z - 1}, {0.5, 0.5, 0.5}},
                              body.materials, [](Vec3d) { return 0; });
        ErrorsOfLoads errors;
        for (const int n : {0, 1, 7}) {
            hold_block(body, n % 2 != 0);
            hold_block(fine, n % 2 != 0);
            const Load load = random_block_load(n);
            const Load twice{2.0 * load.centre, 2 * load.radius, 2.0 * load.push};
            const Answer coarse = finite_elements(body, load, kConverged, arena);
            const Answer refined = finite_elements(fine, twice, kConverged, arena);
            Displacements common;
            for (int k = 0; k < size.z; ++k)
                for (int j = 0; j < size.y; ++j)
                    for (int i = 0; i < size.x; ++i)
                        common.push_back(refined.displacement_mm[std::size_t(
                            node_index(fine.lattice, {2 * i, 2 * j, 2 * k}))]);
            errors.add(errors_of(coarse.displacement_mm, common, body, load));
        }
        const Errors mean = errors.mean();
        rows.push_back({body.name, fixed_text(mean.mean, 2), fixed_text(mean.p95, 2)});
    }
    page.table({"material", "mean [% of the push]", "p95"}, rows);
}

}  // namespace pliant::results
