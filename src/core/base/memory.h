// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Large blocks of uninitialised memory with a given alignment. They come from operator new, so that
// a program that replaces it sees all allocations of the library.

#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace pliant {

struct FreeAligned {
    std::size_t alignment = 0;
    void operator()(void* memory) const noexcept {
        ::operator delete(memory, std::align_val_t(alignment));
    }
};

template <class T>
using AlignedMemory = std::unique_ptr<T, FreeAligned>;

/// Allocates uninitialised memory for trivial objects. Throws std::bad_alloc.
/// @param alignment  [bytes] a power of two
template <class T>
AlignedMemory<T> allocate_aligned(std::size_t bytes, std::size_t alignment) {
    return AlignedMemory<T>(static_cast<T*>(::operator new(bytes, std::align_val_t(alignment))),
                            {alignment});
}

}  // namespace pliant
