// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "options.h"

namespace pliant::app {

int run_phantom(const PhantomOptions&) {
    return bad_input("phantom: not built yet");
}

}  // namespace pliant::app
