// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Path searches that clients request: admission, and answers.

#pragma once

#include <memory>
#include <vector>

#include "hub/feed.h"
#include "hub/path_search.h"

namespace pliant::serve {

class PathFeed final : public Feed {
  public:
    using Feed::Feed;

    bool take(Client& client, const Message& message) override;
    void refresh() override;
    void leave(Client& client) override;
    void enter_scene() noexcept override;

  private:
    void look_for(Client& client, std::uint32_t id, const PathMessage& path);

    std::vector<std::unique_ptr<PathSearch>> m_searches;  ///< running ones
};

}  // namespace pliant::serve
