// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Comes before Boost's headers: they make their symbols visible, whatever the compiler is told, and
// a program with another version of Boost would share them.

#pragma once

#define BOOST_ASIO_DISABLE_VISIBILITY

#include <boost/config.hpp>

#undef BOOST_SYMBOL_VISIBLE
#define BOOST_SYMBOL_VISIBLE
