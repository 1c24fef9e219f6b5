// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "propagate/sweep_lags.h"

#include <algorithm>

namespace pliant {
namespace {

constexpr int kElementArrays = 24, kFirstLinks = 9, kFirstExcess = 18;
constexpr int kFaceArrays = 38, kFirstBound = 18, kFaceExcess = 36, kFaceWork = 37;

AlignedMemory<Fixed> allocate(std::size_t count) {
    auto memory = allocate_aligned<Fixed>(count * sizeof(Fixed), 64);
    // Kernels may read lags of missing links; these must be initialised.
    std::fill_n(memory.get(), count, 0);
    return memory;
}

/// Calls visit(index in the face, element on the side).
template <class Visit>
void for_each_on_face(int size, int side, const Visit& visit) {
    const int axis = side / 2;
    const int stride = axis == 0 ? 1 : axis == 1 ? size : size * size;
    const int step_p = axis == 0 ? size : 1, step_q = axis == 2 ? size : size * size;
    const int first = side % 2 ? (size - 1) * stride : 0;
    for (int q = 0; q < size; ++q)
        for (int p = 0; p < size; ++p) visit(p + size * q, first + p * step_p + q * step_q);
}

}  // namespace

void VisitLags::begin(const Lattice& lattice, const Brick& brick, const SweepKernels& kernels,
                      bool shared, bool stretch_is_shear) {
    m_lattice = &lattice;
    m_brick = &brick;
    m_kernels = &kernels;
    m_shared = shared;
    m_stretch_is_shear = stretch_is_shear;
    m_has_halves = m_has_links = m_has_face = m_has_bound = 0;
    if (m_size != lattice.brick_size()) resize(lattice.brick_size());
}

void VisitLags::resize(int size) {
    m_size = 0;  // until both are allocated
    m_face = (size * size + 15) / 16 * 16;
    m_count = (size * size * size + 15) / 16 * 16;
    m_elements = allocate(std::size_t(kElementArrays) * std::size_t(m_count));
    m_faces = allocate(std::size_t(kFaceArrays) * std::size_t(m_face));
    m_equal_lags.fill(0);
    m_size = size;
}

VisitLags::Kind VisitLags::kind_of(bool up, int axis, const ComponentPush& push,
                                   bool symmetric) const {
    if (m_shared || symmetric || axis != push.axis) return kShear;
    if (up == (push.sign > 0)) return kCompress;
    return m_stretch_is_shear ? kShear : kStretch;
}

const Fixed* VisitLags::column(Kind kind, int axis) const {
    const MaterialTable::Columns& columns = m_lattice->materials().columns();
    const auto& of_kind = kind == kShear      ? columns.shear
                          : kind == kCompress ? columns.compress
                                              : columns.stretch;
    return of_kind[std::size_t(axis)].data();
}

const Brick& VisitLags::neighbour(int side) const {
    return m_lattice->brick(m_brick->neighbours[std::size_t(side)]);
}

bool VisitLags::is_uniform() const {
    return !(m_brick->traits & kMixedMaterials) && !m_brick->edits &&
           !m_lattice->may_exceed_limits();
}

UniformLags VisitLags::uniform(const ComponentPush& push) const {
    UniformLags lags;
    for (int b = 0; b < 3; ++b) {
        const MaterialId id = m_brick->material[0];
        lags.forward[std::size_t(b)] = 2 * column(kind_of(true, b, push, false), b)[id];
        lags.backward[std::size_t(b)] = 2 * column(kind_of(false, b, push, false), b)[id];
    }
    return lags;
}

const Fixed* VisitLags::halves(Kind kind, int axis) {
    const int n = 3 * kind + (m_brick->traits & kAnisotropic ? axis : 0);
    Fixed* out = elements(n);
    if (!(m_has_halves >> n & 1)) {
        m_has_halves |= std::uint32_t(1) << n;
        m_kernels->gather(column(kind, axis), m_brick->material, m_size * m_size * m_size, out);
    }
    return out;
}

const Fixed* VisitLags::links(Kind kind, int axis) {
    const int n = 3 * kind + axis;
    Fixed* out = elements(kFirstLinks + n);
    if (m_has_links >> n & 1) return out;
    m_has_links |= std::uint32_t(1) << n;
    m_kernels->add_halves(halves(kind, axis), m_size, axis, out);
    if (m_brick->edits)
        for (int i = 0; i + m_lattice->stride(axis) < m_lattice->elements_per_brick(); ++i)
            if (m_brick->edits[i] & (kCutX << axis)) out[i] = kUnlinked;
    if (axis == 0 && !m_lattice->may_exceed_limits()) m_kernels->arrange_x(out, m_size);
    return out;
}

const Fixed* VisitLags::with_excess_inside(const Fixed* lags, int axis, bool up,
                                           const ComponentPush& push) {
    Fixed* out = elements(kFirstExcess + 2 * axis + up);
    const Fixed* u = m_brick->u[std::size_t(push.axis)];
    const Fixed sign = up ? push.sign : -push.sign;
    const int stride = m_lattice->stride(axis);
    for (int i = 0; i + stride < m_lattice->elements_per_brick(); ++i)
        out[i] = std::max(lags[i], sign * (u[i] - u[i + stride]));
    if (axis == 0) m_kernels->arrange_x(out, m_size);
    return out;
}

InsideLags VisitLags::inside(const ComponentPush& push) {
    const bool symmetric = !(m_brick->traits & kAsymmetric);
    InsideLags lags;
    for (int b = 0; b < 3; ++b)
        for (const bool up : {false, true}) {
            const Fixed* table = links(kind_of(up, b, push, symmetric), b);
            if (m_lattice->may_exceed_limits()) table = with_excess_inside(table, b, up, push);
            (up ? lags.forward : lags.backward)[std::size_t(b)] = table;
        }
    return lags;
}

void VisitLags::add_own_halves(Kind kind, int side, Fixed* out) {
    if (!(m_brick->traits & kMixedMaterials)) {
        std::fill_n(out, m_face, column(kind, side / 2)[m_brick->material[0]]);
        return;
    }
    m_kernels->copy_face(halves(kind, side / 2), m_size, side, out);
}

void VisitLags::add_their_halves(Kind kind, int side, Fixed* out) {
    const Brick& there = neighbour(side);
    const Fixed* halves_there = column(kind, side / 2);
    if (!(there.traits & kMixedMaterials)) {
        const Fixed half = halves_there[there.material[0]];
        for (int n = 0; n < m_face; ++n) out[n] += half;
        return;
    }
    m_kernels->add_face(halves_there, there.material, m_size, side ^ 1, out);
}

void VisitLags::cut_links_of_face(int side, bool with_neighbour, Fixed* out) const {
    // The flag of a cut is stored with the link's lower element.
    const bool up = side % 2;
    if (!up && !with_neighbour) return;
    const std::uint8_t* edits = up ? m_brick->edits : neighbour(side).edits;
    if (!edits) return;
    for_each_on_face(m_size, up ? side : side ^ 1, [&](int n, int element) {
        if (edits[element] & (kCutX << side / 2)) out[n] = kUnlinked;
    });
}

Fixed VisitLags::equal_lag(Kind kind, int side, bool with_neighbour) const {
    if ((m_brick->traits & kMixedMaterials) || m_brick->edits) return -1;
    const Fixed* of = column(kind, side / 2);
    if (!with_neighbour) return of[m_brick->material[0]];
    const Brick& there = neighbour(side);
    if ((there.traits & kMixedMaterials) || there.edits) return -1;
    // Elements beyond the border, to which these lags could lead, are never evaluated.
    return of[m_brick->material[0]] + of[there.material[0]];
}

const Fixed* VisitLags::face(Kind kind, int side, bool with_neighbour) {
    const int n = 6 * kind + side;
    std::uint32_t& has = with_neighbour ? m_has_face : m_has_bound;
    Fixed* out = faces(with_neighbour ? n : kFirstBound + n);
    if (has >> n & 1) return out;
    has |= std::uint32_t(1) << n;
    Fixed& filled_with = m_equal_lags[std::size_t(with_neighbour ? n : kFirstBound + n)];
    const Fixed all = equal_lag(kind, side, with_neighbour);
    if (all >= 0) {
        if (filled_with != all) std::fill_n(out, m_face, all);
        filled_with = all;
        return out;
    }
    filled_with = -1;
    add_own_halves(kind, side, out);
    if (with_neighbour) add_their_halves(kind, side, out);
    cut_links_of_face(side, with_neighbour, out);
    return out;
}

const Fixed* VisitLags::with_excess(const Fixed* lags, int side, bool behind_face,
                                    const ComponentPush& push) {
    Fixed* out = faces(kFaceExcess);
    Fixed* theirs = faces(kFaceWork);
    const auto axis = std::size_t(push.axis);
    const Fixed* own_u = m_brick->u[axis];
    const Fixed* their_u = neighbour(side).u[axis];
    const bool at_rest = is_at_rest(neighbour(side));
    for_each_on_face(m_size, side ^ 1,
                     [&](int n, int element) { theirs[n] = at_rest ? 0 : their_u[element]; });
    const Fixed sign = behind_face ? push.sign : -push.sign;
    for_each_on_face(m_size, side, [&](int n, int element) {
        out[n] = std::max(lags[n], sign * (own_u[element] - theirs[n]));
    });
    return out;
}

const Fixed* VisitLags::behind_face(int side, const ComponentPush& push) {
    const bool symmetric = !((m_brick->traits | neighbour(side).traits) & kAsymmetric);
    const Fixed* lags = face(kind_of(side % 2, side / 2, push, symmetric), side, true);
    return m_lattice->may_exceed_limits() ? with_excess(lags, side, true, push) : lags;
}

const Fixed* VisitLags::behind_neighbour(int side, const ComponentPush& push) {
    const bool symmetric = !((m_brick->traits | neighbour(side).traits) & kAsymmetric);
    const Fixed* lags = face(kind_of(!(side % 2), side / 2, push, symmetric), side, true);
    return m_lattice->may_exceed_limits() ? with_excess(lags, side, false, push) : lags;
}

const Fixed* VisitLags::behind_face_at_least(int side, const ComponentPush& push) {
    const bool symmetric = !(m_brick->traits & kAsymmetric);
    return face(kind_of(side % 2, side / 2, push, symmetric), side, false);
}

}  // namespace pliant
