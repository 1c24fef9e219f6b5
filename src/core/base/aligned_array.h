// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Cache-line-aligned vectors.

#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace pliant {

template <class T>
struct CacheLineAllocator {
    using value_type = T;
    CacheLineAllocator() = default;
    template <class U>
    CacheLineAllocator(const CacheLineAllocator<U>&) {}
    T* allocate(std::size_t count) {
        return static_cast<T*>(::operator new(count * sizeof(T), std::align_val_t(64)));
    }
    void deallocate(T* memory, std::size_t) { ::operator delete(memory, std::align_val_t(64)); }
    friend bool operator==(CacheLineAllocator, CacheLineAllocator) { return true; }
};

template <class T>
using AlignedVector = std::vector<T, CacheLineAllocator<T>>;
using AlignedArray = AlignedVector<double>;

}  // namespace pliant
