// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The file of an identified mass-spring network (JSON, docs/method/fit.md), written by `pliant fit`
// and read by `pliant deform` and `pliant serve`.
//
// @code
//   const auto network = read_network("fit.json");
//   if (!network) std::puts(network.error().message.c_str());   // one line
//   auto tissue = make_network(scan, network->parts, {}, arena);
// @endcode

#pragma once

#include <pliant/result.h>
#include <pliant/springs.h>

#include <cstdint>
#include <filesystem>
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

/// A larger file is refused.
inline constexpr std::size_t kMaxNetworkBytes = std::size_t(64) << 20;

/// Reads a network. Rest lengths are set, and SpringNetwork::create accepts the parts.
/// @returns NotFound, Unreadable or Unsupported (another version) with one line that names the file
///          and the fault
Result<NetworkFile> read_network(const std::filesystem::path& path) noexcept;

/// Writes a network. Atomic.
/// @returns InvalidArgument for lists of the wrong length or a network that read_network refuses,
///          Unwritable
Status write_network(const std::filesystem::path& path, const NetworkFile& network) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
