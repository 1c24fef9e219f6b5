// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scenes from files: vessels with catheters, and identified networks of springs.
//
// @code
//   auto file = read_vessel_file("aorta.toml");
//   auto made = make_vessel(*file, arena);
//   auto scene = CatheterScene::create(std::move(made->wall), made->settings);
// @endcode
//
// @code
//   const auto network = read_network("fit.json");
//   if (!network) std::puts(network.error().message.c_str());   // one line
//   auto tissue = make_network(scan, network->parts, {}, arena);
// @endcode

#pragma once

#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/models/catheter.h>
#include <pliant/models/network_file.h>
#include <pliant/models/vessel.h>
#include <pliant/result.h>
#include <pliant/volume.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct MadeVessel {
    VesselWall wall;
    /// Path [mm, LPS]. In a wall's mesh without one, it leads from the entry to the farthest other
    /// end. May be empty.
    std::vector<Vec3d> way;
    std::optional<Volume> scan;  ///< the scan that the file names
    CatheterSettings settings;   ///< including the entry
    bool has_own_ghost = false;  ///< the wall's inner surface is that of a file
};
/// Centreline of a synthetic vessel: "bend" and "arch" are tubes, "aorta" a tree whose first branch
/// leads from the descending aorta, where catheters enter, to the ascending one; then follow the
/// left subclavian, the left carotid, the brachiocephalic, the right subclavian and the right
/// carotid artery.
/// @returns InvalidArgument for another name
Result<Centreline> phantom_centreline(const std::string& name) noexcept;

/// @returns one line with the faulty file
Result<MadeVessel> make_vessel(const VesselFile& file, const TaskArena& arena) noexcept;

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
