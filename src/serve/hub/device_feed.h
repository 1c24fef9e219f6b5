// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A force-feedback device of one client. The pushes of its tool are ordinary commands of the scene,
// under a separate client number: recorded, replayed, undone. All clients receive its force.

#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hub/background.h"
#include "hub/feed.h"
#include "hub/haptic_session.h"

namespace pliant::serve {

/// Client that asked for a device, and its request.
struct DeviceQuestion {
    std::uint32_t client = 0, id = 0;  ///< 0: cancelled
    HapticsMessage wish{};
};

/// Opens and closes devices on a separate thread. A vendor's driver may take seconds; the scene
/// goes on meanwhile.
struct DeviceOpening {
    /// @param before   session whose device is closed first, because it may be the same device; may
    ///                 be null
    /// @param devices  null: opens none. Must outlive this object
    DeviceOpening(const DeviceQuestion& question, std::unique_ptr<HapticSession> before,
                  const HapticDevices* devices);
    /// Cancels the request: the device is closed if it was opened.
    void cancel() {
        question.client = 0;
        work.cancel();
    }

    DeviceQuestion question;
    Background<OpenedDevice> work;
};

class DeviceFeed final : public Feed {
  public:
    using Feed::Feed;

    /// Offers devices beside the built-in ones. Call it before the first step.
    void offer(HapticDevices devices) { m_devices = std::move(devices); }
    const HapticDevices& devices() const { return m_devices; }
    /// Whether a device is open, or being opened or closed.
    bool is_busy() const { return m_session || m_opening; }
    /// The device's tool, for the tools of all clients.
    std::optional<ToolPose> tool() const;

    bool take(Client& client, const Message& message) override;
    void act() override;
    bool follow(std::span<const Box3i> boxes) override;
    void refresh() override;
    void add(Client& client, std::vector<Outgoing>& batch) override;
    void sent(Client& client) noexcept override;
    void leave(Client& client) override;
    void leave_scene() override;
    void enter_scene() noexcept override {}

  private:
    void take_wish(Client& client, std::uint32_t id, const HapticsMessage& haptics);
    void start(Client& client, std::uint32_t id, const HapticsMessage& haptics);
    void end(const std::string& why);
    void release();
    void open_device();
    void take_device();
    void give_up_device(std::uint32_t client, const Outcome& why);

    HapticDevices m_devices;
    std::unique_ptr<HapticSession> m_session;  ///< null: no device
    std::optional<DeviceQuestion> m_wish;      ///< waits until the previous device is closed
    std::unique_ptr<DeviceOpening> m_opening;  ///< device being opened or closed
    std::string m_why;                         ///< reason of the last end
    std::string m_text;                        ///< state of the device
    std::uint64_t m_version = 0;
    std::map<std::uint32_t, std::uint64_t> m_sent;  ///< version last sent, by client
};

}  // namespace pliant::serve
