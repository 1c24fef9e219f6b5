// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Materials by label: each label material is one law, or three where its numbers follow a
// direction: one for each axis of the lattice that the direction may be nearest to. Which one an
// element takes is looked up in the label volume and the direction field when a brick comes into
// being; untouched parts cost nothing beside these two.

#pragma once

#include <pliant/chainmail.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace pliant {

/// @returns InvalidArgument if labels or directions are missing, or not on the scan's grid
Status check_labels(const ChainMailSettings& settings, const Grid& grid);

/// The laws of all label materials, one or three for each.
std::vector<MaterialLaw> label_laws(const ChainMailSettings& settings);

/// For messages. @param law  0: the main law; then those of label_laws
std::string law_name(const ChainMailSettings& settings, int law);

class LabelMap {
  public:
    LabelMap() = default;
    explicit LabelMap(const ChainMailSettings& settings);

    bool empty() const { return !m_labels; }
    /// Which of label_laws an element follows; −1: none, or beyond the grid.
    int law_at(Vec3i ijk) const;

  private:
    struct Entry {
        std::int32_t law = -1;
        bool along_direction = false;
    };
    std::shared_ptr<const Volume> m_labels;
    std::shared_ptr<const VectorField> m_directions;
    int m_lowest = 0;
    std::vector<Entry> m_entries;  ///< by label value − m_lowest
};

/// The axis of the lattice that is nearest to a direction [LPS]; i where there is none.
int dominant_axis(const Grid& grid, Vec3d direction);

}  // namespace pliant
