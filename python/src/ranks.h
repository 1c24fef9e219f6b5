// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// An MPI communicator of Python as the library's Ranks.

#pragma once

#include <pliant/models/ranks.h>

#include <memory>

#include "arrays.h"

namespace pliant::python {

/// @param comm  a communicator of mpi4py: Get_rank, Get_size, Send, Recv, Sendrecv, Allgatherv
/// @returns raises for other objects. Its functions take the interpreter's lock by themselves
std::unique_ptr<Ranks> ranks_of(const nb::object& comm);

}  // namespace pliant::python
