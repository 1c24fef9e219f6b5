// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contact of the pieces of a body. A touch is a node of one piece and the nearest triangle of
// another one:
//
//   C = signed distance − min(gap, signed distance at rest) + slop ≥ 0
//
// so that surfaces that coincide or overlap at rest are free of forces there. At the rim of a
// surface, the nearest way out of a penetration may be the wrong one. So where the normal differs
// from that at the start of the sub-step, the latter's triangle is taken, and C linear from there
// on.
//
// The broad phase lists the triangles near each node, patch by patch, and again when a node of the
// patch or of a patch near it has left its anchor. The narrow phase skips a patch as long as it and
// its partners have moved by less than the smallest C of its nodes: signed distances change by no
// more. Both only leave out pairs that can't touch, so touches depend on positions alone.

#pragma once

#include <array>
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
};

class PieceContact {
  public:
    /// @param rest   positions of the surface's nodes
    /// @param gap    distance that pieces keep
    PieceContact(const BodySurface& surface, std::span<const Vec3d> rest, double gap);

    /// Motion of a node after which it is listed anew.
    static double margin(const BodySurface& surface) { return 0.25 * surface.mean_edge(); }
    double slop() const { return m_slop; }
    /// Signed distance below which a node and a piece are pushed apart.
    double limit_of(std::int32_t node, std::int32_t piece) const;

    /// Broad phase, at the start of a sub-step: renews the lists of the patches that have changed.
    /// If it throws, call forget() of the boxes.
    void list(const BodySurface& surface, PatchBoxes& boxes);
    /// Narrow phase, at its end. @param start  positions in list()
    /// @param[out] touches  sorted by patch, node and piece
    void find(const BodySurface& surface, const PatchBoxes& boxes, std::span<const Vec3d> start,
              std::span<const Vec3d> x, std::vector<PieceTouch>& touches);

  private:
    struct Partner {
        std::int32_t patch;
        double drift;  ///< when this patch was last searched
    };
    struct Pair {
        std::int32_t node, triangle;
    };
    struct Near {
        std::vector<Partner> partners;
        std::vector<Pair> pairs;
        double drift = 0;   ///< of the patch, when it was last searched
        double slack = -1;  ///< smallest C of its nodes then
    };
    /// Positions of a search.
    struct Moved {
        std::span<const Vec3d> start, x;
        double most;  ///< largest approach
    };
    struct RestGap {
        std::int32_t piece;
        double gap;
    };
    void list_patch(const BodySurface& surface, const PatchBoxes& boxes, std::size_t patch);
    bool is_quiet(const Near& near, const PatchBoxes& boxes, std::size_t patch) const;
    static SurfacePoint nearest(const BodySurface& surface, std::span<const Vec3d> x,
                                std::int32_t node, std::span<const Pair> pairs);
    Vec3d normal_at(const BodySurface& surface, std::span<const Vec3d> x, std::int32_t node,
                    const SurfacePoint& point, double& side) const;
    double search(const BodySurface& surface, const Moved& moved, std::int32_t node,
                  std::span<const Pair> pairs, std::vector<PieceTouch>& touches) const;

    double m_gap, m_reach, m_slop, m_tiny;
    std::vector<std::int32_t> m_rest_starts;  ///< [node]
    std::vector<RestGap> m_rests;             ///< where it is below the gap
    std::vector<Near> m_near;                 ///< [patch]
    std::vector<std::int32_t> m_changed;      ///< patches
    std::vector<double> m_drifts;             ///< [patch]: at the start of the sub-step
};

}  // namespace pliant::pbd
