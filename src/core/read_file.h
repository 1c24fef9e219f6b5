// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Memory for parsers of small files that end the process where there is none.

#pragma once

#include <pliant/text_input.h>

#include <cstddef>
#include <new>

namespace pliant {

/// toml::parse ends the process where memory runs out: seeing that there is enough of it before
/// leaves that to other threads, and to very unusual files. Tables take up to seventy bytes for
/// each of its own. Throws std::bad_alloc.
inline void get_memory_for_tables(std::size_t bytes) {
    constexpr std::size_t kPerByte = 100, kAtLeast = std::size_t(1) << 20;
    ::operator delete(::operator new(kAtLeast + kPerByte * bytes));
}

}  // namespace pliant
