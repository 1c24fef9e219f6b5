// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/held_nodes.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/errors.h"

namespace pliant {
namespace {

/// A piece has six rigid motions. Each held component forbids one linear combination of them. If
/// all six are forbidden, the Gram matrix of the combinations has full rank.
struct RigidMotions {
    double gram[6][6] = {};

    void forbid(int axis, Vec3d arm) {
        Vec3d along{0, 0, 0};
        along[axis] = 1;
        const Vec3d turn = cross(arm, along);
        const double row[6] = {along.x, along.y, along.z, turn.x, turn.y, turn.z};
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j) gram[i][j] += row[i] * row[j];
    }
    /// Rank by pivoted Cholesky. Arms are scaled to about 1.
    int rank() {
        constexpr double kLeast = 1e-12;  // relative: directions that differ by 1e-6
        double scale = 0;
        for (int i = 0; i < 6; ++i) scale = std::max(scale, gram[i][i]);
        bool used[6] = {};
        for (int rank = 0; rank < 6; ++rank) {
            int pivot = -1;
            for (int i = 0; i < 6; ++i)
                if (!used[i] && (pivot < 0 || gram[i][i] > gram[pivot][pivot])) pivot = i;
            if (!(gram[pivot][pivot] > kLeast * scale)) return rank;
            used[pivot] = true;
            double row[6];
            for (int j = 0; j < 6; ++j) row[j] = gram[pivot][j];
            for (int i = 0; i < 6; ++i)
                for (int j = 0; j < 6; ++j) gram[i][j] -= row[i] * row[j] / row[pivot];
        }
        return 6;
    }
};

struct Piece {
    std::int32_t first_node = -1;
    std::int64_t nodes = 0;
    Vec3d sum{0, 0, 0};
    double reach = 0;  ///< largest distance of held nodes from the middle
    RigidMotions motions;
    Vec3d middle() const { return (1.0 / double(nodes)) * sum; }
};

Status check_rigid_motions(const SolidShape& shape, const HeldNodes& held) {
    const auto piece_of = shape.piece_of_nodes();
    const auto piece_number = [&](std::size_t n) {
        return piece_of.empty() ? 0 : std::size_t(piece_of[n]);
    };
    std::vector<Piece> found(
        piece_of.empty() ? 1
                         : std::size_t(*std::max_element(piece_of.begin(), piece_of.end()) + 1));
    for (std::size_t n = 0; n < held.axes.size(); ++n) {
        Piece& piece = found[piece_number(n)];
        if (piece.nodes++ == 0) piece.first_node = std::int32_t(n);
        piece.sum = piece.sum + shape.position(std::int32_t(n));
    }
    for (std::size_t n = 0; n < held.axes.size(); ++n) {
        Piece& piece = found[piece_number(n)];
        piece.reach = std::max(piece.reach, norm(shape.position(std::int32_t(n)) - piece.middle()));
    }
    for (std::size_t n = 0; n < held.axes.size(); ++n)
        for (int a = 0; a < 3; ++a)
            if (held.holds(n, a)) {
                Piece& piece = found[piece_number(n)];
                piece.motions.forbid(
                    a, (1 / piece.reach) * (shape.position(std::int32_t(n)) - piece.middle()));
            }
    for (Piece& piece : found)
        if (const int rank = piece.motions.rank(); rank < 6)
            return invalid("supports: leave " +
                           (found.size() == 1
                                ? std::string("the solid")
                                : "the piece of node " + std::to_string(piece.first_node)) +
                           " free to move or turn (" + std::to_string(rank) +
                           " of 6 rigid motions are held), expected all 6");
    return Ok{};
}

}  // namespace

void HeldNodes::clear(NodeVector& v) const {
    for (const std::int32_t n : nodes)
        for (int a = 0; a < 3; ++a)
            if (holds(std::size_t(n), a)) v.component(a)[n] = 0;
}

Result<HeldNodes> hold(const SolidShape& shape, std::span<const Support> supports) {
    const std::int64_t nodes = shape.node_count();
    HeldNodes held{std::vector<std::uint8_t>(std::size_t(nodes), 0), NodeVector(nodes)};
    for (std::size_t s = 0; s < supports.size(); ++s) {
        const Support& support = supports[s];
        const std::string name = "supports[" + std::to_string(s) + "]";
        if (support.node < 0 || support.node >= nodes)
            return invalid(name + ": node " + std::to_string(support.node) + ", expected 0…" +
                           std::to_string(nodes - 1));
        const auto node = std::size_t(support.node);
        for (int a = 0; a < 3; ++a) {
            if (!support.held[std::size_t(a)]) continue;
            const double u = support.displacement_mm[a];
            double& position = held.displacement_mm.component(a)[node];
            if (!std::isfinite(u))
                return invalid(name + ": displacement_mm." + "xyz"[a] + " is not finite");
            if (held.holds(node, a) && u != position)
                return invalid(name + ": brings node " + std::to_string(node) + " to " +
                               std::to_string(u) + " mm along " + "xyz"[a] +
                               ", where another support brings it to " + std::to_string(position));
            position = u;
            held.axes[node] = std::uint8_t(held.axes[node] | 1 << a);
        }
    }
    if (const Status s = check_rigid_motions(shape, held); !s) return s.error();
    for (std::size_t n = 0; n < held.axes.size(); ++n)
        if (held.axes[n]) held.nodes.push_back(std::int32_t(n));
    return held;
}

}  // namespace pliant
