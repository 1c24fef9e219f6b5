// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/research/spring_probe.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/text.h"
#include "mesh/surface_winding.h"
#include "springs/touch.h"

namespace pliant {

struct SpringProbe::Impl {
    Impl(const SpringNetwork& network, std::vector<std::array<std::int32_t, 3>> triangles,
         const SpringProbeSettings& settings)
        : touch(network, std::move(triangles)),
          stride(settings.stride > 0 ? settings.stride : 0.25 * touch.mean_edge()) {
        tool.radius = settings.radius;
        const auto count = std::size_t(network.node_count());
        nodes.reserve(3 * touch.triangles().size());
        held.reserve(count);
        positions.reserve(count);
        kept_triangles.reserve(touch.triangles().size());
        tool.triangles.reserve(touch.triangles().size());
    }

    Status hold(SpringTissue& tissue);
    Result<SpringStep> step(SpringTissue& tissue, Vec3d way, std::int32_t steps, bool& is_stopped,
                            const TaskArena& arena);

    TriangleTouch touch;
    double stride;
    TouchTool tool;
    std::vector<std::int32_t> nodes, held;
    std::vector<Vec3d> positions;
    std::vector<std::int32_t> kept_triangles;  ///< before a stride
};

/// Lets the tool hold its triangles' nodes where contact puts them.
Status SpringProbe::Impl::hold(SpringTissue& tissue) {
    touch.nodes_of(tool, nodes);
    if (nodes != held)
        if (const Status s = tissue.hold(nodes); !s.ok()) return s;
    held = nodes;
    positions.clear();
    for (const std::int32_t n : nodes) positions.push_back(touch.positions()[std::size_t(n)]);
    return tissue.move_held(positions);
}

/// Makes a stride, and time steps at its end.
Result<SpringStep> SpringProbe::Impl::step(SpringTissue& tissue, Vec3d way, std::int32_t steps,
                                           bool& is_stopped, const TaskArena& arena) {
    const Vec3d from = tool.position;
    kept_triangles = tool.triangles;
    touch.look(tissue);
    is_stopped = !touch.move(tool, way, tissue);
    if (const Status s = hold(tissue); !s.ok()) return s.error();
    auto stepped = tissue.step(steps, arena);
    if (!stepped.ok()) {
        touch.take_back();
        (void)hold(tissue);
        tool.position = from;
        tool.triangles = kept_triangles;
        (void)hold(tissue);
        return stepped;
    }
    touch.look_again(tissue);
    touch.keep_clear(tool);
    if (const Status s = hold(tissue); !s.ok()) return s.error();
    return stepped;
}

SpringProbe::SpringProbe(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
SpringProbe::SpringProbe(SpringProbe&&) noexcept = default;
SpringProbe& SpringProbe::operator=(SpringProbe&&) noexcept = default;
SpringProbe::~SpringProbe() = default;

Result<SpringProbe> SpringProbe::create(const SpringNetwork& network,
                                        std::vector<std::array<std::int32_t, 3>> triangles,
                                        const SpringProbeSettings& settings) noexcept {
    return attempt([&]() -> Result<SpringProbe> {
        if (!(settings.radius >= 0 && std::isfinite(settings.radius)))
            return expected_error("radius", "0 or more", text_of(settings.radius));
        if (!(settings.stride >= 0 && std::isfinite(settings.stride)))
            return expected_error("stride", "0 or more", text_of(settings.stride));
        if (triangles.empty()) return expected_error("triangles", "1 or more", "0");
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const auto [a, b, c] = triangles[t];
            for (const std::int32_t n : triangles[t])
                if (n < 0 || n >= network.node_count())
                    return expected_error("triangles",
                                          "nodes below " + std::to_string(network.node_count()),
                                          std::to_string(n) + " in triangle " + std::to_string(t));
            if (a == b || b == c || c == a)
                return expected_error("triangles", "three different nodes",
                                      "a node twice in triangle " + std::to_string(t));
        }
        return SpringProbe(std::make_unique<Impl>(network, std::move(triangles), settings));
    });
}

Status SpringProbe::place(SpringTissue& tissue, Vec3d position) noexcept {
    return attempt([&]() -> Status {
        if (!is_finite(position)) return invalid("place: expected a position of three numbers");
        Impl& p = *m_impl;
        p.touch.look(tissue);
        if (mesh::surface_winding(p.touch.triangles(), p.touch.positions(), position) > 0.5)
            return invalid("place: expected a position outside of the surface, found " +
                           text_of(position) + " inside");
        p.tool.triangles.clear();
        p.tool.position = position;
        p.held.clear();
        return tissue.hold({});
    });
}

Result<SpringProbeMove> SpringProbe::move(SpringTissue& tissue, Vec3d to, std::int32_t steps,
                                          const TaskArena& arena) noexcept {
    return attempt([&]() -> Result<SpringProbeMove> {
        constexpr std::int32_t kMaxStrides = 1'000'000;
        Impl& p = *m_impl;
        const Vec3d from = p.tool.position, way = to - from;
        const double strides = std::ceil(norm(way) / p.stride);
        if (steps < 1) return expected_error("steps", "1 or more", std::to_string(steps));
        if (!(strides <= kMaxStrides))
            return expected_error("move", "a way of up to a million strides", text_of(norm(way)));
        const std::int32_t count = std::max(1, std::int32_t(strides));
        SpringProbeMove moved;
        bool is_stopped = false;
        for (std::int32_t n = 0; n < count; ++n) {
            const auto until = [&](std::int32_t k) { return std::int64_t(steps) * k / count; };
            const auto own_steps = std::max<std::int64_t>(1, until(n + 1) - until(n));
            const Vec3d end = n + 1 == count ? to : from + (double(n + 1) / count) * way;
            // A stopped tool stays for the rest of the time.
            const Vec3d stride = is_stopped ? Vec3d{0, 0, 0} : end - p.tool.position;
            bool stops = false;
            const auto stepped = p.step(tissue, stride, std::int32_t(own_steps), stops, arena);
            if (!stepped.ok()) return stepped.error();
            moved.steps += stepped->steps;
            moved.active_nodes = stepped->active_nodes;
            if (stops && !is_stopped) moved.way_share = double(n) / count;
            is_stopped |= stops;
        }
        moved.position = p.tool.position;
        return moved;
    });
}

Vec3d SpringProbe::position() const {
    return m_impl->tool.position;
}
std::span<const std::int32_t> SpringProbe::triangles() const {
    return m_impl->tool.triangles;
}
std::span<const std::int32_t> SpringProbe::nodes() const {
    return m_impl->held;
}

double SpringProbe::clearance(const SpringTissue& tissue, double within) const {
    m_impl->touch.look(tissue);
    return m_impl->touch.clearance(m_impl->tool, within);
}

}  // namespace pliant
