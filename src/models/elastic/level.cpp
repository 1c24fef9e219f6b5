// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "elastic/level.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace pliant {
namespace {

constexpr std::size_t kVectors = 7, kArrays = 3 * kVectors + 6 + 4 + 1;
constexpr float kFollows = -0.0F;
// Determinants of the deformation gradient at which walls touch: across air, and in a cut.
constexpr float kTouch = 0.1F, kPressed = 0.9F;
constexpr float kLetsGo = 0.05F;  ///< they part above that

/// Inverse of a symmetric positive matrix: xx, xy, xz, yy, yz, zz; zeros if it is singular.
std::array<float, 6> inverse_of(const std::array<float, 6>& m) {
    const float a = m[0], b = m[1], c = m[2], d = m[3], e = m[4], f = m[5];
    const float xx = d * f - e * e, xy = c * e - b * f, xz = b * e - c * d;
    const float determinant = a * xx + b * xy + c * xz;
    if (!(determinant > 0)) return {};
    const float s = 1 / determinant;
    return {s * xx, s * xy, s * xz, s * (a * f - c * c), s * (b * c - a * e), s * (a * d - b * b)};
}

/// Inverse of P M P on the plane across a direction, P its projection.
std::array<float, 6> inverse_across(const std::array<float, 6>& inverse, Vec3d n) {
    // M⁻¹ − (M⁻¹ n)(M⁻¹ n)ᵀ / (n·M⁻¹ n)
    const Vec3d v{inverse[0] * n.x + inverse[1] * n.y + inverse[2] * n.z,
                  inverse[1] * n.x + inverse[3] * n.y + inverse[4] * n.z,
                  inverse[2] * n.x + inverse[4] * n.y + inverse[5] * n.z};
    const double s = dot(n, v);
    if (!(s > 0)) return {};
    std::array<float, 6> across = inverse;
    for (int a = 0, at = 0; a < 3; ++a)
        for (int b = a; b < 3; ++b) across[std::size_t(at++)] -= float(v[a] * v[b] / s);
    return across;
}

/// A squared Frobenius norm of G up to which det(I + G) is above a limit: it is at least (1 − g)³
/// for g < 1, since no singular value of I + G is below 1 − g.
float unfolded_below(float limit) {
    const float most = std::max(0.999F - std::cbrt(limit), 0.0F);  // with room for rounding
    return most * most;
}

}  // namespace

ElasticLevel::ElasticLevel(const StiffnessMap& map, int n, Vec3i begin, Vec3i size,
                           const TaskArena& arena)
    : number(n), shift(map.shift(n)), first(begin), nodes(size) {
    stride = (nodes.x + kSweepLanes) / kSweepLanes * kSweepLanes;
    plane = std::size_t(stride) * std::size_t(nodes.y);
    const Vec3i cells = map.cells(n);
    for (int a = 0; a < 3; ++a) {
        follows[a][0] = first[a] > 0;
        follows[a][1] = first[a] + nodes[a] <= cells[a];
    }
    factors = cell_factors(map.spacing_mm(n));
    m_corners = corner_blocks(factors);
    spectrum = float(cell_spectrum(factors, double(map.lambda_per_mu())));
    // Products read a row and a plane beyond the last node.
    const std::size_t room = array_size() + plane + std::size_t(stride) + 2 * kSweepLanes;
    m_memory.assign(kArrays * room, 0);
    float* next = m_memory.data();
    const auto take = [&] { return std::exchange(next, next + room); };
    for (NodeRows* const rows : {&u, &r, &p, &q, &e, &s, &t})
        for (float*& row : *rows) row = take();
    for (float*& row : block) row = take();
    for (float*& row : rotations.turns) row = take();
    mu = take();
    dots.assign(std::size_t(nodes.z), 0);
    kind.assign(array_size(), CellKind::Open);
    m_turned.assign(std::size_t(nodes.y) * std::size_t(nodes.z), 0);
    rotations.turned = m_turned.data();
    arena.for_each(nodes.z - 1, 4, [&](std::int64_t low, std::int64_t high) {
        read(map, {{0, 0, int(low)}, {nodes.x - 1, nodes.y - 1, int(high)}});
    });
    find_blocks(map, arena);
}

void ElasticLevel::read(const StiffnessMap& map, const Box3i& cells) {
    const Box3i box{cells.begin + first, cells.end + first};
    const auto width = std::size_t(stride), rows = std::size_t(nodes.y);
    const std::size_t at = index(cells.begin);
    map.moduli(number, box, width, rows, mu + at);
    map.kinds(number, box, width, rows, kind.data() + at);
}

void ElasticLevel::renew(const StiffnessMap& map, const Box3i& cells) {
    read(map, cells);
    for (int k = cells.begin.z; k <= cells.end.z; ++k)
        for (int j = cells.begin.y; j <= cells.end.y; ++j)
            find_row(map, j, k, cells.begin.x, cells.end.x + 1);
}

void ElasticLevel::stiffen(const StiffnessMap& map, Vec3i cell, float mu_pa) {
    mu[index(cell)] += mu_pa;
    stiffened.push_back(cell);
    for (int c = 0; c < 4; ++c)
        find_row(map, cell.y + (c & 1), cell.z + (c >> 1), cell.x, cell.x + 2);
}

void ElasticLevel::loosen(const StiffnessMap& map) {
    for (const Vec3i cell : stiffened) renew(map, {cell, cell + Vec3i{1, 1, 1}});
    stiffened.clear();
}

bool ElasticLevel::is_follower(Vec3i local) const {
    for (int a = 0; a < 3; ++a)
        if ((local[a] == 0 && follows[a][0]) || (local[a] == nodes[a] - 1 && follows[a][1]))
            return true;
    return false;
}

bool ElasticLevel::is_active(Vec3i local) const {
    for (int a = 0; a < 3; ++a)
        if (std::max(local[a] - 1, 0) < covered.begin[a] ||
            std::min(local[a], nodes[a] - 2) >= covered.end[a])
            return true;
    return false;
}

void ElasticLevel::find_row(const StiffnessMap& map, int j, int k, int begin, int end) {
    const float ratio = map.lambda_per_mu(), nothing = map.void_mu();
    for (int i = begin; i < end; ++i) {
        std::array<float, 6> sum{};
        // The node is corner c of the cell that begins at node − c.
        for (int c = 0; c < 8; ++c) {
            const Vec3i cell{i - (c & 1), j - (c >> 1 & 1), k - (c >> 2)};
            if (cell.x < 0 || cell.y < 0 || cell.z < 0) continue;
            const float shear = mu[index(cell)];
            const float lambda = ratio * std::max(shear - nothing, 0.0F);
            for (std::size_t n = 0; n < 6; ++n)
                sum[n] += shear * m_corners.mu[std::size_t(c)][n] +
                          lambda * m_corners.lambda[std::size_t(c)][n];
        }
        const std::array<float, 6> inverse = inverse_of(sum);
        const std::size_t at = index({i, j, k});
        for (std::size_t n = 0; n < 6; ++n) block[n][at] = inverse[n];
        const Vec3i local{i, j, k};
        const bool holds = map.is_held(number, local + first);
        if (!holds && !is_follower(local)) continue;
        for (std::size_t n = 0; n < 6; ++n) block[n][at] = 0;
        if (!holds) block[0][at] = kFollows;
    }
}

void ElasticLevel::find_blocks(const StiffnessMap& map, const TaskArena& arena) {
    arena.for_each(nodes.z, 2, [&](std::int64_t low, std::int64_t high) {
        for (int k = int(low); k < int(high); ++k)
            for (int j = 0; j < nodes.y; ++j) find_row(map, j, k, 0, nodes.x);
    });
}

LatticeSweep ElasticLevel::sweep(const StiffnessMap& map) const {
    LatticeSweep sweep;
    sweep.factors = &factors;
    sweep.nodes = nodes;
    sweep.stride = stride;
    sweep.mu = mu;
    sweep.lambda_per_mu = map.lambda_per_mu();
    sweep.void_mu = map.void_mu();
    const auto& turns = rotations.turns;
    sweep.turns = {turns[0], turns[1], turns[2], turns[3]};
    sweep.turned = rotations.turned;
    sweep.block = {block[0], block[1], block[2], block[3], block[4], block[5]};
    return sweep;
}

Box3i ElasticLevel::box_in(const ElasticLevel& coarse) const {
    Box3i box;
    for (int a = 0; a < 3; ++a) {
        const int step = coarse.shift[a] - shift[a];
        box.begin[a] = (first[a] >> step) - coarse.first[a];
        box.end[a] = ((first[a] + nodes[a] - 1) >> step) - coarse.first[a];
    }
    return box;
}

void ElasticLevel::hold(const StiffnessMap& map, const HeldNode& node) {
    const auto local = local_of(node.node);
    if (!local || is_follower(*local) || map.is_held(number, *local + first)) return;
    // Under a finer window a node that slides is free.
    if (node.only_along && !is_active(*local)) return;
    const std::size_t at = index(*local);
    held.push_back(*local);
    std::array<float, 6> inverse{};
    if (node.only_along) {
        for (std::size_t c = 0; c < 6; ++c) inverse[c] = block[c][at];
        inverse = inverse_across(inverse, *node.only_along);
    }
    for (std::size_t c = 0; c < 6; ++c) block[c][at] = inverse[c];
    if (!node.only_along) {
        for (int a = 0; a < 3; ++a) u[std::size_t(a)][at] = float(node.displacement_mm[a]);
        return;
    }
    const Vec3d n = *node.only_along;
    slides.push_back({at, n, node.force_un});
    const Vec3d now{u[0][at], u[1][at], u[2][at]};
    const Vec3d shifted = now + dot(n, node.displacement_mm - now) * n;
    for (int a = 0; a < 3; ++a) u[std::size_t(a)][at] = float(shifted[a]);
}

void ElasticLevel::let_go(const StiffnessMap& map) {
    for (const Vec3i local : held) find_row(map, local.y, local.z, local.x, local.x + 1);
    held.clear();
    slides.clear();
}

std::optional<Vec3i> ElasticLevel::local_of(Vec3i voxel) const {
    Vec3i local;
    for (int a = 0; a < 3; ++a) {
        if (voxel[a] & ((1 << shift[a]) - 1)) return {};
        local[a] = (voxel[a] >> shift[a]) - first[a];
    }
    if (!has(local)) return {};
    return local;
}

bool ElasticLevel::has_voxel(Vec3i voxel) const {
    for (int a = 0; a < 3; ++a) {
        const int low = first[a] << shift[a], high = (first[a] + nodes[a] - 1) << shift[a];
        if (voxel[a] < low || voxel[a] > high) return false;
    }
    return true;
}

void ElasticLevel::displacements(Vec3i voxel, int count, const NodeRows& to) const {
    const int low_x = first.x << shift.x, high_x = (first.x + nodes.x - 1) << shift.x;
    const int begin = std::max(voxel.x, low_x), end = std::min(voxel.x + count, high_x + 1);
    if (begin >= end || !has_voxel({begin, voxel.y, voxel.z})) return;
    Vec3i low;
    float part[3];
    for (int a = 1; a < 3; ++a) {
        low[a] = (voxel[a] >> shift[a]) - first[a];
        part[a] = float(voxel[a] & ((1 << shift[a]) - 1)) / float(1 << shift[a]);
    }
    const std::size_t up = part[1] > 0 ? std::size_t(stride) : 0;
    const std::size_t above = part[2] > 0 ? plane : 0;
    const float scale = 1.0F / float(1 << shift.x);
    for (std::size_t a = 0; a < 3; ++a) {
        const float* const row = u[a] + index({0, low.y, low.z});
        const auto mean = [&](int i) {
            const float* const c = row + i;
            const float lower = c[0] + part[1] * (c[up] - c[0]);
            const float upper = c[above] + part[1] * (c[up + above] - c[above]);
            return lower + part[2] * (upper - lower);
        };
        float* out = to[a] + (begin - voxel.x);
        if (shift.x == 0) {
            for (int x = begin; x < end; ++x) *out++ = mean(x - first.x);
            continue;
        }
        int cell = -1;
        float left = 0, right = 0;
        for (int x = begin; x < end; ++x) {
            const int i = std::min((x >> shift.x) - first.x, nodes.x - 2);
            if (i != cell) {
                left = mean(i);
                right = mean(i + 1);
                cell = i;
            }
            const float along = float(x - ((first.x + i) << shift.x)) * scale;
            *out++ = left + along * (right - left);
        }
    }
}

/// Smallest determinant at the corners of a cell for scale · u, or any number above the limit.
float ElasticLevel::least_corner(std::size_t at, float limit, float scale) const {
    float corner[8][3], edges[3][4][3], squared = 0;
    for (unsigned c = 0; c < 8; ++c)
        for (std::size_t a = 0; a < 3; ++a)
            corner[c][a] =
                u[a][at + (c & 1) + (c & 2 ? std::size_t(stride) : 0) + (c & 4 ? plane : 0)];
    for (unsigned b = 0; b < 3; ++b) {
        float longest = 0;
        for (unsigned c = 0, n = 0; c < 8; ++c) {
            if (c >> b & 1) continue;
            float square = 0;
            for (std::size_t a = 0; a < 3; ++a) {
                const float edge =
                    scale * 4 * factors.gradient[b] * (corner[c | 1U << b][a] - corner[c][a]);
                edges[b][n][a] = edge;
                square += edge * edge;
            }
            longest = std::max(longest, square);
            ++n;
        }
        squared += longest;
    }
    if (squared < unfolded_below(limit)) return 1;
    float least = std::numeric_limits<float>::max();
    for (unsigned c = 0; c < 8; ++c) {
        float g[3][3];
        for (unsigned b = 0; b < 3; ++b) {
            const unsigned low = c & ((1U << b) - 1), high = c >> (b + 1);
            for (std::size_t a = 0; a < 3; ++a)
                g[b][a] = edges[b][low | high << b][a] + (a == b ? 1.0F : 0.0F);
        }
        least = std::min(least, g[0][0] * (g[1][1] * g[2][2] - g[1][2] * g[2][1]) -
                                    g[0][1] * (g[1][0] * g[2][2] - g[1][2] * g[2][0]) +
                                    g[0][2] * (g[1][0] * g[2][1] - g[1][1] * g[2][0]));
    }
    return least;
}

/// Writes an upper bound of the squared Frobenius norm of displacement gradients at the corners of
/// each cell of a row.
void ElasticLevel::gradient_row(int j, int k, std::span<float> to) const {
    constexpr std::size_t kBlock = 64;
    const std::size_t count = to.size() - 1, begin = index({0, j, k}), width = std::size_t(stride);
    const float *const x = u[0], *const y = u[1], *const z = u[2];
    const auto square = [=](std::size_t node, std::size_t other) {
        const float of_x = x[other] - x[node], of_y = y[other] - y[node], of_z = z[other] - z[node];
        return of_x * of_x + of_y * of_y + of_z * of_z;
    };
    const auto squared = [](float factor) { return 16 * factor * factor; };
    const float of_x = squared(factors.gradient[0]), of_y = squared(factors.gradient[1]);
    const float of_z = squared(factors.gradient[2]);
    for (std::size_t first_cell = 0; first_cell < count; first_cell += kBlock) {
        const std::size_t cells = std::min(kBlock, count - first_cell), at = begin + first_cell;
        float along_x[kBlock], along_y[kBlock + 1], along_z[kBlock + 1];
        for (std::size_t i = 0; i < cells + 1; ++i) {
            const std::size_t a = at + i, b = a + width, c = a + plane, d = c + width;
            along_y[i] = of_y * std::max(square(a, b), square(c, d));
            along_z[i] = of_z * std::max(square(a, c), square(b, d));
        }
        for (std::size_t i = 0; i < cells; ++i) {
            const std::size_t a = at + i, b = a + width, c = a + plane, d = c + width;
            along_x[i] = of_x * std::max(std::max(square(a, a + 1), square(b, b + 1)),
                                         std::max(square(c, c + 1), square(d, d + 1)));
        }
        for (std::size_t i = 0; i < cells; ++i)
            to[first_cell + i] = along_x[i] + std::max(along_y[i], along_y[i + 1]) +
                                 std::max(along_z[i], along_z[i + 1]);
    }
}

// Walls that touch.

void ElasticLevel::find_touching(int k, std::vector<TouchingCell>& found) const {
    const auto is_before = [](Vec3i a, Vec3i b) {
        return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
    };
    auto last = std::lower_bound(
        touching.begin(), touching.end(), Vec3i{0, 0, k},
        [&](const TouchingCell& cell, Vec3i at) { return is_before(cell.cell, at); });
    const float unfolded[2][2] = {{unfolded_below(kTouch), unfolded_below(kTouch + kLetsGo)},
                                  {unfolded_below(kPressed), unfolded_below(kPressed + kLetsGo)}};
    std::vector<float> gradients(std::size_t(nodes.x));
    for (int j = 0; j + 1 < nodes.y; ++j) {
        gradient_row(j, k, gradients);
        for (int i = 0; i + 1 < nodes.x; ++i) {
            const Vec3i cell{i, j, k};
            const bool touched = last != touching.end() && last->cell == cell;
            const auto before = touched ? last++ : touching.end();
            const std::size_t at = index(cell);
            if (kind[at] == CellKind::Tissue || is_covered(cell)) continue;
            const bool is_slit = kind[at] == CellKind::Slit;
            if (gradients[std::size_t(i)] < unfolded[is_slit][touched]) continue;
            const float limit = is_slit ? kPressed : kTouch;
            const float parts = limit + kLetsGo;
            const float least = least_corner(at, touched ? parts : limit);
            if (touched) {
                if (least < parts) found.push_back(*before);
                continue;
            }
            if (least >= limit) continue;
            // The largest part of the displacement that doesn't touch.
            float open = 0, closed = 1;
            for (int step = 0; step < 12; ++step) {
                const float middle = (open + closed) / 2;
                (least_corner(at, limit, middle) < limit ? closed : open) = middle;
            }
            TouchingCell& touches = found.emplace_back(TouchingCell{.cell = cell});
            for (unsigned c = 0; c < 8; ++c)
                for (std::size_t a = 0; a < 3; ++a)
                    touches.u[8 * a + c] =
                        open * u[a][at + (c & 1) + (c & 2 ? std::size_t(stride) : 0) +
                                    (c & 4 ? plane : 0)];
        }
    }
}

/// The cells stand in a row, with nothing between them.
void ElasticLevel::add_touching(const StiffnessMap& map, const NodeRows& rows, float factor,
                                bool turns, bool to_held) const {
    if (touching.empty()) return;
    const int length = 2 * int(touching.size());
    LatticeSweep row;
    row.factors = &factors;
    row.nodes = {length, 2, 2};
    row.stride = (length + kSweepLanes) / kSweepLanes * kSweepLanes;
    row.lambda_per_mu = map.lambda_per_mu();
    row.turning = turns ? Turning::Positions : Turning::None;
    const std::size_t width = std::size_t(row.stride);
    const std::size_t room = 5 * width + 2 * kSweepLanes;
    AlignedVector<float> memory(11 * room + sweep_workspace(row.nodes, row.stride));
    float* next = memory.data();
    const auto take = [&] { return std::exchange(next, next + room); };
    float* const stiffness = take();
    std::array<float*, 4> turn{take(), take(), take(), take()};
    for (float*& x : row.x) x = take();
    for (float*& out : row.out) out = take();
    const std::uint8_t turned[4] = {turns, turns, turns, turns};
    row.turned = turned;
    std::fill_n(turn[0], room, 1.0F);
    const auto corner_at = [&](std::size_t n, unsigned c) {
        return 2 * n + (c & 1) + (c & 2 ? width : 0) + (c & 4 ? 2 * width : 0);
    };
    for (std::size_t n = 0; n < touching.size(); ++n) {
        const std::size_t at = index(touching[n].cell);
        stiffness[2 * n] = map.touching_mu();
        const bool is_turned = turns && rotations.turned[at / std::size_t(stride)];
        if (is_turned)
            for (std::size_t i = 0; i < 4; ++i) turn[i][2 * n] = rotations.turns[i][at];
        for (unsigned c = 0; c < 8; ++c)
            for (std::size_t a = 0; a < 3; ++a)
                row.x[a][corner_at(n, c)] = touching[n].u[8 * a + c];
    }
    row.mu = stiffness;
    row.turns = {turn[0], turn[1], turn[2], turn[3]};
    row.pass = SweepPass::Store;
    sweep_planes(row, 0, 2, next);
    for (std::size_t n = 0; n < touching.size(); ++n)
        for (unsigned c = 0; c < 8; ++c) {
            const std::size_t at =
                index(touching[n].cell + Vec3i{int(c & 1), int(c >> 1 & 1), int(c >> 2)});
            if (!to_held && is_held(at)) continue;
            for (std::size_t a = 0; a < 3; ++a) rows[a][at] += factor * row.out[a][corner_at(n, c)];
        }
}

bool ElasticLevel::has_folded(int k, float limit, std::vector<Vec3i>* cells) const {
    const Box3i& box = covered;
    bool found = false;
    const float unfolded = unfolded_below(limit);
    std::vector<float> gradients(std::size_t(nodes.x));
    for (int j = 0; j + 1 < nodes.y; ++j) {
        gradient_row(j, k, gradients);
        const bool partly = k >= box.begin.z && k < box.end.z && j >= box.begin.y && j < box.end.y;
        const std::size_t row = index({0, j, k});
        for (int i = 0; i + 1 < nodes.x; ++i) {
            const std::size_t at = row + std::size_t(i);
            if (kind[at] != CellKind::Tissue || (partly && i >= box.begin.x && i < box.end.x))
                continue;
            if (gradients[std::size_t(i)] < unfolded) continue;
            if (least_corner(at, limit) >= limit) continue;
            found = true;
            if (!cells) return true;
            cells->push_back({i, j, k});
        }
    }
    return found;
}

bool ElasticLevel::untangle(const StiffnessMap& map, float limit) {
    constexpr int kRounds = 60, kRoundsPerRing = 10;  // nodes around join after some rounds
    std::vector<Vec3i> cells, moving;
    std::vector<std::array<float, 3>> moved;
    int begin = 0, end = nodes.z - 1;
    for (int round = 0; round < kRounds; ++round) {
        cells.clear();
        for (int k = begin; k < end; ++k) (void)has_folded(k, limit, &cells);
        if (cells.empty()) return true;
        moving.clear();
        const int ring = round / kRoundsPerRing;
        for (const Vec3i cell : cells)
            for (int z = -ring; z < 2 + ring; ++z)
                for (int y = -ring; y < 2 + ring; ++y)
                    for (int x = -ring; x < 2 + ring; ++x) {
                        const Vec3i node = cell + Vec3i{x, y, z};
                        if (has(node) && !is_follower(node) && !map.is_held(number, node + first))
                            moving.push_back(node);
                    }
        const auto key = [](Vec3i n) { return std::tuple(n.z, n.y, n.x); };
        std::sort(moving.begin(), moving.end(), [&](Vec3i a, Vec3i b) { return key(a) < key(b); });
        moving.erase(std::unique(moving.begin(), moving.end()), moving.end());
        if (moving.empty()) return false;
        moved.clear();
        for (const Vec3i node : moving) {
            std::array<float, 3> sum{};
            int count = 0;
            for (int side = 0; side < 6; ++side) {
                Vec3i next = node;
                next[side / 2] += side % 2 ? 1 : -1;
                if (!has(next)) continue;
                ++count;
                for (std::size_t a = 0; a < 3; ++a) sum[a] += u[a][index(next)];
            }
            for (std::size_t a = 0; a < 3; ++a)
                sum[a] = 0.5F * (u[a][index(node)] + sum[a] / float(count));
            moved.push_back(sum);
        }
        for (std::size_t n = 0; n < moving.size(); ++n)
            for (std::size_t a = 0; a < 3; ++a) u[a][index(moving[n])] = moved[n][a];
        // Only cells around the moved nodes can change.
        begin = std::max(0, moving.front().z - 1);
        end = std::min(nodes.z - 1, moving.back().z + 1);
    }
    return false;
}

}  // namespace pliant
