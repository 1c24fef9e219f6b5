// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/models/springs.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"

namespace pliant {
namespace {

Result<DepthFound> search_depth(const SpringNetwork& network, const SpringSettings& settings,
                                std::span<const std::int32_t> nodes, std::span<const Vec3d> forces,
                                const DepthSearch& search, const TaskArena& arena) {
    const auto bad = [](const std::string& text) {
        return Error{ErrorCode::InvalidArgument, "find_depth: " + text};
    };
    if (!(search.threshold > 0)) return bad("expected a threshold above 0");
    if (search.max_depth < 1) return bad("expected a max_depth of 1 or more");
    if (!(std::isfinite(search.duration) && search.duration >= 0))
        return bad("expected a duration of 0 or more");
    if (settings.solver != SpringSolver::ForceTransmittal)
        return bad("expected the solver ForceTransmittal");
    auto tissue = SpringTissue::create(network, settings);
    if (!tissue.ok()) return tissue.error();
    if (const Status status = tissue->load(nodes, forces); !status.ok()) return status.error();
    const double steps = std::ceil(search.duration / tissue->time_step());
    if (steps > double(INT32_MAX)) return bad("expected a duration of fewer than 2147483647 steps");
    DepthFound found;
    std::vector<Vec3d> last;
    for (std::int32_t depth = 1; depth <= search.max_depth + 1; ++depth) {
        tissue->reset();
        if (const Status status = tissue->set_depth(depth); !status.ok()) return status.error();
        if (search.duration > 0) {
            const auto report = tissue->step(std::int32_t(steps), arena);
            if (!report.ok()) return report.error();
        } else if (const Status status = tissue->find_equilibrium(); !status.ok()) {
            return status.error();
        }
        std::vector<Vec3d> shape = tissue->displacements();
        if (!last.empty()) {
            double change = 0;
            for (std::size_t n = 0; n < shape.size(); ++n)
                change = std::max(change, norm(shape[n] - last[n]));
            found.changes.push_back(change);
            if (change < search.threshold) {
                found.depth = depth - 1;
                return found;
            }
        }
        last = std::move(shape);
    }
    return found;
}

}  // namespace

Result<DepthFound> find_depth(const SpringNetwork& network, const SpringSettings& settings,
                              std::span<const std::int32_t> nodes, std::span<const Vec3d> forces,
                              const DepthSearch& search, const TaskArena& arena) noexcept {
    return attempt([&] { return search_depth(network, settings, nodes, forces, search, arena); });
}

}  // namespace pliant
