// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Path searches that clients request. Each runs on its own thread, in a copy of the deformed volume
// at the time of the request.

#include <pliant/render.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "hub/background.h"
#include "hub/feed.h"
#include "protocol/limits.h"

namespace pliant::serve {
namespace {

struct PathQuestion {
    std::uint32_t id = 0;      ///< of the client's message
    std::uint32_t client = 0;  ///< client that asked
    std::uint32_t step = 0;    ///< step of the volume
    std::uint32_t volume = 0;  ///< id of the volume
    Vec3d from_mm{0, 0, 0}, to_mm{0, 0, 0};
    LumenPathSettings settings{};
};

struct PathSearch {
    /// @param volume  private copy
    PathSearch(const PathQuestion& question, Volume volume);

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

Outcome refusal(const Error& error) {
    const char* code = error.code == ErrorCode::NotFound        ? "no_way"
                       : error.code == ErrorCode::LimitExceeded ? "limit"
                                                                : "out_of_range";
    return {.error_code = code, .message = "path: " + error.message};
}

PathSearch::PathSearch(const PathQuestion& asked, Volume copy)
    : question(asked), work([asked, volume = std::move(copy)](const std::stop_token& stop) {
          const auto end = Clock::now() + kPathTime;
          LumenPathSettings settings = asked.settings;
          settings.max_voxels = kMaxPathVoxels;
          settings.give_up = [&] { return stop.stop_requested() || Clock::now() > end; };
          const TaskArena arena(1);  // the scene uses the other threads
          return find_lumen_path(volume, asked.from_mm, asked.to_mm, settings, arena);
      }) {}

bool PathFeed::take(Client& client, const Message& message) {
    const auto* path = std::get_if<PathMessage>(&message.action);
    if (path) start_search(client, message.id, *path);
    return path != nullptr;
}

void PathFeed::start_search(Client& client, std::uint32_t id, const PathMessage& path) {
    const std::uint32_t number = client.info.number;
    const bool own = std::any_of(m_searches.begin(), m_searches.end(), [&](const auto& search) {
        return search->question.client == number;
    });
    if (own || m_searches.size() >= kMaxPathSearches)
        return m_host.refuse(client, id, "path", "busy",
                             own ? "expected one search at a time, found another that is still "
                                   "going on"
                                 : "expected up to 2 searches at once, found those of others still "
                                   "going on");
    const Scene& scene = m_host.scene();
    SharedState state;
    scene.describe(state);
    m_searches.reserve(m_searches.size() + 1);
    try {
        m_searches.push_back(std::make_unique<PathSearch>(
            PathQuestion{.id = id,
                         .client = number,
                         .step = m_host.step(),
                         .volume = scene.info().id,
                         .from_mm = path.from_mm,
                         .to_mm = path.to_mm,
                         .settings = {.iso_hu = path.iso_hu.value_or(state.iso_hu),
                                      .polarity = path.polarity.value_or(state.polarity),
                                      .reach_mm = path.reach_mm}},
            scene.deformed()));
    } catch (const std::system_error& error) {
        m_host.refuse(client, id, "path", "limit",
                      "a thread can't be started: " + error.code().message());
    }
}

void PathFeed::refresh() {
    for (auto at = m_searches.begin(); at != m_searches.end();) {
        PathSearch& search = **at;
        if (!search.work.is_done()) {
            ++at;
            continue;
        }
        const PathQuestion& asked = search.question;
        if (Client* client = connected(m_host, asked.client)) {
            const auto& found = search.work.result();
            m_host.send(*client, found ? path_text(asked.id, asked.step, asked.volume, *found)
                                       : outcome_text(asked.id, "path", 0, refusal(found.error())));
        }
        at = m_searches.erase(at);
    }
}

void PathFeed::leave(Client& client) {
    for (const auto& search : m_searches)
        if (search->question.client == client.info.number) search->work.cancel();
}

void PathFeed::enter_scene() noexcept {
    for (const auto& search : m_searches) search->work.cancel();
}

}  // namespace

std::unique_ptr<Feed> make_path_feed(FeedHost& host) {
    return std::make_unique<PathFeed>(host);
}

}  // namespace pliant::serve
