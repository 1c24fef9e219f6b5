// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What a client may say (docs/protocol.md), as plain values. Whatever comes in as text becomes one
// of these, or a failure; nothing behind the parser sees JSON.

#pragma once

#include <pliant/chainmail.h>
#include <pliant/record.h>
#include <pliant/render.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "serve/frames.h"
#include "serve/haptic_state.h"
#include "serve/tissue_choice.h"

namespace pliant::serve {

inline constexpr int kProtocolVersion = 1;

struct HelloMessage {
    int protocol = 0;
    bool view = false;
    std::string name{};
    bool lz4 = false;
    std::string resume{};
    std::optional<std::uint32_t> step{};  ///< whose voxels the client still has
};

struct PushCommand {
    Push push{};
    bool slide = false;        ///< tissue slides off the sphere instead of following it
    std::uint32_t stroke = 0;  ///< pushes of one stroke are one step of undo; 0: none
};
struct GrabCommand {
    Push place{};
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
/// Where the client's endoscope stands: relaxation keeps out of it. The server makes these from the
/// poses of tools, so that a recorded session has them.
struct EyeCommand {
    Vec3d place_mm{0, 0, 0};
    double radius_mm = 0;  ///< 0: it is gone

    friend bool operator==(const EyeCommand&, const EyeCommand&) = default;
};
struct ResetCommand {};
/// Materials that change, by the names of material_rows().
struct MaterialsCommand {
    Record values{};
};
struct IsoCommand {
    std::optional<double> iso_hu{};
    std::optional<Polarity> polarity{};
    std::uint32_t stroke = 0;  ///< given by the server, not by the client
};
struct UndoCommand {};
struct RedoCommand {};
/// Another tissue, at rest; what was done is over.
struct TissueCommand {
    TissueChoice choice{};
    bool is_centred = false;  ///< else in the middle of the scan, whatever the choice says
};
struct DepthCommand {
    int layers = 0;  ///< that forces reach
};

/// The hand on the catheter. What is empty stays as it is.
struct DriveCommand {
    std::optional<double> insert_mm_s{}, rotate_deg_s{}, bend_first_deg{}, bend_second_deg{};
};

struct ToolMessage {
    ToolPose pose;  ///< client, force and so on are not the client's to say
};
struct ChecksumMessage {};
struct SeenMessage {
    std::uint32_t step = 0;
    std::uint32_t format = kFormatVoxels;
};
struct PingMessage {};
/// What the client wants to be sent beside the voxels.
struct OverlayMessage {
    OverlayKind kind = OverlayKind::None;
};
/// Whether the client wants the vessel's surface and the catheter.
struct VesselMessage {
    bool on = false;
};
/// Whether the client wants the rest field.
struct RestMessage {
    bool on = false;
};
/// What is empty is as the scene has it.
struct PathMessage {
    Vec3d from_mm{0, 0, 0}, to_mm{0, 0, 0};
    double reach_mm = 0;  ///< how far an end in the tissue may be moved into a lumen
    std::optional<double> iso_hu{};
    std::optional<Polarity> polarity{};
};

/// Commands to the scene come first; then what the server answers by itself.
using Action = std::variant<PushCommand, GrabCommand, DragCommand, LetGoCommand, CutCommand,
                            CarveCommand, RelaxCommand, ReleaseCommand, EyeCommand, ResetCommand,
                            MaterialsCommand, IsoCommand, UndoCommand, RedoCommand, TissueCommand,
                            DepthCommand, DriveCommand, HelloMessage, ToolMessage, ChecksumMessage,
                            SeenMessage, PingMessage, OverlayMessage, PathMessage, HapticsMessage,
                            HapticPoseMessage, VesselMessage, RestMessage>;

struct Message {
    std::uint32_t id = 0;
    Action action;
};

/// "push", "let_go", …: the field `do`.
std::string_view name_of(const Action& action);
/// Whether it changes the scene, so that the role must be control.
bool is_command(const Action& action);

struct ParseFailure {
    bool rubbish = true;  ///< the connection is to be closed; else a field is out of its range
    std::string message;
    std::uint32_t id = 0;
    std::string name{};  ///< of the command, where it is known
};

std::variant<Message, ParseFailure> parse_message(std::string_view text);
/// The same message as text: for the session's file, and for clients.
std::string text_of(const Message& message);

}  // namespace pliant::serve
