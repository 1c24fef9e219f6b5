// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Common parts of the published orderings: the positions, the list of previous positions for a
// rollback, and the retry with a shorter step [Gibson1997, 3.2] [Draeger2005, 3.5.5]. Neither
// specifies the shortening; here the step is halved.
//
// Positions are stored as displacements, in doubles. Limits and pushes are whole multiples of 2⁻²⁰
// mm, so sums are exact, and a difference from the exact solution is due to the ordering, not to
// rounding.

#pragma once

#include <pliant/research/orderings.h>

#include <vector>

namespace pliant {

inline constexpr int kMaxHalvings = 8;
inline constexpr std::int64_t kMaxTakingsPerElement = 1000;

/// The position closest to u within low…high of the sponsor's.
inline Vec3d clamped(Vec3d u, Vec3d sponsor, Vec3d low, Vec3d high) {
    for (int a = 0; a < 3; ++a) {
        if (u[a] < sponsor[a] + low[a])
            u[a] = sponsor[a] + low[a];
        else if (u[a] > sponsor[a] + high[a])
            u[a] = sponsor[a] + high[a];
    }
    return u;
}

/// The amount of constraint violation, Schill's sort key: the candidate's distance from its region,
/// in the component with the largest one; 0 or less inside.
inline double violation(Vec3d u, Vec3d sponsor, Vec3d low, Vec3d high) {
    double worst = -1;
    for (int a = 0; a < 3; ++a) {
        const double ahead = u[a] - sponsor[a];
        worst = std::max(worst, std::max(low[a] - ahead, ahead - high[a]));
    }
    return worst;
}

class PublishedOrdering : public OrderingSolver {
  public:
    OrderingReport push(std::span<const std::int32_t> elements, Vec3d push_mm) final;
    Vec3d displacement_mm(std::int32_t element) const final { return m_u[std::size_t(element)]; }
    void set_displacement_mm(std::int32_t element, Vec3d displacement_mm) final {
        m_u[std::size_t(element)] = displacement_mm;
    }
    void reset() final;

  protected:
    struct Bounds {
        float max_movement_mm;
        bool fixed;
    };

    explicit PublishedOrdering(std::vector<Bounds> bounds);

    /// Propagates the motion of the moved initial elements until the lists are empty.
    /// @returns false if a move was not permitted
    virtual bool propagate(std::span<const std::int32_t> initial) = 0;

    Vec3d u(std::int32_t element) const { return m_u[std::size_t(element)]; }
    bool is_moved(std::int32_t element) const { return m_moved[std::size_t(element)] != 0; }
    bool is_initial(std::int32_t element) const {
        return m_moved[std::size_t(element)] == kInitial;
    }
    /// @returns false if the position is not permitted; the element is there nevertheless, until a
    ///          rollback
    [[nodiscard]] bool move(std::int32_t element, Vec3d to);
    /// Counts a candidate. @returns false if there were too many
    [[nodiscard]] bool count_candidate();

  private:
    static constexpr std::uint8_t kInitial = 2;
    struct Previous {
        std::int32_t element;
        Vec3d u;
    };

    bool attempt(std::span<const std::int32_t> elements, Vec3d step_mm);
    void go_back();

    std::vector<Vec3d> m_u;             ///< [element]
    std::vector<std::uint8_t> m_moved;  ///< [element]: moved by this push: 0, 1 or kInitial
    std::vector<Bounds> m_bounds;       ///< [element]
    std::vector<Previous> m_previous;   ///< of the elements that this push moved
    std::int64_t m_candidates = 0, m_max_candidates = 0;
};

std::unique_ptr<OrderingSolver> make_gibson_convex(const ChainLattice& lattice);
std::unique_ptr<OrderingSolver> make_gibson_lists(const ChainLattice& lattice);
std::unique_ptr<OrderingSolver> make_draeger(const ChainLattice& lattice, bool mean_of_ends);
std::unique_ptr<OrderingSolver> make_schill(std::shared_ptr<const ChainGraph> graph, bool once);
std::unique_ptr<OrderingSolver> make_li(std::shared_ptr<const ChainGraph> graph, bool once);

}  // namespace pliant
