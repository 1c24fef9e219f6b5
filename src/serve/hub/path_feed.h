// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Path searches that clients request. Each runs on its own thread, in a copy of the deformed volume
// at the time of the request.

#pragma once

#include <pliant/render.h>

#include <memory>
#include <vector>

#include "hub/background.h"
#include "hub/feed.h"

namespace pliant::serve {

struct PathQuestion {
    std::uint32_t id = 0;      ///< of the client's message
    std::uint32_t client = 0;  ///< client that asked
    std::uint32_t step = 0;    ///< step of the volume
    std::uint32_t volume = 0;  ///< id of the volume
    Vec3d from_mm{0, 0, 0}, to_mm{0, 0, 0};
    LumenPathSettings settings{};
};

/// Search in a copy of the volume.
struct PathSearch {
    PathSearch(const PathQuestion& question, const Volume& volume);

    PathQuestion question;
    Background<LumenPath> work;
};

class PathFeed final : public Feed {
  public:
    using Feed::Feed;

    bool take(Client& client, const Message& message) override;
    void refresh() override;
    void leave(Client& client) override;
    void enter_scene() noexcept override;

  private:
    void start_search(Client& client, std::uint32_t id, const PathMessage& path);

    std::vector<std::unique_ptr<PathSearch>> m_searches;  ///< running ones
};

}  // namespace pliant::serve
