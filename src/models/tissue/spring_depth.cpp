// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The necessary depth for tools that hold a scan's tissue. Unlike pliant::find_depth the positions
// of the touched nodes are given, not the forces on them.

#include <algorithm>

#include "base/errors.h"
#include "tissue/spring_tissue.h"

namespace pliant {
namespace {

/// Remaining force at an equilibrium, relative to the largest reaction.
constexpr double kTolerance = 1e-4;

}  // namespace

Result<DepthFound> SpringScanTissue::find_depth(double threshold_mm, std::int32_t max_depth) const {
    if (!(threshold_mm > 0))
        return about("depth", ErrorCode::InvalidArgument, "expected a threshold above 0 mm");
    if (m_held.empty())
        return about("depth", ErrorCode::NotFound, "expected a tool that holds tissue, found none");
    auto trial = SpringTissue::create(m_tissue.network(), {.time_step = m_tissue.time_step()});
    if (!trial.ok()) return trial.error();
    if (const Status s = trial->hold(m_held); !s.ok()) return s.error();
    std::vector<Vec3d> positions;
    for (const std::int32_t n : m_held) positions.push_back(m_tissue.position(n));
    if (const Status s = trial->move_held(positions); !s.ok()) return s.error();
    DepthFound found;
    std::vector<Vec3d> last;
    for (std::int32_t depth = 1; depth <= max_depth + 1; ++depth) {
        if (const Status s = trial->set_depth(depth); !s.ok()) return s.error();
        // The last shape is near the next one.
        if (const Status s = trial->find_equilibrium(kTolerance); !s.ok()) return s.error();
        std::vector<Vec3d> shape = trial->displacements();
        if (!last.empty()) {
            double change = 0;
            for (std::size_t n = 0; n < shape.size(); ++n)
                change = std::max(change, norm(shape[n] - last[n]));
            found.changes.push_back(change);
            if (change < threshold_mm) {
                found.depth = depth - 1;
                break;
            }
        }
        last = std::move(shape);
    }
    return found;
}

}  // namespace pliant
