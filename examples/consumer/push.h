// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The example of README.md, in a file of its own so that it is compiled and run.

#pragma once

#include <pliant/chainmail.h>

pliant::Status push_wall(const char* scan_file, const char* deformed_file, pliant::Push push);
