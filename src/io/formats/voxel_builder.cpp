// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/voxel_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>

#include "base/memory_budget.h"

namespace pliant {
namespace {

template <class T>
bool fits_16_bits(T value) {
    if constexpr (std::is_floating_point_v<T>) {
        return value >= T(-32768) && value <= T(32767) && value == std::trunc(value);
    } else if constexpr (std::is_signed_v<T>) {
        return std::int64_t(value) >= -32768 && std::int64_t(value) <= 32767;
    } else {
        return std::uint64_t(value) <= 32767;
    }
}

/// Whether the stored number converts to a finite float.
template <class T>
bool is_finite_float(T value) {
    if constexpr (std::is_same_v<T, double>)
        return std::abs(value) <= double(std::numeric_limits<float>::max());
    else if constexpr (std::is_same_v<T, float>)
        return std::isfinite(value);
    else
        return true;
}

template <class T>
bool is_exact_in_float(T value) {
    if constexpr (std::is_same_v<T, float> || sizeof(T) < sizeof(float)) return true;
    using Exact = std::conditional_t<std::is_same_v<T, double>, double, long double>;
    return Exact(float(value)) == Exact(value);
}

std::string counted_voxels(std::size_t count, const std::string& what) {
    return std::to_string(count) + (count == 1 ? " voxel " : " voxels ") + what;
}

void note_not_finite(std::size_t count, std::vector<std::string>& notes) {
    if (count) notes.push_back(counted_voxels(count, "had no finite value and became air"));
}

}  // namespace

void VoxelBuilder::widen() {
    if (!has_memory_for(m_count * sizeof(float))) throw std::bad_alloc();
    m_floats = VoxelArray<float>(m_count);
    std::copy_n(m_shorts.data(), m_added, m_floats.data());
    m_shorts = {};
    m_wide = true;
}

template <class T>
void VoxelBuilder::add_values(const T* values, std::size_t count) {
    PLIANT_ASSERT(count <= m_count - m_added);
    std::size_t n = 0;
    // Only one of the two arrays exists.
    if (std::int16_t* out = m_wide ? nullptr : m_shorts.data() + m_added) {
        for (; n < count; ++n) {
            const bool finite = is_finite_float(values[n]);
            if (finite && !fits_16_bits(values[n])) {
                m_added += n;
                widen();
                m_added -= n;
                break;
            }
            m_not_finite += std::size_t(!finite);
            out[n] = finite ? std::int16_t(values[n]) : std::int16_t(kAirHu);
        }
    }
    if (float* out = m_wide ? m_floats.data() + m_added : nullptr) {
        for (; n < count; ++n) {
            const bool finite = is_finite_float(values[n]);
            m_not_finite += std::size_t(!finite);
            m_rounded += std::size_t(finite && !is_exact_in_float(values[n]));
            out[n] = finite ? float(values[n]) : float(kAirHu);
        }
    }
    m_added += count;
}

void VoxelBuilder::add(Component component, const void* values, std::size_t count) {
    with_type(component, [&]<class T>(T) { add_values(static_cast<const T*>(values), count); });
}

Voxels VoxelBuilder::finish(std::vector<std::string>& notes) {
    note_not_finite(m_not_finite, notes);
    if (m_rounded) notes.push_back(counted_voxels(m_rounded, "rounded to 32-bit floats"));
    m_shorts.freeze();
    m_floats.freeze();
    if (m_wide) return std::move(m_floats);
    return std::move(m_shorts);
}

bool stay_floats(const VoxelArray<float>& values) {
    for (const float value : values)
        if (std::isfinite(value) && !fits_16_bits(value)) return true;
    return false;
}

void make_finite(VoxelArray<float>& values, std::vector<std::string>& notes) {
    std::size_t at = 0, count = 0;
    std::as_const(values).for_each_piece([&](std::span<const float> piece) {
        for (const float value : piece) {
            if (!std::isfinite(value)) {
                values[at] = float(kAirHu);
                ++count;
            }
            ++at;
        }
    });
    note_not_finite(count, notes);
}

}  // namespace pliant
