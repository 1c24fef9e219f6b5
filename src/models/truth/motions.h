// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Random motions of a case on a tissue of the scan. Each has tools of its own, which stay: a tissue
// that moves by itself is advanced to its equilibrium after each motion.

#pragma once

#include <pliant/data/truth.h>
#include <pliant/tissue.h>

#include <cstdint>
#include <vector>

#include "truth/regions.h"

namespace pliant::truth {

// Random numbers by counter: number n of a stream depends on the seed, the stream and n alone. The
// mixing step is SplitMix64's [Steele2014].

inline std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

class Draws {
  public:
    Draws(std::uint64_t seed, std::uint64_t stream)
        : m_key(mixed(mixed(seed + kStep) ^ (kStep * (stream + 1)))) {}

    std::uint64_t bits() { return mixed(m_key + kStep * ++m_count); }
    /// 0 ≤ number < 1
    double unit() { return double(bits() >> 11) * 0x1p-53; }
    double real(double low, double high) { return low + (high - low) * unit(); }
    /// 0 ≤ number < count. @pre count > 0
    std::uint64_t below(std::uint64_t count) { return bits() % count; }
    /// Evenly spread over the sphere.
    Vec3d direction() {
        for (;;) {
            const Vec3d v{real(-1, 1), real(-1, 1), real(-1, 1)};
            const double length = norm(v);
            if (length > 0.1 && length <= 1) return (1 / length) * v;
        }
    }
    /// A direction perpendicular to a unit vector.
    Vec3d across(Vec3d unit_vector) {
        for (;;) {
            const Vec3d v = direction();
            const Vec3d flat = v - dot(v, unit_vector) * unit_vector;
            if (norm(flat) > 0.1) return normalized(flat);
        }
    }

  private:
    static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;
    std::uint64_t m_key, m_count = 0;
};

/// A smooth displacement of the whole scan: w(X)·A·(direction + waves). w is 0 at bone and at the
/// border, and rises smoothly within three amplitudes, so that the gradient stays below about 0.6.
struct Breathing {
    double amplitude_mm = 0;                ///< 0: none
    Vec3d along{0, 0, 1}, beside{0, 1, 0};  ///< LPS
    Vec3d wave{0, 0, 0};                    ///< wave vector [1/mm]
    double phase = 0;

    double reach_mm() const { return 3 * amplitude_mm; }
    /// @param rigid_mm  distance to the nearest voxel that never moves
    Vec3d at(Vec3d point_mm, double rigid_mm) const;
};

class Motions {
  public:
    /// Keeps references.
    Motions(const Volume& scan, const Regions& regions, const TruthSettings& settings,
            double air_threshold_hu, Tissue& tissue)
        : m_scan(scan),
          m_regions(regions),
          m_settings(settings),
          m_air_threshold_hu(air_threshold_hu),
          m_tissue(tissue),
          m_cut_labels(voxel_count(scan.grid), 0) {}

    /// Draws positions until a motion of the kind has an effect.
    /// @returns false if none was found; LimitExceeded
    Result<bool> carry_out(TruthKind kind, Draws& draws);

    const std::vector<TruthMotion>& done() const { return m_done; }
    const Breathing& breathing() const { return m_breathing; }
    /// Voxels at both ends of links that were cut, by TruthLabel::Interface or Cut.
    std::vector<std::uint32_t> cut_voxels(TruthLabel label) const;

  private:
    Result<bool> contact(Draws& draws);
    Result<bool> slide(Draws& draws);
    Result<bool> cut(Draws& draws, TruthKind kind);
    /// Cuts, and moves the sides. @returns false if they move by less than half of the motion
    Result<bool> open_cut(Draws& draws, Vec3d along, TruthMotion& motion);
    /// Lets a tissue that moves by itself do so, and writes the deformation.
    Status settle(int max_sweeps);
    bool breathe(Draws& draws);
    /// Random voxel of a list, and its position now [mm, LPS].
    Vec3i voxel_of(const std::vector<std::uint32_t>& list, Draws& draws) const;
    Vec3d position_of(Vec3i voxel) const;
    double amount(double largest, Draws& draws) const { return largest * draws.real(0.3, 1); }
    double radius(Draws& draws) const;
    void note_cuts(TruthLabel label);

    const Volume& m_scan;
    const Regions& m_regions;
    const TruthSettings& m_settings;
    double m_air_threshold_hu;
    Tissue& m_tissue;
    std::uint32_t m_tool = 0;  ///< of the last motion
    std::vector<TruthMotion> m_done;
    Breathing m_breathing;
    std::vector<std::uint8_t> m_cut_labels;
};

}  // namespace pliant::truth
