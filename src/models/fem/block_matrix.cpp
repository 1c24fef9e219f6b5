// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/block_matrix.h"

#include <algorithm>

#include "fem/hex_element.h"

namespace pliant {
namespace {

constexpr std::int64_t kRowGrain = 256;
/// Cells (9 MB) whose stiffnesses are computed in parallel, then added in order.
constexpr std::int64_t kCellBatch = 2048;

}  // namespace

void BlockMatrix::find_columns(const HexMesh& mesh) {
    const std::size_t nodes = mesh.nodes_mm.size();
    std::vector<std::int64_t> first_cell(nodes + 1, 0);
    for (const auto& cell : mesh.cells)
        for (const std::int32_t n : cell) ++first_cell[std::size_t(n) + 1];
    for (std::size_t n = 0; n < nodes; ++n) first_cell[n + 1] += first_cell[n];
    std::vector<std::int32_t> cells(mesh.cells.size() * 8);
    std::vector<std::int64_t> next(first_cell.begin(), first_cell.end() - 1);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c)
        for (const std::int32_t n : mesh.cells[c])
            cells[std::size_t(next[std::size_t(n)]++)] = std::int32_t(c);

    m_first.assign(nodes + 1, 0);
    std::vector<std::int32_t> around;
    for (std::size_t n = 0; n < nodes; ++n) {
        around.clear();
        for (auto c = first_cell[n]; c < first_cell[n + 1]; ++c) {
            const auto& cell = mesh.cells[std::size_t(cells[std::size_t(c)])];
            around.insert(around.end(), cell.begin(), cell.end());
        }
        std::sort(around.begin(), around.end());
        around.erase(std::unique(around.begin(), around.end()), around.end());
        m_columns.insert(m_columns.end(), around.begin(), around.end());
        m_first[n + 1] = std::int64_t(m_columns.size());
    }
}

BlockMatrix::BlockMatrix(const ElasticSolid& solid, HexElement element, const TaskArena& arena) {
    const HexMesh& mesh = solid.mesh;
    find_columns(mesh);
    m_blocks.assign(m_columns.size(), Block3{});
    const auto cell_count = std::int64_t(mesh.cells.size());
    std::vector<HexStiffness> batch(std::size_t(std::min(kCellBatch, cell_count)));
    for (std::int64_t begin = 0; begin < cell_count; begin += kCellBatch) {
        const std::int64_t count = std::min(kCellBatch, cell_count - begin);
        arena.for_each(count, 16, [&](std::int64_t from, std::int64_t to) {
            for (std::int64_t n = from; n < to; ++n) {
                const auto cell = std::size_t(begin + n);
                const auto material =
                    solid.material_of.empty() ? 0 : std::size_t(solid.material_of[cell]);
                HexCorners corners;
                for (std::size_t c = 0; c < 8; ++c)
                    corners[c] = mesh.nodes_mm[std::size_t(mesh.cells[cell][c])];
                batch[std::size_t(n)] = with_law(solid.materials[material], [&](const auto& law) {
                    return hex_stiffness(corners, law, element);
                });
            }
        });
        for (std::int64_t n = 0; n < count; ++n) {
            const auto& nodes = mesh.cells[std::size_t(begin + n)];
            const HexStiffness& k = batch[std::size_t(n)];
            for (std::size_t a = 0; a < 8; ++a) {
                const auto row = columns(nodes[a]);
                const auto first = m_first[std::size_t(nodes[a])];
                for (std::size_t b = 0; b < 8; ++b) {
                    const auto at = std::lower_bound(row.begin(), row.end(), nodes[b]);
                    Block3& block = m_blocks[std::size_t(first + (at - row.begin()))];
                    for (std::size_t i = 0; i < 3; ++i)
                        for (std::size_t j = 0; j < 3; ++j)
                            block[3 * i + j] += k[(3 * a + i) * 24 + 3 * b + j];
                }
            }
        }
    }
}

void BlockMatrix::multiply(const NodeVector& u, NodeVector& f, const TaskArena& arena) const {
    arena.for_each(row_count(), kRowGrain, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t row = begin; row < end; ++row) {
            const auto nodes = columns(std::int32_t(row));
            const auto k = blocks(std::int32_t(row));
            Vec3d sum{0, 0, 0};
            for (std::size_t n = 0; n < nodes.size(); ++n) {
                const Vec3d v = u.at(std::size_t(nodes[n]));
                const Block3& b = k[n];
                sum.x += b[0] * v.x + b[1] * v.y + b[2] * v.z;
                sum.y += b[3] * v.x + b[4] * v.y + b[5] * v.z;
                sum.z += b[6] * v.x + b[7] * v.y + b[8] * v.z;
            }
            f.set(std::size_t(row), sum);
        }
    });
}

Block3 BlockMatrix::diagonal_block(std::int32_t node) const {
    const auto nodes = columns(node);
    return blocks(
        node)[std::size_t(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin())];
}

std::int64_t BlockMatrix::bytes() const {
    return std::int64_t(m_first.size() * sizeof m_first[0] +
                        m_columns.size() * (sizeof m_columns[0] + sizeof m_blocks[0]));
}

}  // namespace pliant
