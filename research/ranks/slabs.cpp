// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "ranks/slabs.h"

#include <algorithm>
#include <utility>

namespace pliant {
namespace {

/// Thinner slabs are mostly copies.
constexpr int kMinPlanes = 2;
/// Smaller slabs are not worth their messages; at least a piece of SlabSums.
constexpr std::size_t kMinNodes = 2048;

std::vector<int> even_split(int planes, int ranks) {
    std::vector<int> first;
    for (int r = 0; r <= ranks; ++r) first.push_back(int(std::int64_t(planes) * r / ranks));
    return first;
}

/// Appends planes begin ≤ k < end.
void pack(const NodeVector& v, std::size_t plane, int begin, int end, std::vector<double>& to) {
    for (int a = 0; a < 3; ++a)
        to.insert(to.end(), v.component(a) + plane * std::size_t(begin),
                  v.component(a) + plane * std::size_t(end));
}
void unpack(const double* from, std::size_t plane, int begin, int end, NodeVector& v) {
    const std::size_t count = plane * std::size_t(end - begin);
    for (int a = 0; a < 3; ++a)
        std::copy_n(from + std::size_t(a) * count, count,
                    v.component(a) + plane * std::size_t(begin));
}

}  // namespace

Slabs::Slabs(const HexLattice& whole, Ranks* ranks)
    : Slabs(whole, ranks, even_split(whole.size.z, ranks ? ranks->count() : 1)) {
    if (m_ranks && m_ranks->count() > 1 && are_thick()) return;
    m_ranks = nullptr;
    m_first = {0, whole.size.z};
}

Slabs::Slabs(const HexLattice& whole, Ranks* ranks, std::vector<int> first)
    : m_whole(whole), m_ranks(ranks), m_first(std::move(first)) {}

bool Slabs::are_thick() const {
    for (std::size_t r = 0; r + 1 < m_first.size(); ++r) {
        const int planes = m_first[r + 1] - m_first[r];
        if (planes < kMinPlanes || plane() * std::size_t(planes) < kMinNodes) return false;
    }
    return true;
}

Slabs Slabs::coarse(const HexLattice& coarse, Vec3i factor) const {
    std::vector<int> first;
    for (const int plane : m_first) first.push_back((plane + factor.z - 1) / factor.z);
    first.back() = coarse.size.z;  // it may extend beyond the fine lattice
    return Slabs(coarse, m_ranks, std::move(first));
}

int Slabs::low() const {
    return std::max(first() - 1, 0);
}

HexLattice Slabs::local() const {
    HexLattice part = m_whole;
    part.size.z = std::min(end() + 1, m_whole.size.z) - low();
    part.origin_mm.z += low() * m_whole.spacing_mm.z;
    return part;
}

std::vector<double> Slabs::local_cells(const std::vector<double>& whole) const {
    const auto layer = std::ptrdiff_t(m_whole.size.x - 1) * (m_whole.size.y - 1);
    const auto begin = whole.begin() + layer * low();
    return {begin, begin + cell_count(local())};
}

HeldNodes Slabs::local_held(const HeldNodes& whole) const {
    const std::size_t begin = plane() * std::size_t(low()),
                      count = std::size_t(node_count(local()));
    HeldNodes held{{}, local_nodes(whole.displacement_mm), {}};
    held.axes.assign(whole.axes.begin() + std::ptrdiff_t(begin),
                     whole.axes.begin() + std::ptrdiff_t(begin + count));
    for (std::size_t n = 0; n < count; ++n)
        if (held.axes[n]) held.nodes.push_back(std::int32_t(n));
    return held;
}

NodeVector Slabs::local_nodes(const NodeVector& whole) const {
    NodeVector part(node_count(local()));
    for (int a = 0; a < 3; ++a)
        std::copy_n(whole.component(a) + plane() * std::size_t(low()), part.node_count(),
                    part.component(a));
    return part;
}

void Slabs::exchange(NodeVector& v) const {
    if (is_whole()) return;
    const int own = first() - low(), own_end = end() - low(), planes = local().size.z;
    auto& [to_below, to_above, from_below, from_above] = m_buffers;
    to_below.clear();
    to_above.clear();
    if (own > 0) pack(v, plane(), own, own + 1, to_below);
    if (own_end < planes) pack(v, plane(), own_end - 1, own_end, to_above);
    from_below.resize(to_below.size());
    from_above.resize(to_above.size());
    m_ranks->exchange(to_below, to_above, from_below, from_above);
    if (own > 0) unpack(from_below.data(), plane(), own - 1, own, v);
    if (own_end < planes) unpack(from_above.data(), plane(), own_end, own_end + 1, v);
}

NodeVector Slabs::gather(const NodeVector& local) const {
    if (is_whole()) return local;
    std::vector<double> mine, all(3 * std::size_t(node_count(m_whole)));
    pack(local, plane(), first() - low(), end() - low(), mine);
    std::vector<std::size_t> counts;
    for (std::size_t r = 0; r + 1 < m_first.size(); ++r)
        counts.push_back(3 * plane() * std::size_t(m_first[r + 1] - m_first[r]));
    m_ranks->gather(mine, counts, all);
    NodeVector whole(node_count(m_whole));
    const double* from = all.data();
    for (std::size_t r = 0; r < counts.size(); from += counts[r], ++r)
        unpack(from, plane(), m_first[r], m_first[r + 1], whole);
    return whole;
}

}  // namespace pliant
