// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/device_opening.h"

#include "base/errors.h"

#include <string>
#include <utility>

namespace pliant::serve {

DeviceOpening::DeviceOpening(DeviceQuestion question, std::unique_ptr<HapticSession> before,
                             const HapticDevices* devices)
    : m_question(std::move(question)), m_before(std::move(before)) {
    m_thread =
        std::jthread([this, devices, device = m_question.wish.device](const std::stop_token& stop) {
            m_before.reset();
            if (devices && !stop.stop_requested())
                m_opened.emplace(attempt([&] { return devices->open(device); }));
            if (stop.stop_requested()) m_opened.reset();
            m_done.store(true, std::memory_order_release);
        });
}

}  // namespace pliant::serve
