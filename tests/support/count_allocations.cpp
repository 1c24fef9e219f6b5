// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// In a file of its own: where the compiler sees through both operators, it takes malloc's memory
// for new's.

#include "support/count_allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::int64_t> g_allocations = 0;
std::atomic<std::int64_t> g_until_failure = -1;  // below 0: none fails
std::atomic<bool> g_has_failed = false;
std::atomic<std::size_t> g_fewest_bytes = 0;

/// Counts a call. @returns whether it has to fail
bool fails(std::size_t bytes) {
    ++g_allocations;
    if (bytes < g_fewest_bytes) return false;
    if (g_has_failed) return true;
    if (g_until_failure < 0 || g_until_failure-- > 0) return false;
    g_has_failed = true;
    return true;
}
}  // namespace

void* operator new(std::size_t bytes) {
    if (fails(bytes)) throw std::bad_alloc();
    if (void* memory = std::malloc(bytes ? bytes : 1)) return memory;
    throw std::bad_alloc();
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    if (fails(bytes)) throw std::bad_alloc();
    const auto line = std::size_t(alignment);
    if (void* memory = std::aligned_alloc(line, (bytes + line - 1) / line * line)) return memory;
    throw std::bad_alloc();
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {  // of std::stable_sort
    if (fails(bytes)) return nullptr;
    return std::malloc(bytes ? bytes : 1);
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    std::free(memory);
}

std::int64_t pliant::test::allocation_count() {
    return g_allocations;
}

namespace pliant::test {

FailingAllocation::FailingAllocation(std::int64_t n, std::size_t fewest_bytes) {
    g_fewest_bytes = fewest_bytes;
    g_until_failure = n;
}

FailingAllocation::~FailingAllocation() {
    g_until_failure = -1;
    g_has_failed = false;
    g_fewest_bytes = 0;
}

bool FailingAllocation::has_failed() const {
    return g_has_failed;
}

}  // namespace pliant::test
