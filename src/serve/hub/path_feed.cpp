// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/path_feed.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "protocol/limits.h"

namespace pliant::serve {
namespace {

Outcome refusal(const Error& error) {
    const char* code = error.code == ErrorCode::NotFound        ? "no_way"
                       : error.code == ErrorCode::LimitExceeded ? "limit"
                                                                : "out_of_range";
    return {.error_code = code, .message = "path: " + error.message};
}

}  // namespace

PathSearch::PathSearch(const PathQuestion& asked, const Volume& volume)
    : question(asked), work([asked, volume](const std::stop_token& stop) {
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

}  // namespace pliant::serve
