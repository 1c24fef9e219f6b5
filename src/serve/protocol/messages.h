// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Text messages of the server (docs/developers/protocol.md): plain values, and their JSON.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/data/scan_values.h>
#include <pliant/models/catheter.h>
#include <pliant/render.h>
#include <pliant/volume.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/tissue_choice.h"

namespace pliant {
struct DicomSeries;
}

namespace pliant::serve {

struct CameraMessage;

/// Description of the scan for a new client.
struct VolumeInfo {
    std::uint32_t id = 1;
    std::string name{};
    Grid grid{};
    double lowest_hu = 0, highest_hu = 0;
    ValueDefaults values{};  ///< kind of the scan's values, and defaults for them
    std::optional<Endoscope> start{};
    bool starts_outside = false;      ///< the whole is shown first, not the view at start
    std::optional<double> tool_mm{};  ///< radius of tools that suits the mesh of organs
    std::vector<PhantomLandmark> landmarks{};
};

struct ClientInfo {
    std::uint32_t number = 0;
    std::string name{};
    bool view = false;
};

/// State of a catheter that is driven in the tissue.
struct VesselState {
    CatheterCommand hand{};
    CatheterMeasures measures{};  ///< including those of CatheterView
    double radius_mm = 0, length_mm = 0;
    std::string failure{};  ///< reason why it has stopped until a reset; empty: none
};

/// Shared state except voxels.
struct SharedState {
    TissueChoice tissue{};
    ElasticScanSettings elastic{};          ///< those in use; of the elastic scan only
    std::vector<std::string> own_models{};  ///< that only this scene has: "vessel", "own"
    TissueTraits traits{};
    std::optional<VesselState> vessel{};
    double pace = 0;        ///< simulated time per real time at the last motion; 0: unknown
    Record figures{};       ///< of the tissue, by name
    std::string trouble{};  ///< reason why the tissue was stopped; empty: none
    double update_hz = 0;   ///< rate of node updates at the last motion
    double line_mb_s = 0;  ///< rate of the line that limits an automatic depth [MB/s]; 0: none does
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
    double overlay_ms = 0;  ///< time of the last overlays; not part of tick_ms
    std::int64_t moved_elements = 0;
};

/// Result of a command.
struct Outcome {
    std::string error_code{};  ///< empty: done; otherwise the reason of the refusal
    std::string message{};     ///< for the user; may be empty
    std::optional<PushStatus> status{};
    LimitedBy limited_by = LimitedBy::None;
    double step_fraction = 0;  ///< valid with a status
    std::optional<std::int64_t> grabbed_elements{}, moved_elements{}, cut_links{},
        carved_elements{};
    std::optional<Vec3d> bone_mm{};  ///< where limited_by is Bone: the nearest that stopped it
    double solve_ms = 0;
    std::optional<Vec3d> force_n{};  ///< on the tool
    std::optional<Vec3d> end_mm{};   ///< of a slide: final centre of the sphere, outside of tissue
    std::vector<std::uint32_t> whose{};  ///< clients whose step was undone or redone

    bool ok() const { return error_code.empty(); }
};

/// Change of the tissue's energy by a tool's last motion, for a tissue without forces.
struct FeltEnergy {
    std::uint32_t client = 0;
    Vec3d energy_per_mm;  ///< per path, against the motion [mm² · weight/mm]
};

/// A label of the map beside the scan.
struct LabelInfo {
    int value = 0;                                  ///< in the file
    std::string name{};                             ///< empty: the file has none
    std::optional<std::array<double, 3>> colour{};  ///< sRGB, 0…1
    std::int64_t voxels = 0;
    Vec3d centre_mm{0, 0, 0};  ///< mean position at rest
    int body = 0;              ///< that carries it, from 1; 0: none
    bool is_shown = true;      ///< at first
};

struct Welcome {
    ClientInfo client{};
    std::string resume{};
    bool resumed = false;
    int rate_hz = 60;
    std::uint64_t open_bytes = 0;  ///< size limit of an uploaded scan
    int spring_nodes = 32;         ///< limit along an axis
    std::vector<std::string> haptic_devices{};
    bool is_watched = false;  ///< a recorded session, which clients don't change
};

struct Checksums {
    std::uint32_t step = 0;
    std::uint32_t voxels = 0;              ///< MurmurHash3 of the half floats
    std::uint64_t volume = 0, tissue = 0;  ///< hash_volume, ChainMail::hash
};

std::string welcome_text(const Welcome& welcome, const VolumeInfo& volume,
                         const SharedState& state);
/// Announces another scan.
std::string volume_text(const VolumeInfo& volume);
std::string state_text(const SharedState& state);
/// `done` or `error`. @param step  whose voxels include the effect
std::string outcome_text(std::uint32_t id, std::string_view name, std::uint32_t step,
                         const Outcome& outcome);
std::string checksum_text(std::uint32_t id, const Checksums& sums);
std::string path_text(std::uint32_t id, std::uint32_t step, std::uint32_t volume,
                      const LumenPath& path);
/// A camera that is followed; without a pose: it is gone.
std::string camera_text(std::uint32_t client, const CameraMessage& camera);
/// State of a session that is watched.
struct ReplayState {
    double at_ms = 0, length_ms = 0, speed = 1;
    bool is_playing = false;
    bool is_seeking = false;  ///< on the way to a time
    std::string failure{};    ///< reason of an end
};
std::string replay_text(const ReplayState& state);
/// A command of a session on its time line.
struct TimelineMark {
    double at_ms = 0;
    std::uint32_t client = 0;
    std::string name{};
};
std::string replay_marks_text(std::span<const TimelineMark> marks);
/// Lists the labels of a map. @param name  of its file; empty: there is none
std::string labels_text(std::uint32_t volume, const std::string& name,
                        std::span<const LabelInfo> labels);
/// List of series as JSON.
/// List of the images of a file, from which a client chooses one.
std::string frames_text(std::int64_t count);
std::string series_text(std::span<const DicomSeries> list);
std::string pong_text(std::uint32_t id);
std::string bye_text(int code, const std::string& message);
std::string hex_text(std::uint64_t number, int digits);

}  // namespace pliant::serve
