// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "material/labels.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include "base/errors.h"
#include "base/text.h"
#include "volume/same_grid.h"

namespace pliant {
namespace {

Status check_grid(const std::string& name, const Grid& found, const Grid& expected) {
    if (found.size != expected.size)
        return expected_error(name, "the scan's grid, " + text_of_size(expected.size) + " voxels",
                              text_of_size(found.size));
    if (is_same_grid(found, expected)) return Ok{};
    return expected_error(name, "the scan's grid",
                          "one of the same size whose origin, spacing or direction differs (" +
                              std::to_string(corner_distance(found, expected)) +
                              " voxels at a corner)");
}

/// A value that no label material has.
constexpr int kNoLabel = -32769;

int whole_label(const Volume& labels, Vec3i ijk) {
    const float value = labels.at(ijk);
    return value >= -32768 && value <= 65535 ? int(std::lround(value)) : kNoLabel;
}

ElementLimits permuted(ElementLimits limits, int axis) {
    for (Vec3d* v : {&limits.compress, &limits.stretch, &limits.shear}) {
        const Vec3d given = *v;
        for (int n = 0; n < 3; ++n) (*v)[(axis + n) % 3] = given[n];
    }
    return limits;
}

MaterialLaw law_of(const LabelMaterial& material, const ChainMailSettings& settings,
                   LookupScale scale) {
    const double max_movement_mm = material.max_movement_mm.value_or(settings.max_movement_mm);
    ChainMailSettings own = settings;
    own.offset = material.offset.value_or(settings.offset);
    own.bone_threshold_hu = material.bone_threshold_hu.value_or(settings.bone_threshold_hu);
    own.max_movement_mm = max_movement_mm;
    own.yield = material.yield.value_or(settings.yield);
    own.factor = {1, 1, 1};
    MaterialLaw by_value = settings.custom_law ? settings.custom_law : law_on_scale(own, scale);
    return [=](int value_hu) {
        ElementLimits limits;
        if (material.law == LabelLaw::Immobile) {
            limits.fixed = true;
            return limits;
        }
        if (material.law == LabelLaw::ByValue)
            limits = by_value(value_hu);
        else
            limits = {.compress = material.compress,
                      .stretch = material.stretch,
                      .shear = material.shear,
                      .max_movement_mm = max_movement_mm,
                      .yield = own.yield};
        if (material.yield) limits.yield = *material.yield;
        for (Vec3d* v : {&limits.compress, &limits.stretch, &limits.shear})
            for (int b = 0; b < 3; ++b) (*v)[b] *= material.factor[b];
        return limits;
    };
}

}  // namespace

Status check_labels(const ChainMailSettings& settings, const Grid& grid) {
    if (settings.label_materials.empty()) return Ok{};
    if (!settings.labels)
        return about("labels", ErrorCode::InvalidArgument,
                     "expected a label volume for [[label]], found none");
    if (Status s = check_volume(*settings.labels, "labels"); !s.ok()) return s;
    if (Status s = check_grid("labels", settings.labels->grid, grid); !s.ok()) return s;
    const auto& materials = settings.label_materials;
    const bool directed = std::any_of(materials.begin(), materials.end(),
                                      [](const auto& m) { return m.along_direction; });
    if (!directed) return Ok{};
    if (!settings.directions)
        return about("directions", ErrorCode::InvalidArgument,
                     "expected a vector field for [[label]] frame = \"direction\", "
                     "found none");
    if (Status s = check_grid("directions", settings.directions->grid, grid); !s.ok()) return s;
    return check_field(*settings.directions, "directions");
}

std::vector<MaterialLaw> label_laws(const ChainMailSettings& settings, LookupScale scale) {
    std::vector<MaterialLaw> laws;
    for (const LabelMaterial& material : settings.label_materials) {
        const MaterialLaw law = law_of(material, settings, scale);
        for (int axis = 0; axis < (material.along_direction ? 3 : 1); ++axis)
            laws.push_back([law, axis](int value_hu) { return permuted(law(value_hu), axis); });
    }
    return laws;
}

std::string law_name(const ChainMailSettings& settings, int law) {
    if (law == 0) return settings.custom_law ? "custom_law" : "[material]";
    std::size_t n = 0;
    for (int first = 1; n + 1 < settings.label_materials.size(); ++n) {
        first += settings.label_materials[n].along_direction ? 3 : 1;
        if (law < first) break;
    }
    return "[[label]] " + std::to_string(n + 1);
}

LabelMap::LabelMap(const ChainMailSettings& settings) {
    if (settings.label_materials.empty()) return;
    m_labels = settings.labels;
    m_directions = settings.directions;
    std::set<int> values;
    for (const LabelMaterial& material : settings.label_materials)
        values.insert(material.values.begin(), material.values.end());
    if (values.empty()) return;
    m_lowest = *values.begin();
    m_entries.resize(std::size_t(*values.rbegin() - m_lowest) + 1);
    std::int32_t law = 0;
    for (const LabelMaterial& material : settings.label_materials) {
        for (const int value : material.values)
            m_entries[std::size_t(value - m_lowest)] = {law, material.along_direction};
        law += material.along_direction ? 3 : 1;
    }
}

int LabelMap::law_at(Vec3i ijk) const {
    if (!m_labels || !contains(voxel_box(m_labels->grid), ijk)) return -1;
    const auto n = std::int64_t(whole_label(*m_labels, ijk)) - m_lowest;
    if (n < 0 || n >= std::int64_t(m_entries.size())) return -1;
    const Entry& entry = m_entries[std::size_t(n)];
    if (!entry.along_direction) return entry.law;
    const Grid& grid = m_directions->grid;
    const Vec3f d = m_directions->vectors_mm[voxel_index(grid, ijk)];
    return entry.law + dominant_axis(m_labels->grid, {d.x, d.y, d.z});
}

int dominant_axis(const Grid& grid, Vec3d direction) {
    int axis = 0;
    double largest = 0;
    for (int a = 0; a < 3; ++a) {
        // The component along the axis itself: axes need not be orthogonal.
        const double along = std::abs(dot(grid.direction.columns[a], direction));
        if (!(along > largest)) continue;
        largest = along;
        axis = a;
    }
    return axis;
}

}  // namespace pliant
