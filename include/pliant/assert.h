// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// PLIANT_ASSERT reports programming errors only. It is active in Debug and sanitizer builds. Bad
// data is never asserted: it becomes an Error. The handler is replaceable; the default one prints
// and aborts.

#pragma once

#pragma GCC visibility push(default)
namespace pliant {

using AssertHandler = void (*)(const char* expression, const char* file, int line);

/// Replaces the handler. @returns the previous one
AssertHandler set_assert_handler(AssertHandler handler);
void assert_failed(const char* expression, const char* file, int line);

}  // namespace pliant
#pragma GCC visibility pop

#ifdef PLIANT_ASSERTIONS
#define PLIANT_ASSERT(expression) \
    ((expression) ? void(0) : ::pliant::assert_failed(#expression, __FILE__, __LINE__))
#else
#define PLIANT_ASSERT(expression) void(sizeof(!(expression)))
#endif
