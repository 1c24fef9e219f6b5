// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Devices are closed and opened on a thread of their own: a maker's kit may take seconds for it, in
// which the scene goes on.

#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "serve/haptic_session.h"

namespace pliant::serve {

/// Who asked for a device, and what for.
struct DeviceQuestion {
    std::uint32_t client = 0, id = 0;  ///< 0: nobody any more
    HapticsMessage wish{};
};

class DeviceOpening {
  public:
    /// @param before  whose device is closed first: it may be the same one. May be null
    /// @param devices  null: nothing is opened. To be kept until this is done
    DeviceOpening(DeviceQuestion question, std::unique_ptr<HapticSession> before,
                  const HapticDevices* devices);

    const DeviceQuestion& question() const { return m_question; }
    bool is_done() const { return m_done.load(std::memory_order_acquire); }
    /// @pre is_done(), and something was to be opened
    Result<OpenedDevice> take() { return std::move(*m_opened); }
    /// Nobody wants it any more: it is closed again where it was opened.
    void give_up() {
        m_question.client = 0;
        m_thread.request_stop();
    }

  private:
    DeviceQuestion m_question;
    std::unique_ptr<HapticSession> m_before;
    std::optional<Result<OpenedDevice>> m_opened;
    std::atomic<bool> m_done{false};
    std::jthread m_thread;  // the last, so that it ends first
};

}  // namespace pliant::serve
