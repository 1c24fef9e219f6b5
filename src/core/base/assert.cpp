// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/result.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace pliant {
namespace {

void print_and_abort(const char* expression, const char* file, int line) {
    std::fprintf(stderr, "%s:%d: assertion failed: %s\n", file, line, expression);
    std::abort();
}

std::atomic<AssertHandler> g_handler{&print_and_abort};

}  // namespace

AssertHandler set_assert_handler(AssertHandler handler) {
    return g_handler.exchange(handler);
}

void assert_failed(const char* expression, const char* file, int line) {
    g_handler.load()(expression, file, line);
}

}  // namespace pliant
