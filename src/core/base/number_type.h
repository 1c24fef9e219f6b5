// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Types of the numbers in files.

#pragma once

#include <cstddef>
#include <cstdint>

namespace pliant {

enum class NumberType {
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Float32,
    Float64
};

constexpr std::size_t size_of(NumberType type) {
    constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return kSizes[std::size_t(type)];
}

/// Returns act(T()) for the C++ type T.
template <class Act>
auto with_type(NumberType type, const Act& act) {
    switch (type) {
        case NumberType::Int8:
            return act(std::int8_t());
        case NumberType::UInt8:
            return act(std::uint8_t());
        case NumberType::Int16:
            return act(std::int16_t());
        case NumberType::UInt16:
            return act(std::uint16_t());
        case NumberType::Int32:
            return act(std::int32_t());
        case NumberType::UInt32:
            return act(std::uint32_t());
        case NumberType::Int64:
            return act(std::int64_t());
        case NumberType::UInt64:
            return act(std::uint64_t());
        case NumberType::Float32:
            return act(float());
        case NumberType::Float64:
            break;
    }
    return act(double());
}

}  // namespace pliant
