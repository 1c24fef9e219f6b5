// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/device_feed.h"

#include <string>
#include <utility>

#include "base/errors.h"
#include "session/guarded.h"

namespace pliant::serve {
namespace {

constexpr const char* kOtherTissue = "the tissue is another one now: start the device again";

}  // namespace

DeviceOpening::DeviceOpening(const DeviceQuestion& asked, std::unique_ptr<HapticSession> before,
                             const HapticDevices* devices)
    : question(asked),
      work([before = std::move(before), devices, device = asked.wish.device](
               const std::stop_token& stop) mutable -> Result<OpenedDevice> {
          const Error cancelled{ErrorCode::NotFound, "cancelled"};
          before.reset();
          if (!devices || stop.stop_requested()) return cancelled;
          auto opened = devices->open(device);
          if (stop.stop_requested()) return cancelled;
          return opened;
      }) {}

std::optional<ToolPose> DeviceFeed::tool() const {
    if (!m_session || m_session->pose_of_tool().kind == ToolKind::None) return {};
    return m_session->pose_of_tool();
}

bool DeviceFeed::take(Client& client, const Message& message) {
    if (const auto* pose = std::get_if<HapticPoseMessage>(&message.action)) {
        if (m_session && m_session->client() == client.info.number) m_session->pose(*pose);
        return true;
    }
    const auto* haptics = std::get_if<HapticsMessage>(&message.action);
    if (haptics) take_wish(client, message.id, *haptics);
    return haptics != nullptr;
}

void DeviceFeed::take_wish(Client& client, std::uint32_t id, const HapticsMessage& haptics) {
    const auto refuse = [&](const char* code, const std::string& why) {
        m_host.refuse(client, id, "haptics", code, why);
    };
    if (client.info.view) return refuse("view_only", "expected the role control, found view");
    if (client.scene_step)
        return refuse("other_scan", "another scan was opened; expected to see it first");
    if (haptics.wish == HapticWish::Start) return start(client, id, haptics);
    if (!m_session || m_session->is_ending())
        return refuse("nothing", "expected a device in use, found none");
    // Every client with control may stop it; only its owner may resume the force.
    if (haptics.wish == HapticWish::Go && m_session->client() != client.info.number)
        return refuse("held_by_other", "expected the client that started it, found client " +
                                           std::to_string(client.info.number));
    if (haptics.wish == HapticWish::End)
        end("");
    else
        m_session->set_stop(haptics.wish == HapticWish::Stop);
    m_host.accept(client, id, "haptics");
}

void DeviceFeed::start(Client& client, std::uint32_t id, const HapticsMessage& haptics) {
    const auto refuse = [&](const char* code, const std::string& why) {
        m_host.refuse(client, id, "haptics", code, why);
    };
    if (m_session && m_session->client() != client.info.number && !m_session->is_ending())
        return refuse("held_by_other", "expected a free device, found one held by client " +
                                           std::to_string(m_session->client()));
    if (m_wish || (m_opening && m_opening->question.client))
        return refuse("busy", "expected one device at a time, found one that is opened");
    // The device may be the same one, so it is closed before it is opened again.
    end("");
    m_wish = {client.info.number, id, haptics};
    open_device();
}

/// Opens the requested device, once the previous one is closed.
void DeviceFeed::open_device() {
    if (m_opening || !m_wish) return;
    m_opening = std::make_unique<DeviceOpening>(*std::exchange(m_wish, {}), std::move(m_session),
                                                &m_devices);
}

/// Starts a session on the opened device, if the client is still connected.
void DeviceFeed::take_device() {
    if (!m_opening || !m_opening->work.is_done()) return;
    const auto opening = std::move(m_opening);
    const DeviceQuestion& asked = opening->question;
    for (Client& client : m_host.clients()) {
        if (asked.client == 0 || client.info.number != asked.client) continue;
        auto session = attempt([&]() -> Result<std::unique_ptr<HapticSession>> {
            auto opened = std::move(opening->work.result());
            if (!opened.ok()) return opened.error();
            return HapticSession::start(asked.wish, std::move(*opened), m_host.scene(),
                                        asked.client, m_host.last_client() + 1);
        });
        if (!session.ok()) {
            m_host.refuse(client, asked.id, "haptics", "out_of_range", session.error().message);
            break;
        }
        m_session = std::move(*session);
        ++m_host.last_client();
        m_why.clear();
        m_host.accept(client, asked.id, "haptics");
    }
    open_device();
}

/// Cancels requests for a device. @param client  0: any
void DeviceFeed::give_up_device(std::uint32_t client, const Outcome& why) {
    const auto is_meant = [&](const DeviceQuestion& asked) {
        return asked.client != 0 && (client == 0 || asked.client == client);
    };
    const auto answer = [&](const DeviceQuestion& asked) {
        if (Client* waiting = connected(m_host, asked.client))
            m_host.send(*waiting, outcome_text(asked.id, "haptics", 0, why));
    };
    if (m_wish && is_meant(*m_wish)) answer(*std::exchange(m_wish, {}));
    if (!m_opening || !is_meant(m_opening->question)) return;
    answer(m_opening->question);
    m_opening->cancel();
}

void DeviceFeed::end(const std::string& why) {
    if (!m_session || m_session->is_ending()) return;
    m_session->end(m_host.now());
    m_why = why;
    release();
}

/// A tool whose session ends holds no tissue.
void DeviceFeed::release() {
    if (m_host.scene().has_contact(m_session->tool()))
        m_host.act(m_session->tool(), ReleaseCommand{});
}

void DeviceFeed::act() {
    take_device();
    if (!m_session) return;
    if (m_session->is_over(m_host.now()) && !m_opening) {  // closed in the background too
        m_opening =
            std::make_unique<DeviceOpening>(DeviceQuestion{}, std::move(m_session), nullptr);
        return;
    }
    if (m_session->is_ending()) return release();  // memory may have been lacking before
    if (!m_session->suits(m_host.scene())) return end(kOtherTissue);
    if (const auto push = m_session->next_push(m_host.scene()))
        m_session->pushed(m_host.act(m_session->tool(), *push));
}

bool DeviceFeed::follow(std::span<const Box3i> boxes) {
    if (m_session && !boxes.empty() && !guarded("owner", [&] { m_session->changed(boxes); }))
        end("out of memory");
    return true;
}

void DeviceFeed::refresh() {
    if (m_session && m_session->suits(m_host.scene())) m_session->feel(m_host.scene());
    if (!m_session && m_version == 0) return;
    HapticStatus state = m_session ? m_session->state(m_host.scene()) : HapticStatus{};
    state.on = m_session && !m_session->is_ending();
    state.why = m_why;
    std::string text = haptics_text(state);
    if (text == m_text) return;
    m_text = std::move(text);
    ++m_version;
}

void DeviceFeed::add(Client& client, std::vector<Outgoing>& batch) {
    if (m_sent[client.info.number] != m_version)
        batch.push_back({true, std::make_shared<const std::string>(m_text)});
}

void DeviceFeed::sent(Client& client) noexcept {
    const auto found = m_sent.find(client.info.number);
    if (found != m_sent.end()) found->second = m_version;
}

void DeviceFeed::leave(Client& client) {
    m_sent.erase(client.info.number);
    if (m_session && m_session->client() == client.info.number)
        end("the browser that held the device is gone");
    give_up_device(client.info.number, {});
}

void DeviceFeed::leave_scene() {
    end("another scan was opened");
    give_up_device(
        0, {.error_code = "other_scan", .message = "haptics: another scan was opened meanwhile"});
}

}  // namespace pliant::serve
