// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The material laws, evaluated once for every voxel value and quantised towards tighter limits.
//
// A link's limit is the mean of its two ends times its length h, so each end contributes half:
// limit(i, j) = half(i) + half(j), half = ⌊h·fraction/2⌋ in fixed-point units.
//
// Values with equal limits share an entry, so that the table fits into the caches: a few thousand
// entries for a CT under a smooth law, one for a homogeneous block. Entry 0 is void: elements that
// were carved away or lie beyond a bounded lattice. Its links never bind.

#pragma once

#include <pliant/models/material.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "material/limit_units.h"

namespace pliant {

/// Scale on which a law is looked up: whole numbers that stand for voxel values. Values of CT are
/// their own numbers. Floats of any other range are stretched, so that the law's range has 4096
/// numbers.
///
///   number = round(value · per_value + shift)
struct LookupScale {
    double per_value = 1, shift = 0;

    double value_of(int number) const {
        return per_value == 1 ? number : (number - shift) / per_value;
    }
    /// Nearest number, not rounded: of a threshold.
    double position_of(double value) const { return value * per_value + shift; }
};

/// Settings for a scan's values.
struct ResolvedSettings {
    ChainMailSettings settings;  ///< range_percent is replaced by the range
    LookupScale scale;
};
ResolvedSettings resolve(const ChainMailSettings& settings, const Volume& volume);
/// Limits of Dräger's law at any value; see draeger_law.
ElementLimits draeger_limits(const ChainMailSettings& settings, double value);
/// The law by number on the scale.
MaterialLaw law_on_scale(const ChainMailSettings& settings, LookupScale scale);

/// Index into the table.
using MaterialId = std::uint16_t;
inline constexpr MaterialId kVoidMaterial = 0;
/// Lower values are clamped to this one, so that the entries of one law always fit beside void.
inline constexpr int kLowestValue = -32767;

/// HalfLimits::yield of a material that yields only at its limits.
inline constexpr Fixed kWholeYield = 1 << 16;

/// One material's contribution to the links along each axis [fixed-point units].
struct HalfLimits {
    Fixed compress[3];
    Fixed stretch[3];
    Fixed shear[3];
    Fixed max_movement;
    bool fixed;
    Fixed yield;  ///< fraction of the limits beyond which strain remains [2⁻¹⁶]; 0: none remains
    friend bool operator==(const HalfLimits&, const HalfLimits&) = default;
};

/// Properties of a material, or of any of the materials in a brick, for solvers: flags.
enum MaterialTrait : std::uint8_t {
    kAsymmetric = 1,   ///< compress, stretch and shear differ along an axis
    kAnisotropic = 2,  ///< they differ between axes
    kFixedTrait = 4,   ///< never moves
};

/// The first number of a law that is outside of its range.
struct LawFault {
    int law = 0;       ///< index into the laws
    int value_hu = 0;  ///< value at which it occurs
    std::string text;  ///< field, expected, found
};

class MaterialTable {
  public:
    /// The numbers of the entries, as one array by material for each kind and link axis.
    struct Columns {
        std::array<std::vector<Fixed>, 3> compress, stretch, shear;
    };

    /// @param laws    variant 0 is the main law; others apply to selected elements
    /// @param others  materials that don't depend on a value (air)
    MaterialTable(const std::vector<MaterialLaw>& laws, const std::vector<ElementLimits>& others,
                  Vec3d spacing_mm);

    MaterialId id(int variant, int value_hu) const {
        const int clamped = value_hu < kLowestValue ? kLowestValue
                            : value_hu > 32767      ? 32767
                                                    : value_hu;
        return m_ids[std::size_t(variant)][std::size_t(clamped - kLowestValue)];
    }
    /// Material ids of one variant, by value − kLowestValue.
    const MaterialId* ids(int variant) const { return m_ids[std::size_t(variant)].data(); }
    MaterialId other_id(int other) const { return m_other_ids[std::size_t(other)]; }
    const HalfLimits& operator[](MaterialId id) const { return m_entries[id]; }
    int size() const { return int(m_entries.size()); }
    /// False if the laws give more than 65535 different limits: the table is then invalid.
    bool fits() const { return m_fits; }
    /// If there is one, the table is invalid.
    const std::optional<LawFault>& fault() const { return m_fault; }
    /// Entries from this index on belong to no law.
    int law_size() const { return m_law_size; }
    const Columns& columns() const { return m_columns; }
    /// Whether compress, stretch and shear are equal in every entry, axis by axis: a link's lag is
    /// then the same for every component and direction of a push.
    bool is_symmetric() const { return m_symmetric; }
    /// Flags of MaterialTrait, by material.
    const std::uint8_t* traits() const { return m_traits.data(); }
    /// Movement limits by material; INT32_MAX for bone and void, which have none.
    const Fixed* movements() const { return m_movements.data(); }

  private:
    class Builder;
    std::vector<HalfLimits> m_entries;
    Columns m_columns;
    std::vector<std::vector<MaterialId>> m_ids;  ///< by variant and value
    std::vector<std::uint8_t> m_traits;
    std::vector<Fixed> m_movements;
    std::vector<MaterialId> m_other_ids;
    int m_law_size = 0;
    std::optional<LawFault> m_fault;
    bool m_symmetric = true;
    bool m_fits = true;
};

}  // namespace pliant
