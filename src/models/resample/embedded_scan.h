// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan that tetrahedra carry. Each voxel within a tetrahedron moves by its affine map; a voxel
// outside, at a distance d from the nearest point q of the surface, by
//
//   fade(d) · u(q),   fade(d) = (1 − (d/reach)²)²
//
// Solids of the mesh may carry voxels of their own labels, so that a scan keeps its borders between
// organs that slide: a voxel follows a tetrahedron of its own solid even where the meshes of two
// neighbours overlap or leave a gap.
//
// In a mesh with cuts a voxel moves with the copy of its tetrahedron that has its material. Links
// between voxels whose copies a cut has separated are cut, so that it opens a gap in the scan.

#pragma once

#include <pliant/mesh.h>
#include <pliant/models/cut_mesh.h>
#include <pliant/resample.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "field/writable_field.h"

namespace pliant {

/// Voxels along the edge of a brick of the field.
inline constexpr int kCarriedBrickSize = 8;

struct EmbeddedScanSettings {
    double reach_mm = 10;
    std::vector<std::int32_t> solids{};  ///< [tetrahedron]: its solid; empty: all are of one
    /// Solid that carries a voxel; −1: any, −2: none. Empty: any.
    std::function<std::int32_t(Vec3i ijk)> solid_at{};
};

/// Thread safety: one thread.
class EmbeddedScan final : public MovingScan {
  public:
    /// Keeps references: volume and arena must outlive it.
    /// @param mesh  at rest [mm, LPS]; no tetrahedron is inverted or flat
    /// @returns InvalidArgument for a mesh beside the scan; LimitExceeded if memory runs out
    static Result<std::unique_ptr<EmbeddedScan>> create(const Volume& volume, const TetMesh& mesh,
                                                        const EmbeddedScanSettings& settings,
                                                        const TaskArena& arena) noexcept;

    /// Moves the voxels with the nodes. Visits only bricks with a tetrahedron that moved since the
    /// last call. @param nodes_mm  present positions [mm, LPS]
    /// @returns InvalidArgument if a displacement isn't finite or exceeds 500 mm along an axis,
    ///          LimitExceeded if memory runs out; then nothing has changed
    Status place(std::span<const Vec3d> nodes_mm) noexcept;

    /// The voxels in a mesh with cuts.
    struct Cuts;
    /// Finds the copy that carries each voxel, and the links that are cut.
    /// @pre the mesh that create() was given, with cuts; memory may run out
    std::shared_ptr<const Cuts> find_cuts(const CutMesh& mesh) const;
    /// Likewise as place(), with other cuts than the present ones. @param cuts  null: none
    Status place(std::shared_ptr<const Cuts> cuts, std::span<const Vec3d> nodes_mm) noexcept;
    /// Number of cut links.
    std::int64_t cut_links() const;

    /// Number of voxels that the mesh carries.
    std::int64_t voxel_count() const { return m_voxels; }

    const Volume& volume() const override { return m_scan; }
    const Deformation& deformation() const override { return m_deformation; }
    const TaskArena& arena() const override { return m_arena; }

  private:
    /// Voxels of a row that one tetrahedron contains.
    struct Run {
        std::int32_t tetrahedron;
        std::uint16_t first;  ///< index in the brick
        std::uint16_t count;
    };
    /// A voxel outside of its solid.
    struct Follower {
        std::int32_t tetrahedron;
        std::uint16_t index;  ///< in the brick
        float fade;
        Vec3f nearest;  ///< point of the tetrahedron, in voxels
    };
    struct Brick {
        Vec3i coord;
        std::vector<Run> runs;
        std::vector<Follower> followers;
    };
    /// Affine map of a tetrahedron at rest: weights of corners 1, 2, 3 at a point are
    /// slopes · (point − origin), in voxels.
    struct Rest {
        Vec3d origin;
        Vec3d slopes[3];
    };
    /// Displacement: shift + Σ ijk along, in units of the field, along its axes.
    struct Map {
        Vec3d shift, along[3];
        Vec3d at(Vec3d p) const { return shift + p.x * along[0] + p.y * along[1] + p.z * along[2]; }
    };

    EmbeddedScan(const Volume& volume, const TetMesh& mesh, const TaskArena& arena);
    static void add_inside(Brick& brick, std::uint16_t index, std::int32_t cell);
    void fill(const EmbeddedScanSettings& settings, const Box3i& voxels);
    std::vector<std::int32_t> find_inside(const EmbeddedScanSettings& settings,
                                          const Box3i& voxels) const;
    void list_bricks_of_tetrahedra();
    Status move(std::span<const Vec3d> nodes_mm);
    Status move(std::shared_ptr<const Cuts> cuts, std::span<const Vec3d> nodes_mm);
    Status find_units(std::span<const Vec3d> nodes_mm, std::span<const Vec3d> rest_mm,
                      std::vector<Vec3d>& units) const;
    void list_bricks_of(std::size_t tetrahedron);
    void list_brick(std::int32_t brick);
    void end_list();
    void make_field_bricks();
    void list_bricks(std::span<const Vec3d> units);
    void write_listed();
    const Brick& shown(std::size_t brick) const;
    std::span<const std::array<std::int32_t, 4>> cells() const;
    std::span<const Vec3d> rest_mm() const;
    std::size_t uncut_cell(std::size_t tetrahedron) const;
    Map map_of(std::size_t tetrahedron) const;
    void write(const Brick& from, FieldBrick& to) const;

    const Volume& m_scan;
    const TaskArena& m_arena;
    WritableField m_field;
    Deformation m_deformation{m_field};
    // The mesh without cuts.
    std::vector<std::array<std::int32_t, 4>> m_cells;
    std::vector<Vec3d> m_rest_mm;
    std::vector<Rest> m_rests;  ///< [tetrahedron]
    std::vector<Brick> m_bricks;
    std::vector<std::int32_t> m_brick_starts, m_bricks_of;  ///< bricks of each tetrahedron
    // The mesh with the present cuts.
    std::shared_ptr<const Cuts> m_cuts;     ///< null: none
    std::vector<Map> m_maps;                ///< [tetrahedron]
    std::vector<Vec3d> m_units, m_next;     ///< [node]: displacement along the axes [2⁻²⁰ mm]
    std::vector<std::int32_t> m_moved;      ///< tetrahedra
    std::vector<std::uint8_t> m_is_listed;  ///< [brick]
    std::vector<std::int32_t> m_listed;     ///< bricks to be written
    std::vector<int> m_field_bricks;        ///< likewise, in the field
    std::int64_t m_voxels = 0;

    friend class CutFinder;
};

struct EmbeddedScan::Cuts {
    std::vector<std::array<std::int32_t, 4>> cells;  ///< with copies
    std::vector<Vec3d> rest_mm;                      ///< [node]
    std::vector<std::int32_t> uncut_cell_of;         ///< [tetrahedron]
    std::vector<std::int32_t> numbers;               ///< of bricks with copies, sorted
    std::vector<Brick> bricks;                       ///< in place of these
    EditMap edits;
    std::int64_t links = 0;  ///< that are cut
};

}  // namespace pliant
