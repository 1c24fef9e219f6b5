// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Numbers as text, independent of the locale.

#pragma once

#include <string>

#pragma GCC visibility push(default)
namespace pliant {

/// Shortest text that round-trips.
std::string text_of(double number);
/// Text with at most this many significant digits, as printf's %g writes it.
std::string short_text(double number, int digits = 6);
/// Text with a fixed number of decimals, as printf's %f writes it; scientific beyond 64 characters.
std::string fixed_text(double number, int decimals);

}  // namespace pliant
#pragma GCC visibility pop
