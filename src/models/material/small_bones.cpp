// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "material/small_bones.h"

#include <algorithm>
#include <bit>

namespace pliant {
namespace {

constexpr int kBlock = 8;

/// Floods one piece after another. A flood ends as soon as its piece is known to stay: the rest of
/// it is then flooded from other seeds, which meet this part and end at once. So each element is
/// visited once.
class Pieces {
  public:
    Pieces(const Grid& grid, double smallest_mm3)
        : bone(voxel_count(grid)),
          small(voxel_count(grid)),
          m_grid(grid),
          m_strides{1, grid.size.x, std::ptrdiff_t(grid.size.x) * grid.size.y},
          m_voxel_mm3(grid.spacing_mm.x * grid.spacing_mm.y * grid.spacing_mm.z),
          m_smallest_mm3(smallest_mm3) {}

    /// @returns whether any piece is small
    bool find(VoxelBits rest, const std::vector<std::size_t>& kept) {
        m_rest = std::move(rest);
        for (const std::size_t n : kept) m_rest.clear(n);  // bone that isn't small: it stays
        bool any = false;
        for (std::size_t w = 0; w < m_rest.words().size(); ++w)
            while (const std::uint64_t word = m_rest.words()[w])
                any |= flood(64 * w + std::size_t(std::countr_zero(word)));
        return any;
    }

    VoxelBits bone, small;

  private:
    /// @returns whether the piece is small
    bool flood(std::size_t seed) {
        m_piece.assign(1, seed);
        m_rest.clear(seed);
        small.set(seed);  // so that the piece is told from those that stay
        bool stays = false;
        for (std::size_t n = 0; n < m_piece.size() && !stays; ++n) stays = visit(m_piece[n]);
        stays |= double(m_piece.size()) * m_voxel_mm3 >= m_smallest_mm3;
        if (stays)
            for (const std::size_t n : m_piece) small.clear(n);
        return !stays;
    }

    /// @returns whether the piece stays
    bool visit(std::size_t n) {
        const auto row = std::size_t(m_grid.size.x), slice = row * std::size_t(m_grid.size.y);
        const Vec3i p{int(n % row), int(n % slice / row), int(n / slice)};
        if (double(m_piece.size()) * m_voxel_mm3 >= m_smallest_mm3) return true;
        for (int a = 0; a < 3; ++a)
            if (p[a] == 0 || p[a] + 1 == m_grid.size[a]) return true;
        for (const std::ptrdiff_t stride : m_strides)
            for (const std::size_t next : {n - std::size_t(stride), n + std::size_t(stride)}) {
                if (!bone[next] || small[next]) continue;
                if (!m_rest[next]) return true;
                m_rest.clear(next);
                small.set(next);
                m_piece.push_back(next);
            }
        return false;
    }

    const Grid& m_grid;
    std::ptrdiff_t m_strides[3];
    double m_voxel_mm3, m_smallest_mm3;
    VoxelBits m_rest;
    std::vector<std::size_t> m_piece;
};

}  // namespace

SmallBones::SmallBones(const Grid& grid, double smallest_mm3,
                       const std::function<bool(int y, int z, BoneElement* row)>& look) {
    Pieces pieces(grid, smallest_mm3);
    std::vector<BoneElement> row(std::size_t(grid.size.x));
    std::vector<std::size_t> kept;
    bool any = false;
    for (int z = 0; z < grid.size.z; ++z)
        for (int y = 0; y < grid.size.y; ++y) {
            if (!look(y, z, row.data())) continue;
            any = true;
            const std::size_t start = voxel_index(grid, {0, y, z});
            for (std::size_t x = 0; x < row.size(); ++x) {
                if (row[x] == BoneElement::None) continue;
                pieces.bone.set(start + x);
                if (row[x] == BoneElement::ByLabel) kept.push_back(start + x);
            }
        }
    if (!any || !pieces.find(pieces.bone, kept)) return;
    m_bits = std::move(pieces.small);
    for (int a = 0; a < 3; ++a) m_size[a] = (grid.size[a] + kBlock - 1) / kBlock;
    m_blocks.resize(block({0, 0, m_size.z}), 0);
    const auto width = std::size_t(grid.size.x), slice = width * std::size_t(grid.size.y);
    for (std::size_t w = 0; w < m_bits.words().size(); ++w)
        for (std::uint64_t word = m_bits.words()[w]; word != 0; word &= word - 1) {
            const std::size_t n = 64 * w + std::size_t(std::countr_zero(word));
            m_blocks[block({int(n % width) / kBlock, int(n % slice / width) / kBlock,
                            int(n / slice) / kBlock})] = 1;
        }
}

bool SmallBones::may_be_in(const Box3i& box) const {
    const auto first = [&](int a) { return box.begin[a] / kBlock; };
    const auto last = [&](int a) { return (box.end[a] - 1) / kBlock; };
    for (int z = first(2); z <= last(2); ++z)
        for (int y = first(1); y <= last(1); ++y)
            for (int x = first(0); x <= last(0); ++x)
                if (m_blocks[block({x, y, z})]) return true;
    return false;
}

}  // namespace pliant
