// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A force-feedback device of one client. The pushes of its tool are ordinary commands of the scene,
// under a separate client number: recorded, replayed, undone. All clients receive its force.

#include <string>
#include <utility>

#include "core/errors.h"
#include "serve/hub.h"

namespace pliant::serve {
namespace {

constexpr const char* kOtherTissue = "the tissue is another one now: start the device again";

}  // namespace

void Hub::take_haptics(Client& client, std::uint32_t id, const HapticsMessage& haptics) {
    const auto answer = [&](const Outcome& outcome) {
        say(client, outcome_text(id, "haptics", m_step, outcome));
    };
    if (client.info.view)
        return answer({.error_code = "view_only",
                       .message = "haptics: expected the role control, found view"});
    if (client.scene_step)
        return answer({.error_code = "other_scan",
                       .message = "haptics: another scan was opened; expected to see it first"});
    if (haptics.wish == HapticWish::Start) return start_haptics(client, id, haptics);
    if (!m_haptics || m_haptics->is_ending())
        return answer({.error_code = "nothing",
                       .message = "haptics: expected a device in somebody's hand, found none"});
    // Every client with control may stop it; only its owner may resume the force.
    if (haptics.wish == HapticWish::Go && m_haptics->client() != client.info.number)
        return answer({.error_code = "held_by_other",
                       .message = "haptics: expected who began it, found client " +
                                  std::to_string(client.info.number)});
    if (haptics.wish == HapticWish::End)
        end_haptics("");
    else
        m_haptics->set_stop(haptics.wish == HapticWish::Stop);
    answer({});
}

void Hub::start_haptics(Client& client, std::uint32_t id, const HapticsMessage& haptics) {
    const auto refuse = [&](const char* code, const std::string& why) {
        say(client, outcome_text(id, "haptics", 0, {.error_code = code, .message = why}));
    };
    if (m_haptics && m_haptics->client() != client.info.number && !m_haptics->is_ending())
        return refuse("held_by_other",
                      "haptics: expected nobody else to hold a device, found "
                      "client " +
                          std::to_string(m_haptics->client()));
    if (m_wish || (m_opening && m_opening->question().client))
        return refuse("busy", "haptics: expected one device at a time, found one that is opened");
    // The device may be the same one, so it is closed before it is opened again.
    end_haptics("");
    m_wish = {client.info.number, id, haptics};
    open_device();
}

/// Opens the requested device, once the previous one is closed.
void Hub::open_device() {
    if (m_opening || !m_wish) return;
    m_opening = std::make_unique<DeviceOpening>(*std::exchange(m_wish, {}), std::move(m_haptics),
                                                &m_haptic_devices);
}

/// Starts a session on the opened device, if the client is still connected.
void Hub::take_device() {
    if (!m_opening || !m_opening->is_done()) return;
    const auto opening = std::move(m_opening);
    const DeviceQuestion& asked = opening->question();
    for (Client& client : m_clients) {
        if (asked.client == 0 || client.info.number != asked.client) continue;
        auto session = attempt([&]() -> Result<std::unique_ptr<HapticSession>> {
            auto opened = opening->take();
            if (!opened.ok()) return opened.error();
            return HapticSession::start(asked.wish, std::move(*opened), *m_scene, asked.client,
                                        m_last_client + 1);
        });
        if (!session.ok()) {
            say(client, outcome_text(asked.id, "haptics", 0,
                                     {.error_code = "out_of_range",
                                      .message = "haptics: " + session.error().message}));
            break;
        }
        m_haptics = std::move(*session);
        ++m_last_client;
        m_haptics_why.clear();
        say(client, outcome_text(asked.id, "haptics", m_step, {}));
    }
    open_device();
}

/// Cancels requests for a device. @param client  0: any
void Hub::give_up_device(std::uint32_t client, const Outcome& why) {
    const auto is_meant = [&](const DeviceQuestion& asked) {
        return asked.client != 0 && (client == 0 || asked.client == client);
    };
    const auto answer = [&](const DeviceQuestion& asked) {
        for (Client& waiting : m_clients)
            if (waiting.info.number == asked.client && waiting.connection)
                say(waiting, outcome_text(asked.id, "haptics", 0, why));
    };
    if (m_wish && is_meant(*m_wish)) answer(*std::exchange(m_wish, {}));
    if (!m_opening || !is_meant(m_opening->question())) return;
    answer(m_opening->question());
    m_opening->give_up();
}

void Hub::take_pose(const Client& client, const HapticPoseMessage& pose) {
    if (m_haptics && m_haptics->client() == client.info.number) m_haptics->pose(pose);
}

void Hub::end_haptics(const std::string& why) {
    if (!m_haptics || m_haptics->is_ending()) return;
    if (m_scene->has_contact(m_haptics->tool())) act(m_haptics->tool(), ReleaseCommand{});
    m_haptics->end(m_now);
    m_haptics_why = why;
}

void Hub::push_by_device() {
    take_device();
    if (!m_haptics) return;
    if (m_haptics->is_over(m_now) && !m_opening) {  // closed in the background too
        m_opening =
            std::make_unique<DeviceOpening>(DeviceQuestion{}, std::move(m_haptics), nullptr);
        return;
    }
    if (m_haptics->is_ending()) return;
    if (!m_haptics->suits(*m_scene)) return end_haptics(kOtherTissue);
    if (const auto push = m_haptics->next_push(*m_scene))
        m_haptics->pushed(act(m_haptics->tool(), *push));
}

/// Call it while the volume is up to date.
void Hub::feel_device() {
    if (m_haptics && m_haptics->suits(*m_scene)) m_haptics->feel(*m_scene);
}

void Hub::refresh_haptics() {
    if (!m_haptics && m_haptics_version == 0) return;
    HapticState state = m_haptics ? m_haptics->state(*m_scene) : HapticState{};
    state.on = m_haptics && !m_haptics->is_ending();
    state.why = m_haptics_why;
    std::string text = haptics_text(state);
    if (text == m_haptics_text) return;
    m_haptics_text = std::move(text);
    ++m_haptics_version;
}

}  // namespace pliant::serve
