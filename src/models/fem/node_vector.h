// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Vectors of nodes in the solvers: all x, then all y, then all z, so that neighbours along a
// lattice's row are adjacent in memory. Each component is padded by one vector register of zeros,
// which kernels may read but not write.

#pragma once

#include <pliant/core/vec.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

class NodeVector {
  public:
    static constexpr std::size_t kRoom = 8;

    explicit NodeVector(std::int64_t node_count)
        : m_count(std::size_t(node_count)), m_values(3 * (m_count + kRoom), 0.0) {}

    std::int64_t node_count() const { return std::int64_t(m_count); }
    double* component(int axis) { return m_values.data() + std::size_t(axis) * (m_count + kRoom); }
    const double* component(int axis) const {
        return m_values.data() + std::size_t(axis) * (m_count + kRoom);
    }
    Vec3d at(std::size_t node) const {
        return {component(0)[node], component(1)[node], component(2)[node]};
    }
    void clear() { std::fill(m_values.begin(), m_values.end(), 0.0); }
    void set(std::size_t node, Vec3d v) {
        for (int a = 0; a < 3; ++a) component(a)[node] = v[a];
    }

  private:
    std::size_t m_count;
    std::vector<double> m_values;
};

inline NodeVector node_vector(std::span<const Vec3d> values) {
    NodeVector result(std::int64_t(values.size()));
    for (std::size_t n = 0; n < values.size(); ++n) result.set(n, values[n]);
    return result;
}
inline std::vector<Vec3d> vectors_of(const NodeVector& values, double factor) {
    std::vector<Vec3d> result(std::size_t(values.node_count()));
    for (std::size_t n = 0; n < result.size(); ++n) result[n] = factor * values.at(n);
    return result;
}

}  // namespace pliant
