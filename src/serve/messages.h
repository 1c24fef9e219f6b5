// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What the server says in text (docs/protocol.md): plain values, and their JSON.

#pragma once

#include <pliant/catheter.h>
#include <pliant/chainmail.h>
#include <pliant/lumen_path.h>
#include <pliant/phantom.h>
#include <pliant/render.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "serve/tissue_choice.h"

namespace pliant::serve {

/// The scan, for a client that sees it for the first time.
struct VolumeInfo {
    std::uint32_t id = 1;
    std::string name{};
    Grid grid{};
    double lowest_hu = 0, highest_hu = 0;
    std::optional<Endoscope> start{};
    std::vector<PhantomLandmark> landmarks{};
};

struct ClientInfo {
    std::uint32_t number = 0;
    std::string name{};
    bool view = false;
};

/// Of a catheter in its vessel.
struct VesselState {
    CatheterCommand hand{};
    CatheterMeasures measures{};  ///< quick ones, and inverted tetrahedra
    double wall_moved_mm = 0;     ///< of the wall's nodes, the farthest
    double radius_mm = 0, length_mm = 0;
    std::string failure{};  ///< why it has stopped until it is reset; else empty
};

/// Everything shared that is not voxels.
struct SharedState {
    TissueChoice tissue{};
    bool has_vessel = false;  ///< so that the tissue may be chosen to be it
    std::optional<VesselState> vessel{};
    double pace = 0;              ///< simulated over real time when it last moved; 0: not known yet
    Vec3i spring_nodes{0, 0, 0};  ///< along i, j, k
    std::int32_t active_nodes = 0;  ///< that forces reached last
    double update_hz = 0;           ///< how often nodes were updated when they last moved
    std::uint32_t step = 0;
    double iso_hu = -500;
    Polarity polarity = Polarity::Rising;
    ChainMailSettings materials{};
    bool relaxing = false, settled = true;
    std::uint32_t holder = 0;  ///< client whose grab holds tissue; 0: none
    int undo_steps = 0, redo_steps = 0;
    std::string next_undo{}, next_redo{};
    std::vector<ClientInfo> clients{};
    bool recorded = true;  ///< the session's file has all commands
    double solve_ms = 0, resample_ms = 0, tick_ms = 0;
    double overlay_ms = 0;  ///< that overlays took when they were last sent; not part of tick_ms
    std::int64_t moved_elements = 0;
};

/// What became of a command.
struct Outcome {
    std::string error_code{};  ///< empty: done; else why it was refused
    std::string message{};     ///< for the user; may be empty
    std::optional<PushStatus> status{};
    LimitedBy limited_by = LimitedBy::None;
    double step_fraction = 0;  ///< where there is a status
    std::optional<std::int64_t> grabbed_elements{}, moved_elements{}, cut_links{},
        carved_elements{};
    double solve_ms = 0;
    std::optional<Vec3d> force{};
    std::optional<Vec3d> end_mm{};  ///< of a slide: where the sphere's centre is, out of tissue
    bool ran_out = false;           ///< refused because memory ran out, or by a fault
    bool ended_step = false;        ///< likewise; its only effect was Scene::interrupt()

    bool ok() const { return error_code.empty(); }
};

/// What a tool feels by how much its last motion changed the tissue's energy.
struct FeltForce {
    std::uint32_t client = 0;
    Vec3d force;
};

struct Welcome {
    ClientInfo client{};
    std::string resume{};
    bool resumed = false;
    int rate_hz = 60;
    std::uint64_t open_bytes = 0;  ///< that a scan may have which is opened
    int spring_nodes = 32;         ///< along an axis, that a client may ask for
    std::vector<std::string> haptic_devices{};
};

struct Checksums {
    std::uint32_t step = 0;
    std::uint32_t voxels = 0;              ///< MurmurHash3 of the half floats
    std::uint64_t volume = 0, tissue = 0;  ///< hash_volume, ChainMail::hash
};

std::string welcome_text(const Welcome& welcome, const VolumeInfo& volume,
                         const SharedState& state);
/// Another scan was opened.
std::string volume_text(const VolumeInfo& volume);
std::string state_text(const SharedState& state);
/// `done` or `error`. @param step  in which its effect is part of the voxels
std::string outcome_text(std::uint32_t id, std::string_view name, std::uint32_t step,
                         const Outcome& outcome);
std::string checksum_text(std::uint32_t id, const Checksums& sums);
std::string path_text(std::uint32_t id, std::uint32_t step, std::uint32_t volume,
                      const LumenPath& path);
std::string pong_text(std::uint32_t id);
std::string bye_text(int code, const std::string& message);
std::string hex_text(std::uint64_t number, int digits);

}  // namespace pliant::serve
