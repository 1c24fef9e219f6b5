// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "volume/voxel_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

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

/// A float is finite if the stored number is and doesn't overflow.
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

std::string counted(std::size_t count, const std::string& what) {
    return std::to_string(count) + (count == 1 ? " voxel " : " voxels ") + what;
}

}  // namespace

void VoxelBuilder::widen() {
    m_floats.reserve(m_count);
    m_floats.assign(m_shorts.begin(), m_shorts.end());
    m_shorts = {};
    m_wide = true;
}

template <class T>
void VoxelBuilder::add_values(const T* values, std::size_t count) {
    if (!m_wide) m_shorts.reserve(m_count);
    if constexpr (std::is_same_v<T, std::int16_t>) {
        if (m_wide)
            m_floats.insert(m_floats.end(), values, values + count);
        else
            m_shorts.insert(m_shorts.end(), values, values + count);
        return;
    }
    for (std::size_t n = 0; n < count; ++n) {
        const T value = values[n];
        const bool finite = is_finite_float(value);
        m_not_finite += std::size_t(!finite);
        if (!m_wide) {
            if (!finite || fits_16_bits(value)) {
                m_shorts.push_back(finite ? std::int16_t(value) : std::int16_t(kAirHu));
                continue;
            }
            widen();
        }
        if (finite) m_rounded += std::size_t(!is_exact_in_float(value));
        m_floats.push_back(finite ? float(value) : float(kAirHu));
    }
}

void VoxelBuilder::add(Component component, const void* values, std::size_t count) {
    switch (component) {
        case Component::Int8:
            return add_values(static_cast<const std::int8_t*>(values), count);
        case Component::UInt8:
            return add_values(static_cast<const std::uint8_t*>(values), count);
        case Component::Int16:
            return add_values(static_cast<const std::int16_t*>(values), count);
        case Component::UInt16:
            return add_values(static_cast<const std::uint16_t*>(values), count);
        case Component::Int32:
            return add_values(static_cast<const std::int32_t*>(values), count);
        case Component::UInt32:
            return add_values(static_cast<const std::uint32_t*>(values), count);
        case Component::Int64:
            return add_values(static_cast<const std::int64_t*>(values), count);
        case Component::UInt64:
            return add_values(static_cast<const std::uint64_t*>(values), count);
        case Component::Float32:
            return add_values(static_cast<const float*>(values), count);
        case Component::Float64:
            return add_values(static_cast<const double*>(values), count);
    }
}

Voxels VoxelBuilder::finish(std::vector<std::string>& notes) {
    if (m_not_finite) notes.push_back(counted(m_not_finite, "had no finite value and became air"));
    if (m_rounded) notes.push_back(counted(m_rounded, "rounded to 32-bit floats"));
    if (m_wide) return std::move(m_floats);
    return std::move(m_shorts);
}

}  // namespace pliant
