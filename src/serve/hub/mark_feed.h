// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks that the clients of a scan share: points, rulers, angles and curves, by their positions at
// rest. The newest version of each mark counts. Marks don't change the scene, and are not recorded.

#pragma once

#include <set>
#include <vector>

#include "hub/feed.h"

namespace pliant::serve {

class MarkFeed final : public Feed {
  public:
    using Feed::Feed;

    bool take(Client& client, const Message& message) override;
    void leave(Client& client) override { m_clients.erase(client.info.number); }
    void enter_scene() noexcept override;

  private:
    void set(Client& client, std::uint32_t id, const MarkMessage& mark);

    std::vector<MarkMessage> m_marks;
    std::set<std::uint32_t> m_clients;  ///< by number
};

}  // namespace pliant::serve
