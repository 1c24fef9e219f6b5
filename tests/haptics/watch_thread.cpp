// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// In place of the C library's functions, for the program and all libraries that it loads.

#include "watch_thread.h"

#include <dlfcn.h>
#include <pthread.h>

#include <cstddef>

namespace {
thread_local bool t_is_watched = false;
thread_local std::int64_t t_allocations = 0, t_locks = 0;
}  // namespace

namespace pliant::test {
void watch_this_thread() {
    t_is_watched = true;
}
std::int64_t allocations_of_this_thread() {
    return t_allocations;
}
std::int64_t locks_of_this_thread() {
    return t_locks;
}
}  // namespace pliant::test

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PLIANT_WATCHED_BY_SANITIZER
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PLIANT_WATCHED_BY_SANITIZER
#endif

#ifdef PLIANT_WATCHED_BY_SANITIZER
bool pliant::test::can_watch_threads() {
    return false;
}
#else
bool pliant::test::can_watch_threads() {
    return true;
}

extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t bytes) {
    if (t_is_watched) ++t_allocations;
    return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) {
    if (t_is_watched) ++t_allocations;
    return __libc_calloc(count, bytes);
}
void* realloc(void* memory, std::size_t bytes) {
    if (t_is_watched) ++t_allocations;
    return __libc_realloc(memory, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
    if (t_is_watched) ++t_allocations;
    return __libc_memalign(alignment, bytes);
}

#define PLIANT_WATCH(NAME, TYPE)                                \
    int NAME(TYPE* object) noexcept(noexcept(::NAME(object))) { \
        using Function = int (*)(TYPE*);                        \
        static Function real = nullptr;                         \
        if (!real) real = Function(dlsym(RTLD_NEXT, #NAME));    \
        if (t_is_watched) ++t_locks;                            \
        return real(object);                                    \
    }
PLIANT_WATCH(pthread_mutex_lock, pthread_mutex_t)
PLIANT_WATCH(pthread_mutex_trylock, pthread_mutex_t)
PLIANT_WATCH(pthread_rwlock_rdlock, pthread_rwlock_t)
PLIANT_WATCH(pthread_rwlock_wrlock, pthread_rwlock_t)
PLIANT_WATCH(pthread_spin_lock, pthread_spinlock_t)
PLIANT_WATCH(pthread_cond_signal, pthread_cond_t)
PLIANT_WATCH(pthread_cond_broadcast, pthread_cond_t)

}  // extern "C"
#endif
