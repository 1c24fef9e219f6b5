// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Contents of the file of an identified mass-spring network (JSON, docs/method/fit.md), written by
// `pliant fit` and read by `pliant deform` and `pliant serve` (scene_files.h).

#pragma once

#include <pliant/models/springs.h>

#include <cstdint>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// An identified value, for readers; it is already contained in the links, cells and nodes.
struct NetworkGroup {
    std::string name;
    std::string unit;
    double value = 0;
    double low = 0, high = 0;  ///< 95 % confidence interval; both 0: unknown
    std::string note{};        ///< such as "not identifiable" or "at its upper bound"
};

/// Links, cells and nodes without a group have −1.
struct NetworkFile {
    std::string mesh{};  ///< name of the mesh's file
    SpringParts parts;   ///< mm (LPS), g, s; moduli in Pa
    std::vector<NetworkGroup> groups{};
    std::vector<std::int32_t> link_groups{}, cell_groups{}, node_groups{};  ///< empty: −1 for all
};

}  // namespace pliant
#pragma GCC visibility pop
