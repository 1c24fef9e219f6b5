// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The vessel and its catheter for clients that request them. Like tools, only the newest state is
// sent. Its numbers are part of the state message.

#include "serve/hub.h"

namespace pliant::serve {

/// Resets the vessel for a new scan.
void Hub::forget_vessel() {
    m_vessel = {};
    for (Client& client : m_clients) client.wants_vessel = client.has_surface = false;
}

void Hub::want_vessel(Client& client, std::uint32_t id, bool on) {
    client.wants_vessel = on;
    client.has_surface = false;
    client.vessel_version = 0;
    say(client, outcome_text(id, "vessel", m_step, {}));
}

void Hub::refresh_vessel() {
    const VesselTissue* vessel = m_scene->catheter();
    if (vessel && (m_moved || m_vessel.version() == 0)) m_vessel.update(*vessel);
}

void Hub::add_vessel(Client& client, std::vector<Outgoing>& batch) {
    if (!client.wants_vessel || !m_scene->catheter()) return;
    const std::uint32_t volume = m_scene->info().id;
    if (!client.has_surface) batch.push_back({false, m_vessel.surface(m_step, volume)});
    if (client.vessel_version == m_vessel.version()) return;
    batch.push_back({false, m_vessel.since(client.vessel_version, m_step, volume)});
}

}  // namespace pliant::serve
