// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "material/material.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "base/hash.h"
#include "base/text.h"
#include "material/air.h"
#include "material/limit_units.h"

namespace pliant {

ResolvedSettings resolve(const ChainMailSettings& settings, const Volume& volume) {
    constexpr double kSteps = 4095, kLowest = -1000;
    ResolvedSettings resolved{settings, {}};
    ValueSpan& range = resolved.settings.range;
    if (const auto& percent = resolved.settings.range_percent; percent) {
        const auto values = percentiles(volume, std::array{percent->low, percent->high});
        // A constant scan is soft.
        range = {values[0], values[1] > values[0] ? values[1] : values[0] + 1};
        resolved.settings.range_percent.reset();
    }
    if (volume.is_16_bit() || settings.custom_law || range == ChainMailSettings{}.range)
        return resolved;
    const double per_value = kSteps / (range.high - range.low);
    resolved.scale = {per_value, kLowest - range.low * per_value};
    return resolved;
}

ElementLimits draeger_limits(const ChainMailSettings& s, double value) {
    // The thesis divides by 4096 in its text and keeps values up to 4095; with 4095 the hardest
    // value gets exactly zero slack.
    const double w = std::clamp((value - s.range.low) / (s.range.high - s.range.low), 0.0, 1.0);
    const double softness = 1 - w * w;
    const double region = s.offset * softness;
    const Vec3d regions{region * s.factor.x, region * s.factor.y, region * s.factor.z};
    return {.compress = regions,
            .stretch = regions,
            .shear = regions,
            .max_movement_mm = softness * s.max_movement_mm,
            .fixed = value > s.bone_threshold_hu,
            .yield = s.yield};
}

MaterialLaw law_on_scale(const ChainMailSettings& settings, LookupScale scale) {
    return
        [settings, scale](int number) { return draeger_limits(settings, scale.value_of(number)); };
}

MaterialLaw draeger_law(const ChainMailSettings& settings) {
    return law_on_scale(settings, {});
}

namespace {

HalfLimits quantised(const ElementLimits& limits, Vec3d spacing_mm) {
    HalfLimits half{};
    for (int b = 0; b < 3; ++b) {
        half.compress[b] = limit_units_from_mm(spacing_mm[b] * limits.compress[b] / 2);
        half.stretch[b] = limit_units_from_mm(spacing_mm[b] * limits.stretch[b] / 2);
        half.shear[b] = limit_units_from_mm(spacing_mm[b] * limits.shear[b] / 2);
    }
    half.max_movement =
        Fixed(std::floor(std::min(limits.max_movement_mm, kMaxMovementMm) * kUnitsPerMm));
    half.fixed = limits.fixed;
    half.yield = Fixed(std::lround(std::clamp(limits.yield, 0.0, 1.0) * kWholeYield));
    return half;
}

HalfLimits void_limits() {
    constexpr Fixed far = kMaxHalfLimit;
    return {{far, far, far}, {far, far, far}, {far, far, far}, 0, false, 0};
}

std::uint8_t traits_of(const HalfLimits& half) {
    std::uint8_t traits = half.fixed ? kFixedTrait : 0;
    for (int b = 0; b < 3; ++b) {
        if (half.compress[b] != half.shear[b] || half.stretch[b] != half.shear[b])
            traits |= kAsymmetric;
        if (half.compress[b] != half.compress[0] || half.stretch[b] != half.stretch[0] ||
            half.shear[b] != half.shear[0])
            traits |= kAnisotropic;
    }
    return traits;
}

struct HashLimits {
    std::size_t operator()(const HalfLimits& half) const {
        Hash64 hash;
        for (int b = 0; b < 3; ++b)
            for (const Fixed word : {half.compress[b], half.stretch[b], half.shear[b]})
                hash.add_word(std::uint32_t(word));
        hash.add_word(std::uint32_t(half.max_movement) * 2 + half.fixed);
        hash.add_word(std::uint32_t(half.yield));
        return std::size_t(hash.value());
    }
};

bool operator==(const ElementLimits& a, const ElementLimits& b) {
    return a.compress == b.compress && a.stretch == b.stretch && a.shear == b.shear &&
           a.max_movement_mm == b.max_movement_mm && a.fixed == b.fixed && a.yield == b.yield;
}

}  // namespace

/// Empty if all numbers are within the ranges of ElementLimits.
std::string fault_of(const ElementLimits& limits) {
    const auto wrong = [](const std::string& field, const char* expected, double found) {
        return field + ": expected " + expected + ", found " + text_of(found);
    };
    for (int b = 0; b < 3; ++b) {
        const std::string axis = std::string(".") + "xyz"[b];
        // Above 1 a link could invert.
        if (!(limits.compress[b] >= 0 && limits.compress[b] <= 1))
            return wrong("compress" + axis, "a fraction 0 to 1", limits.compress[b]);
        if (!(limits.stretch[b] >= 0))
            return wrong("stretch" + axis, "a fraction of 0 or more", limits.stretch[b]);
        if (!(limits.shear[b] >= 0))
            return wrong("shear" + axis, "a fraction of 0 or more", limits.shear[b]);
    }
    if (!(limits.max_movement_mm >= 0))
        return wrong("max_movement_mm", "0 or more", limits.max_movement_mm);
    if (!(limits.yield >= 0 && limits.yield <= 1))
        return wrong("yield", "a fraction 0 to 1", limits.yield);
    return {};
}

/// Finds entries by their limits.
class MaterialTable::Builder {
  public:
    Builder(std::vector<HalfLimits>& entries, Vec3d spacing_mm)
        : m_entries(entries), m_spacing_mm(spacing_mm) {}

    /// @returns void, with a fault(), for limits outside of their ranges
    MaterialId add(const ElementLimits& limits) {
        // Neighbouring values often have the same limits: no look-up is needed then.
        if (m_any && limits == m_last) return m_last_id;
        m_fault = fault_of(limits);
        if (!m_fault.empty()) return kVoidMaterial;
        const HalfLimits half = quantised(limits, m_spacing_mm);
        const auto [entry, is_new] = m_known.try_emplace(half, MaterialId(m_entries.size()));
        if (is_new) m_entries.push_back(half);
        m_any = true;
        m_last = limits;
        return m_last_id = entry->second;
    }
    const std::string& fault() const { return m_fault; }

  private:
    std::vector<HalfLimits>& m_entries;
    Vec3d m_spacing_mm;
    std::unordered_map<HalfLimits, MaterialId, HashLimits> m_known;
    bool m_any = false;
    ElementLimits m_last;
    MaterialId m_last_id = 0;
    std::string m_fault;
};

MaterialTable::MaterialTable(const std::vector<MaterialLaw>& laws,
                             const std::vector<ElementLimits>& others, Vec3d spacing_mm)
    : m_entries{void_limits()} {
    constexpr std::size_t kMaxEntries = 65536;
    Builder builder(m_entries, spacing_mm);
    for (const MaterialLaw& law : laws) {
        std::vector<MaterialId>& ids = m_ids.emplace_back(32768 - kLowestValue);
        for (std::size_t n = 0; n < ids.size() && m_entries.size() <= kMaxEntries; ++n) {
            const int value_hu = int(n) + kLowestValue;
            ids[n] = builder.add(law(value_hu));
            if (!builder.fault().empty()) {
                m_fault = {int(m_ids.size()) - 1, value_hu, builder.fault()};
                return;
            }
        }
    }
    m_law_size = int(m_entries.size());
    for (const ElementLimits& limits : others) m_other_ids.push_back(builder.add(limits));
    m_fits = m_entries.size() <= kMaxEntries;
    for (const HalfLimits& half : m_entries) {
        m_traits.push_back(traits_of(half));
        const bool moves = !half.fixed && &half != &m_entries[kVoidMaterial];
        m_movements.push_back(moves ? half.max_movement : INT32_MAX);
        for (std::size_t b = 0; b < 3; ++b) {
            m_columns.compress[b].push_back(half.compress[b]);
            m_columns.stretch[b].push_back(half.stretch[b]);
            m_columns.shear[b].push_back(half.shear[b]);
            m_symmetric &= half.compress[b] == half.shear[b] && half.stretch[b] == half.shear[b];
        }
    }
}

std::array<ElementLimits, 8> air_limits(const ChainMailSettings& settings) {
    const ElementLimits soft = draeger_limits(settings, settings.range.low);
    std::array<ElementLimits, 8> limits;
    for (unsigned axes = 0; axes < 8; ++axes) {
        ElementLimits& air = limits[axes];
        air.max_movement_mm = kMaxMovementMm;
        for (int b = 0; b < 3; ++b) {
            const bool is_skin = axes >> b & 1;
            air.compress[b] = settings.air_compress;
            air.stretch[b] = is_skin ? soft.stretch[b] : settings.air_stretch;
            air.shear[b] = is_skin ? soft.shear[b] : settings.air_shear;
        }
    }
    return limits;
}

}  // namespace pliant
