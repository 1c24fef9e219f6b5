// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A force-feedback device of a client, on the side of the scene's owner: its servo, its local
// models of the present tissue, and the commands by which its tool pushes the tissue like any
// client's tool.
//
//   each step   next_push() ──► the scene      feel() ──► local model ──► servo
//
// The tool moves through free space without commands. Beyond a wall it pushes: ChainMail slides off
// it, springs follow it; one contact is one step of undo. In a vessel it holds the catheter.

#pragma once

#include <pliant/models/drivable.h>
#include <pliant/view/haptics.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "haptics/live_feel.h"
#include "haptics/posed_device.h"
#include "hub/client.h"
#include "protocol/haptic_status.h"
#include "session/scene.h"

namespace pliant::serve {

// Force feedback for the catheter of a served tissue. The hand's motion becomes commands like those
// of any client. While the first button is held, the hand is decoupled from the wire, to reach
// back.

class CatheterGrip {
  public:
    /// @param tool   number of the tool that drives
    /// @param scale  mm in the scene per mm of the device
    static Result<CatheterGrip> create(const Drivable& catheter, std::uint32_t tool, double scale);

    /// @param lets_go  a client stopped the device, or it is lost
    std::optional<Action> next(const HapticRecord& now, bool lets_go, const Scene& scene);
    /// Model of the force on the hand; none after the simulation has failed.
    std::optional<HapticModel> model(const HapticRecord& now, const Drivable& catheter) const;
    double ahead_mm(const HapticRecord& now, const Drivable& catheter) const;

  private:
    CatheterGrip(CatheterFeel feel, std::uint32_t tool) : m_feel(std::move(feel)), m_tool(tool) {}

    CatheterFeel m_feel;
    std::uint32_t m_tool;
    bool m_turns = false;  ///< the device measures rotation
    double m_time_s = 0;
};

struct OpenedDevice {
    std::unique_ptr<HapticDevice> device;
    /// Set if the client supplies the position; null for others.
    std::shared_ptr<PosedPositions> positions;
};

/// Devices that a client may choose by name: built-in ones, and those on the command line. So a
/// client can't make the server load a file.
class HapticDevices {
  public:
    /// @param given  in the syntax of open_haptic_device()
    explicit HapticDevices(std::vector<std::string> given = {}) : m_given(std::move(given)) {}

    std::vector<std::string> names() const;
    /// Opens a device; takes as long as the device needs. Thread-safe.
    Result<OpenedDevice> open(const std::string& name) const;

  private:
    std::vector<std::string> m_given;
};

class HapticSession {
  public:
    /// @param client  owner of the session  @param tool  a number that no client has
    static Result<std::unique_ptr<HapticSession>> start(const HapticsMessage& wish,
                                                        OpenedDevice opened, Scene& scene,
                                                        std::uint32_t client, std::uint32_t tool);

    std::uint32_t client() const { return m_client; }
    std::uint32_t tool() const { return m_tool; }

    /// The tool's next command to the tissue.
    std::optional<Action> next_push(Scene& scene);
    void pushed(const Outcome& outcome);
    /// Tells that the voxels have changed in these boxes.
    void changed(std::span<const Box3i> boxes);
    /// Posts the local model of the present tissue to the servo.
    void feel(Scene& scene);
    void pose(const HapticPoseMessage& pose);
    /// Whether the session suits the present tissue: a catheter needs a grip, other tissue none.
    bool suits(const Scene& scene) const {
        return (scene.tissue().drivable() != nullptr) == m_grip.has_value();
    }

    void set_stop(bool stop);
    bool is_stopped() const { return m_is_stopped; }
    /// Ends force and models; the scene may be destroyed. The servo ramps the force down first.
    /// Destroy the session once is_over().
    void end(Clock::time_point now);
    bool is_ending() const { return m_is_ending; }
    bool is_over(Clock::time_point now) const { return is_ending() && now > m_over_at; }

    HapticStatus state(const Scene& scene);
    ToolPose pose_of_tool() const;

  private:
    HapticSession() = default;
    Result<std::unique_ptr<LiveFeel>> make_feel(Scene& scene) const;
    std::optional<HapticModel> model_of(Scene& scene);
    std::optional<Action> next_push_of(Scene& scene, bool is_free);
    void read_records();
    void measure();

    std::uint32_t m_client = 0, m_tool = 0;
    HapticsMessage m_wish;
    std::string m_device;
    double m_largest_force_n = 0;
    std::shared_ptr<PosedPositions> m_positions;
    std::unique_ptr<HapticServo> m_servo;
    std::unique_ptr<LiveFeel> m_feel;    ///< in a scan; null in a vessel
    std::optional<CatheterGrip> m_grip;  ///< in a vessel
    bool m_is_ending = false;
    std::int64_t m_models = 0;
    HapticRecord m_now;
    bool m_has_position = false;

    Vec3d m_pushed_mm{0, 0, 0};  ///< position of the tissue's tool
    Vec3d m_way_mm{0, 0, 0};     ///< way of the current push
    Vec3d m_tried_mm{0, 0, 0};   ///< target of the last push
    bool m_pushes = false;       ///< in contact
    bool m_is_refused = false;   ///< pushes are refused here, for example beyond the springs'
                                 ///< lattice
    std::uint32_t m_stroke = 0;
    ChainMailSettings m_materials;  ///< materials of m_feel

    bool m_is_stopped = false;
    Clock::time_point m_over_at{};
    std::uint64_t m_next_record = 0;
    double m_largest_n = 0;
    std::vector<HapticRecord> m_records;
    std::vector<std::int64_t> m_periods_ns, m_computes_ns;  ///< of the last seconds, ring buffer
    std::size_t m_at = 0;
    double m_age_ms = 0;
    Clock::time_point m_measured_at{};
    HapticStatistics m_statistics;
};

}  // namespace pliant::serve
