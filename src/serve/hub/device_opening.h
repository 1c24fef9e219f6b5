// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Opens and closes devices on a separate thread. A vendor's driver may take seconds; the scene goes
// on meanwhile.

#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "hub/haptic_session.h"

namespace pliant::serve {

/// Client that asked for a device, and its request.
struct DeviceQuestion {
    std::uint32_t client = 0, id = 0;  ///< 0: cancelled
    HapticsMessage wish{};
};

class DeviceOpening {
  public:
    /// @param before   session whose device is closed first, because it may be the same device; may
    ///                 be null
    /// @param devices  null: opens none. Must outlive this object
    DeviceOpening(DeviceQuestion question, std::unique_ptr<HapticSession> before,
                  const HapticDevices* devices);

    const DeviceQuestion& question() const { return m_question; }
    bool is_done() const { return m_done.load(std::memory_order_acquire); }
    /// @pre is_done(), and a device was requested
    Result<OpenedDevice> take() { return std::move(*m_opened); }
    /// Cancels the request: the device is closed if it was opened.
    void give_up() {
        m_question.client = 0;
        m_thread.request_stop();
    }

  private:
    DeviceQuestion m_question;
    std::unique_ptr<HapticSession> m_before;
    std::optional<Result<OpenedDevice>> m_opened;
    std::atomic<bool> m_done{false};
    std::jthread m_thread;  // declared last, so that it ends first
};

}  // namespace pliant::serve
