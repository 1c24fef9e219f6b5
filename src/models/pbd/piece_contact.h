// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact of the pieces of a body. A touch is a node of one piece and the nearest triangle of
// another one:
//
//   C = signed distance − min(gap, signed distance at rest) + slop ≥ 0
//
// so that surfaces that coincide or overlap at rest are free of forces there. The nearest way out
// of a penetration isn't always the way in:
//
//          │ ○ → ○ over the rim: up              ● at the start of the sub-step
//     ●────┼→ ○    deeper than level: back to    ○ at its end
//   ───────┴────   the side that it came from
//
// A node that was outside of the nearest triangle's plane at the start, or level with it, leaves
// that way. Otherwise, the nearest triangle at the start is taken, and C linear from there on.
//
// Search: a pair of patches has a list of triangles for each node, sorted by distance. It holds
// until the patches have moved relative to each other by half of the reach. In between, the
// distances in the list bound those of the present, so few triangles are tested. Lists leave out
// only triangles that can't be the nearest, so touches depend on positions alone.

#pragma once

#include <pliant/core/tasks.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "pbd/body_surface.h"

namespace pliant::pbd {

struct PieceTouch {
    std::int32_t node = 0, triangle = 0;
    Vec3d normal{0, 0, 0};            ///< from the triangle to the side of the node
    std::array<double, 3> weights{};  ///< of the triangle's nodes
    double limit = 0;                 ///< of the signed distance
    Vec3d apart{0, 0, 0};             ///< node − point of the triangle, at the start
};

class PieceContact {
  public:
    /// @param rest   positions of the surface's nodes
    /// @param gap    distance that pieces keep
    PieceContact(const BodySurface& surface, std::span<const Vec3d> rest, double gap);

    double slop() const { return m_slop; }
    /// Signed distance below which a node and a piece are pushed apart.
    double limit_of(std::int32_t node, std::int32_t piece) const;

    /// Finds the touches of a sub-step.
    /// @param start, x  positions at its start and at its end
    /// @param[out] touches  sorted by patch, node and piece
    void find(const BodySurface& surface, std::span<const Vec3d> start, std::span<const Vec3d> x,
              const TaskArena& arena, std::vector<PieceTouch>& touches);

  private:
    /// Displacements of a patch's nodes from their anchors. When these are renewed, they lie within
    /// `spread` of a common displacement.
    struct Motion {
        Vec3d way{0, 0, 0};  ///< middle of the displacements, from the first anchors on
        double spread = 0;   ///< largest deviation from it
        double lost = 0;     ///< sum of the spreads when anchors were renewed
    };
    struct Candidate {
        std::int32_t triangle;
        float distance;  ///< a lower bound, when it was listed
    };
    /// Triangles of a patch that are near the nodes of another one.
    struct Partner {
        explicit Partner(std::int32_t number) : patch(number) {}

        std::int32_t patch;
        bool is_listed = false;
        Motion own, other;                 ///< of the patches, when it was listed
        std::vector<std::int32_t> starts;  ///< [owned node]; empty: no candidates
        std::vector<Candidate> candidates;
    };
    struct RestGap {
        std::int32_t piece;
        double gap;
    };
    enum Time { kStart, kEnd };
    /// Motion of a patch and a partner relative to each other since the partner was listed.
    struct Moved {
        double before = 0;  ///< until the start
        double shift = 0;   ///< farthest of a node of the partner's patch in the sub-step
    };
    /// Candidates of a node in a partner.
    struct Run {
        std::int32_t piece, node;  ///< of the partner; of this patch
        std::int32_t partner;      ///< index
        float least;               ///< distance of the first
        const Candidate *begin, *end;
    };
    /// A node, and triangles of one piece.
    struct Near {
        std::int32_t node;
        double shift;  ///< of the node in the sub-step
        std::span<const Run> runs;
        std::span<const Moved> moved;  ///< [partner]
    };
    using Positions = std::array<std::span<const Vec3d>, 2>;

    static Vec3d way_between(const Motion& a, const Motion& b) { return b.way - a.way; }
    static double spread_between(const Motion& a, const Motion& b) {
        return a.spread + b.spread + std::abs(b.lost - a.lost);
    }
    void move(const BodySurface& surface, std::size_t patch, const Positions& x);
    void pair_patches(const BodySurface& surface, std::span<const Vec3d> start);
    void list(const BodySurface& surface, std::size_t patch, Partner& partner,
              std::span<const Vec3d> x);
    void see_partners(const BodySurface& surface, std::size_t patch, std::span<const Vec3d> start,
                      bool is_fast);
    void list_runs(const BodySurface& surface, std::size_t patch);
    void search_patch(const BodySurface& surface, std::size_t patch, const Positions& x,
                      bool is_fast, std::vector<PieceTouch>& touches) const;
    SurfacePoint nearest(const BodySurface& surface, std::span<const Vec3d> x, const Near& near,
                         Time time) const;
    Vec3d normal_at(const BodySurface& surface, std::span<const Vec3d> x, std::int32_t node,
                    const SurfacePoint& point, double side) const;
    PieceTouch touch_of(const BodySurface& surface, const Positions& x, const Near& near,
                        const SurfacePoint& point, Time time, double side) const;
    void search(const BodySurface& surface, const Positions& x, const Near& near, bool is_fast,
                std::vector<PieceTouch>& touches) const;

    double m_gap, m_reach, m_slop, m_tiny, m_level;
    std::vector<std::int32_t> m_rest_starts;       ///< [node]
    std::vector<RestGap> m_rests;                  ///< where it is below the gap
    bool m_is_known = false;                       ///< whether the following are right
    std::vector<Vec3d> m_anchors;                  ///< [node of a patch]
    std::vector<Motion> m_bases;                   ///< [patch]: way and lost of its anchors
    std::vector<Motion> m_motions;                 ///< [patch]: until the start
    std::vector<double> m_shifts;                  ///< [patch]: farthest of a node in the sub-step
    std::vector<Motion> m_paired;                  ///< [patch]: when pairs were found
    PatchBoxes m_boxes;                            ///< then
    std::vector<std::vector<Partner>> m_partners;  ///< [patch]: sorted
    std::vector<Partner> m_before;                 ///< of a patch, while it is paired anew
    std::vector<std::vector<Run>> m_runs;          ///< [patch]: sorted by piece, node and partner
    std::vector<char> m_runs_are_old;              ///< [patch]
    std::vector<std::vector<Moved>> m_moved;       ///< [patch][partner]
    std::vector<std::vector<PieceTouch>> m_found;  ///< [patch]
};

}  // namespace pliant::pbd
