// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "fem/lattice_stiffness.h"

#include <algorithm>
#include <utility>

#include "fem/hex_element.h"

namespace pliant {
namespace {

/// Planes of nodes per task; a task computes one extra layer of cells.
constexpr int kPlanes = 8;

/// Corner n of a lattice cell (x + 2y + 4z) in VTK's order.
constexpr std::size_t kVtkCorner[8] = {0, 1, 3, 2, 4, 5, 7, 6};

}  // namespace

LatticeFactors lattice_factors(Vec3d h) {
    LatticeFactors factors{};
    for (int m = 0; m < 8; ++m)
        for (int a = 0; a < 3; ++a) {
            if (!(m >> a & 1)) continue;
            double product = 1 / h[a];
            for (int c = 0; c < 3; ++c)
                if (c != a) product *= h[c] / (m >> c & 1 ? 12 : 4);
            factors.along[a][m] = product;
            factors.mode[m] += product;
        }
    for (int c = 0; c < 3; ++c) {
        factors.across[c][0] = h[c] / 16;
        factors.across[c][1] = h[c] / 48;
    }
    return factors;
}

LatticeStiffness::LatticeStiffness(const ElasticLattice& solid)
    : m_lattice(solid.lattice),
      m_factors(lattice_factors(solid.lattice.spacing_mm)),
      m_uniform(solid.material_of.empty()) {
    const auto cells = std::size_t(m_uniform ? m_lattice.size.x - 1 : cell_count(m_lattice));
    m_lambda.assign(cells + NodeVector::kRoom, 0);
    m_mu.assign(cells + NodeVector::kRoom, 0);
    for (std::size_t c = 0; c < cells; ++c) {
        const auto material = m_uniform ? 0 : std::size_t(solid.material_of[c]);
        const LameParameters lame = lame_of(solid.materials[material]);
        m_lambda[c] = lame.lambda;
        m_mu[c] = lame.mu;
    }
    find_corner_blocks();
}

LatticeStiffness::LatticeStiffness(const HexLattice& lattice, std::vector<double> lambda,
                                   std::vector<double> mu)
    : m_lattice(lattice),
      m_factors(lattice_factors(lattice.spacing_mm)),
      m_uniform(false),
      m_lambda(std::move(lambda)),
      m_mu(std::move(mu)) {
    m_lambda.resize(m_lambda.size() + NodeVector::kRoom, 0);
    m_mu.resize(m_mu.size() + NodeVector::kRoom, 0);
    find_corner_blocks();
}

LatticeStiffness LatticeStiffness::slab(const HexLattice& part, int low) const {
    LatticeStiffness copy = *this;
    copy.m_lattice = part;
    if (m_uniform) return copy;
    const auto begin = std::ptrdiff_t(cell_index(m_lattice, {0, 0, low}));
    for (auto [values, from] : {std::pair(&copy.m_lambda, &m_lambda), {&copy.m_mu, &m_mu}}) {
        values->assign(from->begin() + begin, from->begin() + begin + cell_count(part));
        values->resize(values->size() + NodeVector::kRoom, 0);
    }
    return copy;
}

void LatticeStiffness::find_corner_blocks() {
    const Vec3d h = m_lattice.spacing_mm;
    HexCorners corners;
    for (std::size_t c = 0; c < 8; ++c)
        corners[c] = {h.x * (kHexSigns[c][0] > 0), h.y * (kHexSigns[c][1] > 0),
                      h.z * (kHexSigns[c][2] > 0)};
    const auto of_lambda = hex_stiffness(corners, LameParameters{1, 0}, HexElement::Trilinear);
    const auto of_mu = hex_stiffness(corners, LameParameters{0, 1}, HexElement::Trilinear);
    for (std::size_t n = 0; n < 8; ++n)
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) {
                const std::size_t at = (3 * kVtkCorner[n] + i) * 24 + 3 * kVtkCorner[n] + j;
                m_corner_lambda[n][3 * i + j] = of_lambda[at];
                m_corner_mu[n][3 * i + j] = of_mu[at];
            }
}

/// Adds the cells of layer k to the planes of nodes begin ≤ k < end.
void LatticeStiffness::add_layer(const NodeVector& u, NodeVector& f, int k, int begin, int end,
                                 double* workspace) const {
    const Vec3i n = m_lattice.size;
    LatticeRow row{};
    row.cells = n.x - 1;
    row.workspace = workspace;
    for (int j = 0; j + 1 < n.y; ++j) {
        const std::size_t cell = m_uniform ? 0 : std::size_t(cell_index(m_lattice, {0, j, k}));
        row.lambda = m_lambda.data() + cell;
        row.mu = m_mu.data() + cell;
        for (int r = 0; r < 4; ++r) {
            const Vec3i at{0, j + (r & 1), k + (r >> 1)};
            const auto node = std::size_t(node_index(m_lattice, at));
            for (int a = 0; a < 3; ++a) {
                row.displacement[a][r] = u.component(a) + node;
                row.force[a][r] = at.z >= begin && at.z < end ? f.component(a) + node : nullptr;
            }
        }
        add_lattice_row(m_factors, row);
    }
}

void LatticeStiffness::multiply(const NodeVector& u, NodeVector& f, const TaskArena& arena) const {
    const Vec3i n = m_lattice.size;
    const std::size_t plane = std::size_t(n.x) * std::size_t(n.y);
    arena.for_each(n.z, kPlanes, [&](std::int64_t begin, std::int64_t end) {
        for (int a = 0; a < 3; ++a)
            std::fill(f.component(a) + plane * std::size_t(begin),
                      f.component(a) + plane * std::size_t(end), 0.0);
        std::vector<double> workspace(lattice_row_workspace(n.x - 1));
        const int first = std::max(0, int(begin) - 1), last = std::min(n.z - 1, int(end));
        for (int k = first; k < last; ++k)
            add_layer(u, f, k, int(begin), int(end), workspace.data());
    });
}

Block3 LatticeStiffness::diagonal_block(std::int32_t node) const {
    const Vec3i n = m_lattice.size;
    const Vec3i at{node % n.x, node / n.x % n.y, node / n.x / n.y};
    Block3 block{};
    for (std::size_t corner = 0; corner < 8; ++corner) {
        const Vec3i cell = at - Vec3i{int(corner & 1), int(corner >> 1 & 1), int(corner >> 2)};
        if (cell.x < 0 || cell.y < 0 || cell.z < 0 || cell.x >= n.x - 1 || cell.y >= n.y - 1 ||
            cell.z >= n.z - 1)
            continue;
        const auto index = std::size_t(m_uniform ? cell.x : cell_index(m_lattice, cell));
        for (std::size_t i = 0; i < 9; ++i)
            block[i] +=
                m_lambda[index] * m_corner_lambda[corner][i] + m_mu[index] * m_corner_mu[corner][i];
    }
    return block;
}

std::int64_t LatticeStiffness::bytes() const {
    return std::int64_t((m_lambda.size() + m_mu.size()) * sizeof(double));
}

}  // namespace pliant
