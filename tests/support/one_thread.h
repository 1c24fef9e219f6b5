// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pliant/core/tasks.h>

namespace pliant::test {

inline const TaskArena& one_thread() {
    static const TaskArena arena(1);
    return arena;
}

}  // namespace pliant::test
