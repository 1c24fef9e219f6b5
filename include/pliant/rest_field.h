// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Coarse field of rest positions in a deformed scan. Patterns on a wall (vessels, folds) use it to
// move, stretch and be cut with the tissue.
//
//   position at rest = position − offset      offset(p) = p − φ⁻¹(p), φ from rest to deformed
//
//     voxels   0 1 2 3 4 5 6 7 8 9        nodes at every 4th voxel of the deformed scan; the last
//     nodes    0       1       2       3  one may lie beyond the border, and has the value of the
//                                         border's voxel
//
// A node holds four half floats: the offset [mm, LPS], and whether the tissue is raw (carved or cut
// open). That is 8 bytes for 64 voxels. A field at rest has no memory.

#pragma once

#include <pliant/resample.h>

#include <cstdint>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// Spacing of the nodes [voxels].
inline constexpr int kRestStep = 4;
/// Tissue is raw up to two voxels from a carved element or a cut link. The rawness fades out up to
/// this distance [voxels at rest].
inline constexpr double kRawReach = 6;

class RestField {
  public:
    struct Sample {
        Vec3f offset_mm{0, 0, 0};  ///< LPS; position at rest = position − offset
        float raw = 0;             ///< 0…1: 1 at carved or cut tissue
    };

    RestField() = default;
    /// Creates a field at rest.
    explicit RestField(const Grid& grid);

    /// Creates the field of a scan after a complete deformation.
    /// @param deformed  deform_volume(scan, …, with_inverse = true)
    /// @returns InvalidArgument if it has no inverse or another grid; LimitExceeded
    static Result<RestField> create(const MovingScan& scan, const Deformed& deformed) noexcept;

    /// Follows an update. The result is bit-identical to a new field.
    ///
    ///   live.keep_sources(true);
    ///   RestField rest(grid);  rest.update(live, everything that is deformed);
    ///   …
    ///   const Result<LiveUpdate> update = live.update();
    ///   rest.update(live, update->boxes);
    ///
    /// Call it after each update of live, even one without boxes: a closed cut changes no voxel,
    /// but its tissue is raw. Another tissue of the same scan needs a new field.
    /// @pre live.keeps_sources()
    /// @param boxes  disjoint boxes of voxels that may have changed since the last call
    /// @returns boxes of changed nodes, valid until the next call; LimitExceeded, after which a new
    ///          field is needed
    Result<std::span<const Box3i>> update(const LiveDeformation& live,
                                          std::span<const Box3i> boxes) noexcept;

    const Grid& grid() const { return m_grid; }
    /// Nodes along each axis: ⌈(size − 1) / kRestStep⌉ + 1.
    Vec3i counts() const { return m_counts; }
    /// Whether every node is zero.
    bool at_rest() const { return m_halves.empty(); }
    /// Interpolates trilinearly between nodes, constant beyond them. @param ijk  voxels of the
    /// deformed scan
    Sample at(Vec3d ijk) const;
    /// Four half floats (IEEE 754 binary16) per node, i fastest: x, y, z of the offset, raw. Empty
    /// at rest.
    std::span<const std::uint16_t> halves() const { return m_halves; }
    /// Copies the halves of a box of nodes; zeros at rest. @param[out] halves  four per node
    void copy(const Box3i& nodes, std::span<std::uint16_t> halves) const;

  private:
    class Writer;
    std::size_t index(Vec3i node) const {
        return 4 * (std::size_t(node.x) +
                    std::size_t(m_counts.x) *
                        (std::size_t(node.y) + std::size_t(m_counts.y) * std::size_t(node.z)));
    }

    Grid m_grid;
    Vec3i m_counts{0, 0, 0};
    std::vector<std::uint16_t> m_halves;
    std::int64_t m_moved = 0;                           ///< nodes other than zero
    std::uint64_t m_links_version = ~std::uint64_t(0);  ///< of the lattice, at the last update
    bool m_had_edits = false;                           ///< likewise: there were cuts or carvings
    std::vector<Box3i> m_boxes;
};

/// Number of nodes in a box of them.
constexpr std::int64_t node_count(const Box3i& nodes) {
    const Vec3i n = nodes.end - nodes.begin;
    return std::int64_t(n.x) * n.y * n.z;
}

}  // namespace pliant
#pragma GCC visibility pop
