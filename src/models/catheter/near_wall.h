// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Collision detection between one segment of a wire and a wall's ghost surface. Segments are
// independent, so they can be processed in parallel.
//
// The broad phase runs now and then: it lists the triangles that may be touched until its next run,
// nearest first. The narrow phase runs in each sub-step: it computes the nearest points of
// triangles that are near enough. Triangles that share the nearest corner or edge give one contact,
// assigned to the first of them by number. Of the contacts at the segment's end, and of those in
// its interior, a few with distinct normals are kept. So the result is independent of the time of
// the last broad phase.

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
    double skin_mm = 0.05;       ///< distance kept from the wall
    double friction = 0.1;       ///< Coulomb friction coefficient
    double compliance = 1e-7;    ///< of the surfaces [mm/µN]
    double sticking_mm_s = 0.5;  ///< regularisation: at lower speeds friction is reduced
    bool is_rigid = false;       ///< the wall doesn't move
    double kept_mm = 0.3;        ///< motion until the next broad phase; results don't depend on it
};

/// Larger than the motion in a step: triangles within this distance contribute to the depth [mm].
inline constexpr double kLook = 1;

/// A contact with a gap up to this may close during the wire's solve [mm].
inline constexpr double kOpen = 0.2;

/// Part of a segment outside of the guide. Only this part touches the wall.
struct SegmentOutside {
    std::int32_t number;
    bool is_first;  ///< begins at the guide's end
    double along;   ///< position of its start on the segment
    Vec3d begin, end;
    Vec3d before[2];  ///< the segment's nodes before the sub-step
};
SegmentOutside outside_of(const Wire& wire, std::int32_t segment);

class NearWall {
  public:
    struct Found {
        WireContact contact;
        double gap;
        Vec3d position;
        std::int32_t triangle;
    };

    /// @param moves  maximum motion of the segment until the next call [mm]
    void look(Vec3d begin, Vec3d end, double moves, const WallContactSettings& settings,
              const pbd::GhostSurface& ghost);
    /// @param nearer  maximum approach of segment and triangles since look() [mm]
    void find(const SegmentOutside& segment, double nearer, const WallContactSettings& settings,
              const pbd::GhostSurface& ghost);
    /// Largest penetration of the ghost surface by the wire's surface; negative: distance.
    double depth(const SegmentOutside& segment, double nearer, double radius_mm,
                 const pbd::GhostSurface& ghost) const;

    struct Pair {
        std::int32_t triangle;
        double distance;  ///< at the time of look()
    };
    std::span<const Pair> pairs() const { return m_pairs; }  ///< nearest first
    std::span<const Found> found() const { return m_found; }

  private:
    struct Spot {  ///< a triangle's nearest point to the segment, or to its end
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
    bool m_is_beyond = false;  ///< the segment isn't in the lumen: all its pairs are tested
    std::vector<Found> m_found;
    std::vector<std::int32_t> m_triangles;                ///< candidates of the narrow phase
    std::vector<std::array<std::int32_t, 2>> m_features;  ///< corners and edges already found
};

}  // namespace pliant::catheter
