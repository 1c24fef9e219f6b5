// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The version of the library, for the preprocessor and for messages. CMake reads it from here.

#pragma once

#define PLIANT_VERSION_MAJOR 0
#define PLIANT_VERSION_MINOR 2
#define PLIANT_VERSION_PATCH 0
#define PLIANT_VERSION "0.2.0"
