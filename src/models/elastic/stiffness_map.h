// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Stiffness of a scan on lattices of cells: the cells between voxel centres, and coarser ones. A
// coarser lattice doubles the shorter edges of its cells. Its moduli are means of the finer cells'.
//
//   level 0    +--+--+--+--+--+      nodes are voxels
//   level 1    +-----+-----+-----+   every second node; the last cell may stand out: void
//
// Void cells have a small modulus, so that their nodes follow their neighbours smoothly. Carved
// voxels count as air; cells with a cut link are slits: softer still.

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/models/elastic_scan.h>
#include <pliant/volume.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "field/field.h"
#include "material/labels.h"

namespace pliant {

enum class CellKind : std::uint8_t {
    Open,    ///< of air, or with air at a corner
    Tissue,  ///< all of its voxels are, or on coarser levels their mean is
    Slit     ///< with a cut link
};

class StiffnessMap {
  public:
    /// @param volume  must outlive the map
    /// @param edits   whose cut links and carved voxels count; null: none. Must outlive the map
    /// @pre checked volume and settings, 2 voxels or more along each axis
    StiffnessMap(const Volume& volume, const ElasticScanSettings& settings, const TaskArena& arena,
                 const Field* edits = nullptr);
    /// Takes changed edits in a box of voxels into account.
    void renew(const Box3i& voxels, const TaskArena& arena);

    int level_count() const { return int(m_shifts.size()); }
    /// A cell of a level has 2^shift voxels along each axis.
    Vec3i shift(int level) const { return m_shifts[std::size_t(level)]; }
    /// Cells of a level: the scan's, and those beyond its border that fill the coarsest cells.
    Vec3i cells(int level) const { return m_cells[std::size_t(level)]; }
    Vec3d spacing_mm(int level) const;
    float lambda_per_mu() const { return m_lambda_per_mu; }
    float void_mu() const { return m_void_mu; }  ///< [Pa]
    /// Of cells between walls that touch [Pa]: half of the stiffest tissue that moves.
    float touching_mu() const { return kTouching * m_void_mu; }

    /// Writes shear moduli [Pa] of a box of cells: cell c of the box at mu[c.x + stride·(c.y +
    /// rows·c.z)].
    void moduli(int level, const Box3i& cells, std::size_t stride, std::size_t rows,
                float* mu) const;
    /// Writes the kinds of a box of cells, in the same order.
    void kinds(int level, const Box3i& cells, std::size_t stride, std::size_t rows,
               CellKind* kind) const;
    /// Whether a node never moves: bone, or on a held side.
    bool is_held(int level, Vec3i node) const;
    bool is_bone(Vec3i ijk) const {
        const LabelledTissue* const own = tissue_at(ijk);
        return double(m_volume.at(ijk)) > (own ? own->held_above : m_held_above) && !is_carved(ijk);
    }
    /// Whether a voxel is much stiffer than a void.
    bool is_tissue(Vec3i ijk) const { return mu_of(ijk) > kTissue * m_void_mu && !is_carved(ijk); }
    static constexpr float kTissue = 8;  ///< multiple of a void's modulus from which cells count
    static constexpr float kSlit = 1 / 16.0F;  ///< modulus of a cut cell over that of a void
    static constexpr float kTouching = 1000;
    const Grid& grid() const { return m_volume.grid; }

  private:
    struct LabelledTissue {
        std::optional<float> mu;  ///< [Pa]; none: by value
        double held_above;
    };

    float modulus_of(float value) const;
    /// The tissue of a voxel's label; null: it has none.
    const LabelledTissue* tissue_at(Vec3i ijk) const {
        const int tissue = m_labels.empty() ? -1 : m_labels.law_at(ijk);
        return tissue < 0 ? nullptr : &m_labelled[std::size_t(tissue)];
    }
    float mu_of(Vec3i ijk) const {
        const LabelledTissue* const own = tissue_at(ijk);
        return own && own->mu ? *own->mu : m_mu_per_pa * modulus_of(m_volume.at(ijk));
    }
    void take_labels(const ElasticScanSettings& settings);
    void find_held_sides(const ElasticScanSettings& settings);
    void coarsen(int level, const Box3i& cells, const TaskArena& arena);
    void fine_row(Vec3i first, int count, float* mu) const;
    bool is_bone_node(int level, Vec3i node) const;
    void bone_row(int level, Vec3i first, int count, std::uint8_t* row) const;
    void coarsen_bone(int level, const Box3i& nodes, const TaskArena& arena);
    bool is_carved(Vec3i ijk) const { return m_edits && (edits_at(ijk) & kVoid) != 0; }
    std::uint8_t edits_at(Vec3i ijk) const;
    bool is_slit(Vec3i cell) const;
    float edited_mu(Vec3i cell) const;
    template <class Visit>
    void for_each_edited(Vec3i first, int count, const Visit& visit) const;

    const Volume& m_volume;
    const Field* m_edits;
    std::vector<ElasticScanSettings::Modulus> m_table;
    LabelMap m_labels;
    std::vector<LabelledTissue> m_labelled;
    std::vector<float> m_of_value;  ///< [value + 32768] shear modulus of 16-bit values
    float m_lambda_per_mu, m_void_mu;
    float m_mu_per_pa;
    double m_held_above;
    bool m_is_side_held[3][2] = {};
    std::vector<Vec3i> m_shifts, m_cells;           ///< [level]
    std::vector<std::vector<float>> m_mu;           ///< [level − 1][cell]
    std::vector<std::vector<std::uint8_t>> m_bone;  ///< [level − 1][node]
};

}  // namespace pliant
