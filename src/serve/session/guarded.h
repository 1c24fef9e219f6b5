// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Last line of defence of the server's threads: no exception ends the process.

#pragma once

#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <system_error>

namespace pliant::serve {

inline void print_fault(const char* thread, const char* what) noexcept {
    std::fprintf(stderr, "pliant: internal error in the server's %s thread: %.200s\n", thread,
                 what);
}

/// Runs work on a server thread. Lack of memory or threads is expected and handled by the caller.
/// Any other exception is a bug and printed in one line.
/// @param thread  name of the thread, for the line
/// @returns whether work ended without an exception
template <class Work>
bool guarded(const char* thread, const Work& work) noexcept {
    try {
        work();
        return true;
    } catch (const std::bad_alloc&) {
    } catch (const std::length_error&) {
    } catch (const std::system_error& error) {
        if (error.code() != std::errc::resource_unavailable_try_again)
            print_fault(thread, error.what());
    } catch (const std::exception& error) {
        print_fault(thread, error.what());
    }
    return false;
}

}  // namespace pliant::serve
