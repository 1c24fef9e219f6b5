// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The pictures of one endoscope of an arena, and the flow from one to the next.

#pragma once

#include <pliant/data/gym.h>

#include <vector>

#include "gym/endoscope_scope.h"

namespace pliant {

/// Where one endoscope's pictures are written.
struct SightTarget {
    std::span<Rgb8> colour;
    std::span<float> depth_mm;
    std::span<Vec3f> normals;
    std::span<float> flow;
    std::span<FlowVisibility> visibility;
    std::span<Vec3f> scene_flow_mm;
    std::span<std::int16_t> labels;
};

class Sight {
  public:
    explicit Sight(const ArenaScan& scan) : m_scan(scan) {}

    /// Makes the pictures. @param follows  whether the last picture was that of the step before;
    /// else the flow is 0
    void look(const Scope& scope, bool follows, const SightTarget& target);

  private:
    void trace_flow(const Scope& scope, const SightTarget& target) const;
    void find_rest(const Scope& scope, const SightTarget& target, std::span<const Vec3f> normals);

    const ArenaScan& m_scan;
    // Per pixel of the last picture.
    std::vector<Vec3f> m_normals;      ///< if only labels need them
    std::vector<Vec3d> m_points_mm;    ///< infinite: none
    std::vector<Vec3d> m_rest_voxels;  ///< infinite: none
};

}  // namespace pliant
