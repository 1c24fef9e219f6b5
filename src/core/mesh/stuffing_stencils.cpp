// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The table is computed once from the rules: 81 patterns of signs, each with four parities. A cut
// tetrahedron is a smaller tetrahedron, a pyramid or a prism:
//
//      a0──b0      columns a–b; a quadrilateral's diagonal goes from a of one column to b of
//      | \  | \    another. Unless the three form a cycle they order the columns,
//      |  a2┼──b2  and with columns in that order the three tetrahedra are
//      | /  | /    a0 a1 a2 b2,  a0 a1 b1 b2,  a0 b0 b1 b2.
//      a1──b1

#include "mesh/stuffing_stencils.h"

#include <pliant/core/vec.h>

#include <utility>

namespace pliant::mesh {
namespace {

/// A positive lattice tetrahedron: centres at (0,0,0) and (2,0,0), then an edge of the face between
/// them.
constexpr Vec3i kReference[4] = {{0, 0, 0}, {2, 0, 0}, {1, -1, -1}, {1, 1, -1}};

constexpr bool is_long(int a, int b) {
    return (a < 2) == (b < 2);
}
StencilCorner corner(int a) {
    return {std::int8_t(a), std::int8_t(a)};
}
StencilCorner cut(int a, int b) {
    return {std::int8_t(a), std::int8_t(b)};
}

/// Orders the corners positively, evaluated with all cuts at midpoints.
StencilTet positive(StencilTet t) {
    Vec3i p[4];
    for (std::size_t n = 0; n < 4; ++n) p[n] = kReference[t[n].first] + kReference[t[n].second];
    if (dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0])) < 0) std::swap(t[0], t[1]);
    return t;
}

class Maker {
  public:
    Maker(const std::array<std::int8_t, 4>& signs, bool even_01, bool even_23)
        : m_signs(signs), m_even{even_01, !even_01, even_23, !even_23} {
        for (int n = 0; n < 4; ++n)
            (signs[std::size_t(n)] > 0   ? m_in
             : signs[std::size_t(n)] < 0 ? m_out
                                         : m_on)
                .push_back(n);
    }

    Stencil make() const {
        Stencil s;
        const auto add = [&](const StencilTet& t) { s.tetrahedra.push_back(positive(t)); };
        if (m_in.empty()) return s;
        if (m_out.empty()) {
            add({corner(0), corner(1), corner(2), corner(3)});
        } else if (m_in.size() == 1) {
            StencilTet t;
            for (std::size_t n = 0; n < 4; ++n)
                t[n] = m_signs[n] < 0 ? cut(m_in[0], int(n)) : corner(int(n));
            add(t);
        } else if (m_in.size() == 2 && m_out.size() == 1) {
            const int n = m_out[0], z = m_on[0];
            const bool at_first = starts_at_first(m_in[0], m_in[1], n);
            const int p = at_first ? m_in[0] : m_in[1], q = at_first ? m_in[1] : m_in[0];
            add({corner(p), corner(q), corner(z), cut(q, n)});
            add({corner(p), cut(q, n), corner(z), cut(p, n)});
        } else if (m_in.size() == 2) {
            const int p = m_in[0], q = m_in[1], m = m_out[0], n = m_out[1];
            const StencilCorner a[3] = {corner(p), cut(p, m), cut(p, n)};
            const StencilCorner b[3] = {corner(q), cut(q, m), cut(q, n)};
            // column 0 before column 1, and column 0 before column 2
            const bool first = starts_at_first(p, q, m), second = starts_at_first(p, q, n);
            if (first != second) {
                s.tetrahedra = first ? prism(a, b, 2, 0, 1) : prism(a, b, 1, 0, 2);
            } else {
                s.tetrahedra = first ? prism(a, b, 0, 1, 2) : prism(a, b, 1, 2, 0);
                s.other = first ? prism(a, b, 0, 2, 1) : prism(a, b, 2, 1, 0);
                s.diagonal[0] = a[1];
                s.diagonal[1] = b[2];
                s.other_diagonal[0] = a[2];
                s.other_diagonal[1] = b[1];
            }
        } else {
            const int n = m_out[0];
            StencilCorner a[3], b[3];
            bool before[3][3] = {};
            for (std::size_t c = 0; c < 3; ++c) {
                a[c] = corner(m_in[c]);
                b[c] = cut(m_in[c], n);
                for (std::size_t d = 0; d < c; ++d) {
                    before[d][c] = starts_at_first(m_in[d], m_in[c], n);
                    before[c][d] = !before[d][c];
                }
            }
            int rank[3];  // of each column in the order; without a cycle all differ
            for (int c = 0; c < 3; ++c) rank[before[0][c] + before[1][c] + before[2][c]] = c;
            s.tetrahedra = prism(a, b, rank[0], rank[1], rank[2]);
        }
        return s;
    }

  private:
    /// Whether the diagonal of the face p, q | n starts at p and ends at q's cut.
    bool starts_at_first(int p, int q, int n) const {
        if (is_long(p, q)) return m_even[p];
        return !is_long(p, n);
    }
    static std::vector<StencilTet> prism(const StencilCorner a[3], const StencilCorner b[3], int x,
                                         int y, int z) {
        return {positive({a[x], a[y], a[z], b[z]}), positive({a[x], a[y], b[y], b[z]}),
                positive({a[x], b[x], b[y], b[z]})};
    }

    std::array<std::int8_t, 4> m_signs;
    bool m_even[4];
    std::vector<int> m_in, m_on, m_out;
};

std::vector<Stencil> make_table() {
    std::vector<Stencil> table;
    for (int pattern = 0; pattern < 81; ++pattern)
        for (int parity = 0; parity < 4; ++parity) {
            std::array<std::int8_t, 4> signs{};
            for (int n = 0, rest = pattern; n < 4; ++n, rest /= 3)
                signs[std::size_t(n)] = std::int8_t(rest % 3 - 1);
            table.push_back(Maker(signs, parity % 2 != 0, parity / 2 != 0).make());
        }
    return table;
}

}  // namespace

const Stencil& stencil_of(const std::array<std::int8_t, 4>& signs, bool even_01, bool even_23) {
    static const std::vector<Stencil> table = make_table();
    int pattern = 0;
    for (int n = 3; n >= 0; --n) pattern = 3 * pattern + signs[std::size_t(n)] + 1;
    return table[std::size_t(4 * pattern + even_01 + 2 * even_23)];
}

}  // namespace pliant::mesh
