// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Messages of a client (docs/developers/protocol.md), as plain values. The parser converts every
// text to one of these, or to a failure; the code behind it sees no JSON.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/core/record.h>
#include <pliant/render.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "protocol/frames.h"
#include "protocol/haptic_status.h"
#include "protocol/tissue_choice.h"

namespace pliant::serve {

inline constexpr int kProtocolVersion = 2;

struct HelloMessage {
    int protocol = 0;
    bool view = false;
    std::string name{};
    bool lz4 = false;
    bool coarse = false;  ///< whether a coarse scan is wanted first
    std::string resume{};
    std::optional<std::uint32_t> step{};  ///< step of the voxels that the client still has
};

struct PushCommand {
    Push push{};
    bool slide = false;        ///< tissue slides off the sphere
    std::uint32_t stroke = 0;  ///< pushes of one stroke form one step of undo; 0: none
};
struct GrabCommand {
    Push position{};
    double reach_mm = 20;
};
struct DragCommand {
    Vec3d offset_mm{0, 0, 0};
};
struct LetGoCommand {};
struct CutCommand {
    CutSurface surface;
};
struct CarveCommand {
    CarveTool tool{};
    std::uint32_t stroke = 0;
};
struct RelaxCommand {
    bool on = false;
};
struct ReleaseCommand {};
/// Position of the client's endoscope, an obstacle of relaxation. The server derives it from tool
/// poses, so that a recorded session contains it.
struct EyeCommand {
    Vec3d position_mm{0, 0, 0};
    double radius_mm = 0;  ///< 0: removed

    friend bool operator==(const EyeCommand&, const EyeCommand&) = default;
};
struct ResetCommand {};
/// Materials that change, by the names of chainmail_material_rows().
struct MaterialsCommand {
    Record values{};
};
struct IsoCommand {
    std::optional<double> iso_hu{};
    std::optional<Polarity> polarity{};
    std::uint32_t stroke = 0;  ///< set by the server, not by the client
};
struct UndoCommand {};
struct RedoCommand {};
/// Switches to another tissue model; history is cleared.
struct TissueCommand {
    TissueChoice choice{};
    bool is_centred = false;  ///< otherwise in the middle of the scan, and the choice's centre is
                              ///< ignored
};
struct DepthCommand {
    std::optional<int> layers{};        ///< layers that forces reach
    std::optional<double> within_mm{};  ///< instead: as Tissue::take_depth
    std::optional<bool> by_time{};      ///< TissueChoice::depth_by_time from now on; empty: no
};

/// Motion of the hand on the catheter. Empty fields don't change.
struct DriveCommand {
    std::optional<double> insert_mm_s{}, rotate_deg_s{}, bend_first_deg{}, bend_second_deg{};
};

struct ToolMessage {
    ToolPose pose;  ///< the server sets client, force and contact
};
struct ChecksumMessage {};
struct SeenMessage {
    std::uint32_t step = 0;
    std::uint32_t format = kFormatVoxels;
};
struct PingMessage {};
/// Requests an overlay beside the voxels.
struct OverlayMessage {
    OverlayKind kind = OverlayKind::None;
};
/// Requests the vessel's surface and the catheter, or cancels them.
struct VesselMessage {
    bool on = false;
};
/// Requests the rest field, or cancels it.
struct RestMessage {
    bool on = false;
};
/// The client's camera, for those that follow it. Without fields: there is none.
struct CameraMessage {
    struct Pose {
        Vec3d eye_mm{0, 0, 0}, look{0, 1, 0}, up{0, 0, 1};
    };
    std::optional<Pose> pose{};
};
/// Requests the camera of another client, or cancels that.
struct FollowMessage {
    std::uint32_t client = 0;  ///< 0: none
};
/// Controls a session that is watched. Empty fields don't change.
struct ReplayMessage {
    std::optional<bool> is_playing{};
    std::optional<double> speed{}, at_ms{};
};
/// Requests the label map beside the scan, or cancels it.
struct LabelsMessage {
    bool on = false;
};
/// Requests the marks of all clients and their changes, or cancels them.
struct MarksMessage {
    bool on = false;
};
enum class MarkKind : std::uint8_t { None = 0, Point = 1, Ruler = 2, Angle = 3, Curve = 4 };
/// Sets a mark, or deletes it.
struct MarkMessage {
    std::string key{};               ///< chosen by the client that made it
    MarkKind kind = MarkKind::None;  ///< None: deleted
    std::string name{};
    std::vector<Vec3d> rest_mm{};  ///< positions at rest
    bool shown = true;

    friend bool operator==(const MarkMessage&, const MarkMessage&) = default;
};
/// Empty fields take the scene's values.
struct PathMessage {
    Vec3d from_mm{0, 0, 0}, to_mm{0, 0, 0};
    double reach_mm = 0;  ///< distance by which an end in the tissue may be moved into a lumen
    std::optional<double> iso_hu{};
    std::optional<Polarity> polarity{};
};

/// Commands to the scene come first, then messages that the server answers itself.
using Action = std::variant<PushCommand, GrabCommand, DragCommand, LetGoCommand, CutCommand,
                            CarveCommand, RelaxCommand, ReleaseCommand, EyeCommand, ResetCommand,
                            MaterialsCommand, IsoCommand, UndoCommand, RedoCommand, TissueCommand,
                            DepthCommand, DriveCommand, HelloMessage, ToolMessage, ChecksumMessage,
                            SeenMessage, PingMessage, OverlayMessage, PathMessage, HapticsMessage,
                            HapticPoseMessage, VesselMessage, RestMessage, CameraMessage,
                            FollowMessage, ReplayMessage, LabelsMessage, MarksMessage, MarkMessage>;

struct Message {
    std::uint32_t id = 0;
    Action action;
};

/// Value of the field `do`: "push", "let_go", …
std::string_view name_of(const Action& action);
/// Whether it changes the scene and so requires the role control.
bool is_command(const Action& action);

struct ParseFailure {
    bool rubbish = true;  ///< closes the connection; false: a field is out of range
    std::string message;
    std::uint32_t id = 0;
    std::string name{};  ///< name of the command, if known
};

std::variant<Message, ParseFailure> parse_message(std::string_view text);
/// Converts a message to text, for the session's file and for clients.
std::string text_of(const Message& message);
/// Announces a changed or deleted mark.
std::string mark_text(const MarkMessage& mark);
/// Announces all marks.
std::string marks_text(std::span<const MarkMessage> marks);

}  // namespace pliant::serve
