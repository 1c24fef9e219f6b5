// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "morph/mask_depth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "volume/boxes.h"
#include "volume/line_transform.h"

namespace pliant::morph {
namespace {

/// A mask is split where its second piece has this share of the first.
constexpr double kSecondShare = 0.25;
/// The pieces have this share of the mask, or they are no halves but remains.
constexpr double kPiecesShare = 0.1;
constexpr int kMaxErosionMm = 30;

Box3i box_of(const Mask& mask) {
    Box3i box{mask.grid.size, {0, 0, 0}};
    std::size_t n = 0;
    for (int k = 0; k < mask.grid.size.z; ++k)
        for (int j = 0; j < mask.grid.size.y; ++j)
            for (int i = 0; i < mask.grid.size.x; ++i)
                if (mask.in[n++]) {
                    const Vec3i p{i, j, k};
                    for (int a = 0; a < 3; ++a) {
                        box.begin[a] = std::min(box.begin[a], p[a]);
                        box.end[a] = std::max(box.end[a], p[a] + 1);
                    }
                }
    return box;
}

Box3i grown(Box3i box, Vec3i by, Vec3i size) {
    for (int a = 0; a < 3; ++a) {
        box.begin[a] = std::max(0, box.begin[a] - by[a]);
        box.end[a] = std::min(size[a], box.end[a] + by[a]);
    }
    return box;
}

Grid grid_of(const Grid& grid, const Box3i& box) {
    Grid part = grid;
    part.size = box.end - box.begin;
    part.origin_mm =
        world_from_voxel(grid, {double(box.begin.x), double(box.begin.y), double(box.begin.z)});
    return part;
}

Mask cropped(const Mask& mask, const Box3i& box) {
    Mask part{grid_of(mask.grid, box), {}};
    for_each_row(box, [&](Vec3i p) {
        const auto first = mask.in.begin() + std::ptrdiff_t(voxel_index(mask.grid, p));
        part.in.insert(part.in.end(), first, first + (box.end.x - p.x));
    });
    return part;
}

/// Neighbours across the six faces. Calls visit(index).
template <class Visit>
void for_neighbours(Vec3i size, std::size_t n, const Visit& visit) {
    const auto x = std::size_t(size.x), slice = x * std::size_t(size.y);
    const std::size_t i = n % x, j = n / x % std::size_t(size.y), k = n / slice;
    if (i > 0) visit(n - 1);
    if (i + 1 < x) visit(n + 1);
    if (j > 0) visit(n - x);
    if (j + 1 < std::size_t(size.y)) visit(n + x);
    if (k > 0) visit(n - slice);
    if (k + 1 < std::size_t(size.z)) visit(n + slice);
}

/// Pieces of the voxels that are deeper than a level: their voxels, the largest piece first.
std::vector<std::vector<std::size_t>> pieces_below(const std::vector<float>& depth, float level,
                                                   Vec3i size) {
    std::vector<std::vector<std::size_t>> pieces;
    std::vector<std::uint8_t> is_seen(depth.size(), 0);
    for (std::size_t n = 0; n < depth.size(); ++n) {
        if (is_seen[n] || !(depth[n] > level)) continue;
        std::vector<std::size_t> piece{n};
        is_seen[n] = 1;
        for (std::size_t next = 0; next < piece.size(); ++next)
            for_neighbours(size, piece[next], [&](std::size_t m) {
                if (is_seen[m] || !(depth[m] > level)) return;
                is_seen[m] = 1;
                piece.push_back(m);
            });
        pieces.push_back(std::move(piece));
    }
    std::stable_sort(pieces.begin(), pieces.end(),
                     [](const auto& a, const auto& b) { return a.size() > b.size(); });
    return pieces;
}

}  // namespace

std::vector<float> depth_mm(const Mask& mask) {
    const Vec3i size = mask.grid.size;
    std::vector<float> depth(mask.in.size());
    for (std::size_t n = 0; n < depth.size(); ++n)
        depth[n] = mask.in[n] ? std::numeric_limits<float>::infinity() : 0;
    LineTransform transform(std::max({size.x, size.y, size.z}));
    const std::array<std::size_t, 3> strides{1, std::size_t(size.x),
                                             std::size_t(size.x) * std::size_t(size.y)};
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        for (int q = 0; q < size[c]; ++q)
            for (int p = 0; p < size[b]; ++p)
                transform.run(depth.data() + std::size_t(p) * strides[std::size_t(b)] +
                                  std::size_t(q) * strides[std::size_t(c)],
                              strides[std::size_t(a)], size[a], mask.grid.spacing_mm[a]);
    }
    for (float& d : depth) d = std::sqrt(d);
    return depth;
}

std::vector<Mask> split(const Mask& whole) {
    const Box3i around = box_of(whole);
    if (is_empty(around)) return {whole};
    const Mask mask = cropped(whole, grown(around, {1, 1, 1}, whole.grid.size));
    const Vec3i size = mask.grid.size;
    const std::vector<float> depth = depth_mm(mask);
    std::vector<std::vector<std::size_t>> pieces;
    int level = 0;
    for (;; ++level) {
        if (level == kMaxErosionMm) return {mask};
        pieces = pieces_below(depth, float(level), size);
        if (pieces.empty()) return {mask};
        if (pieces.size() > 1 && double(pieces[1].size()) > kSecondShare * double(pieces[0].size()))
            break;
    }
    const auto count = std::size_t(std::count(mask.in.begin(), mask.in.end(), std::uint8_t(1)));
    if (double(pieces[0].size() + pieces[1].size()) < kPiecesShare * double(count)) return {mask};
    const auto middle = [&](const std::vector<std::size_t>& piece) {
        double sum = 0;
        for (const std::size_t n : piece) {
            const auto x = std::size_t(size.x), slice = x * std::size_t(size.y);
            sum += world_from_voxel(mask.grid, {double(n % x), double(n / x % std::size_t(size.y)),
                                                double(n / slice)})
                       .x;
        }
        return sum / double(piece.size());
    };
    if (middle(pieces[0]) > middle(pieces[1])) std::swap(pieces[0], pieces[1]);
    // The pieces grow shell by shell, both at the same pace.
    std::vector<std::uint8_t> owner(mask.in.size(), 0);
    std::vector<std::size_t> edge;
    for (std::uint8_t p = 0; p < 2; ++p)
        for (const std::size_t n : pieces[p]) {
            owner[n] = std::uint8_t(p + 1);
            edge.push_back(n);
        }
    for (int shell = level - 1; shell >= -1; --shell) {
        std::vector<std::size_t> front = edge, kept;
        while (!front.empty()) {
            std::vector<std::size_t> next;
            for (const std::size_t n : front) {
                bool has_more = false;
                for_neighbours(size, n, [&](std::size_t m) {
                    if (owner[m] || !mask.in[m]) return;
                    if (!(depth[m] > float(shell))) {
                        has_more = true;
                        return;
                    }
                    owner[m] = owner[n];
                    next.push_back(m);
                });
                if (has_more) kept.push_back(n);
            }
            front = std::move(next);
        }
        edge = std::move(kept);
    }
    std::vector<Mask> halves(2, Mask{mask.grid, {}});
    for (std::uint8_t p = 0; p < 2; ++p)
        for (const std::uint8_t of : owner) halves[p].in.push_back(of == p + 1);
    return halves;
}

SmoothMask::SmoothMask(const Mask& mask, double deviation_mm) {
    const Box3i around = box_of(mask);
    Vec3d deviation{0, 0, 0};
    Vec3i reach{0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        deviation[a] = deviation_mm / mask.grid.spacing_mm[a];
        reach[a] = int(4 * deviation[a] + 0.5);
    }
    const Box3i box = is_empty(around) ? Box3i{{0, 0, 0}, {1, 1, 1}}
                                       : grown(around, reach + Vec3i{2, 2, 2}, mask.grid.size);
    m_grid = grid_of(mask.grid, box);
    const Mask part = cropped(mask, box);
    m_values.assign(part.in.begin(), part.in.end());
    const std::array<std::size_t, 3> strides{
        1, std::size_t(m_grid.size.x), std::size_t(m_grid.size.x) * std::size_t(m_grid.size.y)};
    for (int a = 0; a < 3; ++a) {
        std::vector<float> weights;
        float sum = 0;
        for (int n = -reach[a]; n <= reach[a]; ++n) {
            const double t = n / deviation[a];
            weights.push_back(float(std::exp(-0.5 * t * t)));
            sum += weights.back();
        }
        for (float& w : weights) w /= sum;
        const int count = m_grid.size[a], b = (a + 1) % 3, c = (a + 2) % 3;
        const std::size_t stride = strides[std::size_t(a)];
        std::vector<float> line(std::size_t(count + 2 * reach[a]));
        for (int q = 0; q < m_grid.size[c]; ++q)
            for (int p = 0; p < m_grid.size[b]; ++p) {
                float* const first = m_values.data() + std::size_t(p) * strides[std::size_t(b)] +
                                     std::size_t(q) * strides[std::size_t(c)];
                for (int n = 0; n < int(line.size()); ++n)
                    line[std::size_t(n)] =
                        first[std::size_t(std::clamp(n - reach[a], 0, count - 1)) * stride];
                for (int n = 0; n < count; ++n) {
                    float value = 0;
                    for (std::size_t w = 0; w < weights.size(); ++w)
                        value += weights[w] * line[std::size_t(n) + w];
                    first[std::size_t(n) * stride] = value;
                }
            }
    }
}

Vec3d SmoothMask::slope(Vec3i p) const {
    Vec3d slope{0, 0, 0};
    for (int a = 0; a < 3; ++a) {
        Vec3i low = p, high = p;
        low[a] = std::max(0, p[a] - 1);
        high[a] = std::min(m_grid.size[a] - 1, p[a] + 1);
        if (low[a] != high[a])
            slope[a] = double(at(high) - at(low)) / (m_grid.spacing_mm[a] * (high[a] - low[a]));
    }
    return slope;
}

}  // namespace pliant::morph
