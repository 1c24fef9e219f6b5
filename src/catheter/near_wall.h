// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What of a wall's ghost surface is near to one segment of a wire, and where the two may touch.
// Segments don't know of each other, so each may have its thread.
//
// Now and then: which triangles are so near that they may be touched until the next time, the
// nearest first. In each sub-step: the nearest points of those that are near enough by now.
// Triangles that share the corner or edge that is nearest are one place, and the first of them by
// number has it; of the places of the segment's end, and of those before it, a few are kept that
// point differently. So what is found doesn't depend on when was looked last.

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "catheter/wire.h"
#include "pbd/ghost_surface.h"

namespace pliant::catheter {

struct WallContactSettings {
    double radius_mm = 0.9;
    double skin_mm = 0.05;       ///< the wire is held that far from the wall
    double friction = 0.1;       ///< Coulomb's
    double compliance = 1e-7;    ///< of the surfaces themselves [mm/µN]
    double sticking_mm_s = 0.5;  ///< slower than this, friction is less than Coulomb's
};

/// Further than what moves in a step: triangles within this count for the depth [mm].
inline constexpr double kLook = 1;

/// A contact that is this much open may close in the wire's solve [mm].
inline constexpr double kOpen = 0.2;

/// The part of a segment that is outside of the guide: the wall doesn't feel what is in it.
struct SegmentOutside {
    std::int32_t number;
    bool is_first;  ///< begins at the guide's end
    double along;   ///< where on the segment it begins
    Vec3d begin, end;
    Vec3d before[2];  ///< the segment's nodes, a sub-step ago
};
SegmentOutside outside_of(const Wire& wire, std::int32_t segment);

class NearWall {
  public:
    struct Found {
        WireContact contact;
        double gap;
        Vec3d place;
        std::int32_t triangle;
    };

    /// @param moves  by how much the segment may move until this is called again [mm]
    void look(Vec3d begin, Vec3d end, double moves, const WallContactSettings& settings,
              const pbd::GhostSurface& ghost);
    /// @param nearer  by how much segment and triangles have come nearer since, at most [mm]
    void find(const SegmentOutside& segment, double nearer, const WallContactSettings& settings,
              const pbd::GhostSurface& ghost);
    /// How far the surface of the wire is beyond the ghost surface, at most; below 0: in between.
    double depth(const SegmentOutside& segment, double nearer, double radius_mm,
                 const pbd::GhostSurface& ghost) const;

    struct Pair {
        std::int32_t triangle;
        double distance;  ///< when `look` saw them
    };
    std::span<const Pair> pairs() const { return m_pairs; }  ///< nearest first
    std::span<const Found> found() const { return m_found; }

  private:
    struct Spot {  ///< a triangle's nearest place to the segment, or to its end
        double along;
        Vec3d on_wire, on_wall;
        std::int32_t triangle;
        int feature;
    };
    bool is_new(const Spot& spot, const pbd::GhostSurface& ghost);
    bool is_nearest(Vec3d on_wire, double distance, const pbd::GhostSurface& ghost) const;
    void consider(const SegmentOutside& segment, const Spot& spot,
                  const WallContactSettings& settings, const pbd::GhostSurface& ghost);
    void keep_some(std::size_t from);

    std::vector<Pair> m_pairs;
    bool m_is_beyond = false;  ///< the segment isn't in the lumen: its pairs are all looked at
    std::vector<Found> m_found;
    std::vector<std::int32_t> m_triangles;                ///< near enough to look at
    std::vector<std::array<std::int32_t, 2>> m_features;  ///< corners and edges seen
};

}  // namespace pliant::catheter
