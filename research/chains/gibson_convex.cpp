// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Gibson's lists for one material and a full box, optimised for speed: the reference time for
// Pliant's own solvers on such lattices.
//
// Six plain arrays of element numbers, created once; positions in floats; each element is examined
// once and compared with its sponsor alone [Gibson1997, 3.3.2], so no marks are needed. The lists
// for ±i go first and those for ±k last, so that the long lists run along rows in memory.

#include <array>
#include <cmath>
#include <cstring>

#include "chains/published_ordering.h"
#include "material/limit_units.h"

namespace pliant {
namespace {

/// Four floats, one vector register. A vector type of GCC and Clang; both generate plain code for
/// processors without such registers.
using Lanes = float __attribute__((vector_size(16)));

/// Bits in which two registers differ; all zero if they are equal.
bool differ(Lanes a, Lanes b) {
    const auto changed = a != b;
    std::uint64_t halves[2];
    std::memcpy(halves, &changed, sizeof halves);
    return (halves[0] | halves[1]) != 0;
}

/// Bit d: there is a neighbour in direction d (+i, −i, +j, −j, +k, −k).
using SideBits = std::uint8_t;

class GibsonConvex final : public OrderingSolver {
  public:
    explicit GibsonConvex(const ChainLattice& lattice);

    OrderingReport push(std::span<const std::int32_t> elements, Vec3d push_mm) override;
    Vec3d displacement_mm(std::int32_t element) const override;
    void set_displacement_mm(std::int32_t element, Vec3d displacement_mm) override;
    void reset() override { m_position = m_rest; }

  private:
    struct Previous {
        float position[3];
        std::int32_t element;
    };
    struct Region {
        Lanes low, high;  ///< of the candidate's position relative to its sponsor's
    };

    template <int Direction>
    void run_list();
    void put(std::int32_t sponsor, int direction) {
        if (m_sides[std::size_t(sponsor)] >> direction & 1)
            m_list[std::size_t(direction)][m_count[std::size_t(direction)]++] =
                sponsor + m_step[std::size_t(direction)];
    }

    std::array<std::int32_t, 6> m_step;
    std::array<Region, 6> m_region;
    std::vector<Lanes> m_rest, m_position;  ///< [element]
    std::vector<SideBits> m_sides;          ///< [element]
    std::array<std::vector<std::int32_t>, 6> m_list;
    std::array<std::size_t, 6> m_count{};
    std::vector<Previous> m_previous;
    std::size_t m_previous_count = 0;
};

GibsonConvex::GibsonConvex(const ChainLattice& lattice) {
    const Vec3i size = lattice.size;
    const Vec3d h = lattice.spacing_mm;
    const ElementLimits& limits =
        lattice.materials[lattice.material.empty() ? 0 : lattice.material[0]];
    const std::size_t count = voxel_count({.size = size});
    m_step = {1, -1, size.x, -size.x, size.x * size.y, -size.x * size.y};
    for (int d = 0; d < 6; ++d) {
        const int b = d / 2;
        Region& region = m_region[std::size_t(d)];
        for (int a = 0; a < 3; ++a) {
            const double nearest = a == b ? h[b] * (1 - limits.compress[b]) : 0;
            const double farthest = a == b ? h[b] * (1 + limits.stretch[b]) : 0;
            const double shear = a == b ? 0 : h[b] * limits.shear[b];
            const bool up = d % 2 == 0;
            region.low[a] = float((up ? nearest : -farthest) - shear);
            region.high[a] = float((up ? farthest : -nearest) + shear);
        }
        region.low[3] = region.high[3] = 0;
        m_list[std::size_t(d)].resize(count + 1);
    }
    m_previous.resize(count + 1);
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i) {
                m_rest.push_back(Lanes{float(h.x * i), float(h.y * j), float(h.z * k), 0});
                m_sides.push_back(SideBits((i + 1 < size.x) | (i > 0) << 1 | (j + 1 < size.y) << 2 |
                                           (j > 0) << 3 | (k + 1 < size.z) << 4 | (k > 0) << 5));
            }
    m_position = m_rest;
}

template <int Direction>
void GibsonConvex::run_list() {
    const std::int32_t step = m_step[Direction];
    const Region region = m_region[Direction];
    std::int32_t* const list = m_list[Direction].data();
    std::size_t count = m_count[Direction];
    Lanes* const position = m_position.data();
    const SideBits* const sides = m_sides.data();
    Previous* previous = m_previous.data() + m_previous_count;
    // Additions to this list are processed in the same pass.
    for (std::size_t n = 0; n < count; ++n) {
        const std::int32_t e = list[n];
        const Lanes old = position[e], sponsor = position[e - step];
        const Lanes low = sponsor + region.low, high = sponsor + region.high;
        const Lanes raised = old < low ? low : old;
        const Lanes now = raised > high ? high : raised;
        if (!differ(now, old)) continue;
        *previous++ = {{old[0], old[1], old[2]}, e};
        position[e] = now;
        list[count] = e + step;  // memory has one spare element
        count += sides[e] >> Direction & 1;
        for (int d = Direction / 2 * 2 + 2; d < 6; ++d) put(e, d);
    }
    m_count[Direction] = count;
    m_previous_count = std::size_t(previous - m_previous.data());
}

OrderingReport GibsonConvex::push(std::span<const std::int32_t> elements, Vec3d push_mm) {
    OrderingReport report;
    if (elements.size() != 1 || elements[0] < 0 || std::size_t(elements[0]) >= m_position.size() ||
        !is_finite(push_mm) || norm(push_mm) > kMaxMovementMm)
        return report;
    m_count = {};
    const std::int32_t e = elements[0];
    Lanes& position = m_position[std::size_t(e)];
    m_previous[0] = {{position[0], position[1], position[2]}, e};
    m_previous_count = 1;
    for (int a = 0; a < 3; ++a) position[a] += float(push_mm[a]);
    for (int d = 0; d < 6; ++d) put(e, d);
    run_list<0>();
    run_list<1>();
    run_list<2>();
    run_list<3>();
    run_list<4>();
    run_list<5>();
    report.status = PushStatus::Applied;
    report.step_fraction = 1;
    report.moved_elements = std::int64_t(m_previous_count);
    for (const std::size_t count : m_count) report.candidates += std::int64_t(count);
    return report;
}

Vec3d GibsonConvex::displacement_mm(std::int32_t element) const {
    const Lanes p = m_position[std::size_t(element)], rest = m_rest[std::size_t(element)];
    return {double(p[0]) - rest[0], double(p[1]) - rest[1], double(p[2]) - rest[2]};
}

void GibsonConvex::set_displacement_mm(std::int32_t element, Vec3d displacement_mm) {
    const Lanes rest = m_rest[std::size_t(element)];
    for (int a = 0; a < 3; ++a)
        m_position[std::size_t(element)][a] = float(rest[a] + displacement_mm[a]);
}

}  // namespace

std::unique_ptr<OrderingSolver> make_gibson_convex(const ChainLattice& lattice) {
    return std::make_unique<GibsonConvex>(lattice);
}

}  // namespace pliant
