// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A device in a client's hand, for the owner of the scene: its servo, what it feels of the present
// tissue, and the commands by which its tool pushes the tissue, as any client's tool would.
//
//   each step   next_push() ──► the scene      feel() ──► local model ──► servo
//
// The tool goes through free space without a command. Beyond a wall it pushes: ChainMail slides off
// it, springs are taken along; one contact is one step of undo. In a vessel it holds the catheter.

#pragma once

#include <pliant/haptics_servo.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "haptics/live_feel.h"
#include "haptics/posed_device.h"
#include "serve/catheter_grip.h"
#include "serve/client.h"
#include "serve/haptic_state.h"
#include "serve/scene.h"

namespace pliant::serve {

struct OpenedDevice {
    std::unique_ptr<HapticDevice> device;
    std::shared_ptr<PosedPlaces> places;  ///< of one whose place the client says; null for others
};

/// Devices that a client may choose by name: those in the tree, and those that the command line
/// named. So no client makes the server load a file.
class HapticDevices {
  public:
    /// @param given  as open_haptic_device() wants them
    explicit HapticDevices(std::vector<std::string> given = {}) : m_given(std::move(given)) {}

    std::vector<std::string> names() const;
    /// May take as long as the device does. From any thread.
    Result<OpenedDevice> open(const std::string& name) const;

  private:
    std::vector<std::string> m_given;
};

class HapticSession {
  public:
    /// @param client  who begins it  @param tool  a number that no client has
    static Result<std::unique_ptr<HapticSession>> start(const HapticsMessage& wish,
                                                        OpenedDevice opened, Scene& scene,
                                                        std::uint32_t client, std::uint32_t tool);

    std::uint32_t client() const { return m_client; }
    std::uint32_t tool() const { return m_tool; }

    /// What the tool does to the tissue now.
    std::optional<Action> next_push(Scene& scene);
    void pushed(const Outcome& outcome);
    /// The voxels have changed in these boxes.
    void changed(std::span<const Box3i> boxes);
    /// Hands the servo what is felt of the present tissue.
    void feel(Scene& scene);
    void pose(const HapticPoseMessage& pose);
    /// Whether it is for the tissue that there is now: a vessel's catheter is held otherwise.
    bool suits(const Scene& scene) const {
        return (scene.vessel() != nullptr) == m_grip.has_value();
    }

    void set_stop(bool stop);
    bool is_stopped() const { return m_is_stopped; }
    /// No force and no feeling any more; the scene may go. The servo needs a moment to let go
    /// without a jump: then it is to be destroyed.
    void end(Clock::time_point now);
    bool is_ending() const { return m_is_ending; }
    bool is_over(Clock::time_point now) const { return is_ending() && now > m_over_at; }

    HapticState state(const Scene& scene);
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
    std::shared_ptr<PosedPlaces> m_places;
    std::unique_ptr<HapticServo> m_servo;
    std::unique_ptr<LiveFeel> m_feel;    ///< of a scan; null in a vessel
    std::optional<CatheterGrip> m_grip;  ///< in a vessel
    bool m_is_ending = false;
    std::int64_t m_models = 0;
    HapticRecord m_now;
    bool m_has_place = false;

    Vec3d m_pushed_mm{0, 0, 0};  ///< where the tissue's tool is
    Vec3d m_way_mm{0, 0, 0};     ///< of the push that is under way
    Vec3d m_tried_mm{0, 0, 0};   ///< where it was to go last
    bool m_pushes = false;       ///< a contact has begun
    bool m_is_refused = false;  ///< the tissue can't be pushed here, as beyond the springs' lattice
    std::uint32_t m_stroke = 0;
    ChainMailSettings m_materials;  ///< that the feeling was made with

    bool m_is_stopped = false;
    Clock::time_point m_over_at{};
    std::uint64_t m_next_record = 0;
    double m_largest_n = 0;
    std::vector<HapticRecord> m_records;
    std::vector<std::int64_t> m_periods_ns, m_computes_ns;  ///< of the last seconds, in turn
    std::size_t m_at = 0;
    double m_age_ms = 0;
    Clock::time_point m_measured_at{};
    HapticStatistics m_statistics;
};

}  // namespace pliant::serve
