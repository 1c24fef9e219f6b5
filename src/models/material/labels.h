// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Materials by label. Each label material is one law, or three if its numbers follow a direction:
// one for each axis of the lattice to which the direction may be nearest. An element's law is
// looked up in the label volume and the direction field when its brick is created; untouched parts
// need no memory beyond these two.

#pragma once

#include <pliant/models/material.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "material/material.h"

namespace pliant {

/// @returns InvalidArgument if labels or directions are missing, or not on the scan's grid
Status check_labels(const ChainMailSettings& settings, const Grid& grid);

/// Laws of all label materials, one or three for each, by number on the scale.
std::vector<MaterialLaw> label_laws(const ChainMailSettings& settings, LookupScale scale);

/// Name of a law in messages. @param law  0: the main law; then those of label_laws
std::string law_name(const ChainMailSettings& settings, int law);

class LabelMap {
  public:
    LabelMap() = default;
    explicit LabelMap(const ChainMailSettings& settings);

    bool empty() const { return !m_labels; }
    /// Index into label_laws for an element; −1: none, or beyond the grid.
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

/// Axis of the lattice that is nearest to a direction [LPS]; i for a zero direction.
int dominant_axis(const Grid& grid, Vec3d direction);

}  // namespace pliant
