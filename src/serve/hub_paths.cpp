// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Path searches that clients request: admission, and answers.

#include <algorithm>

#include "protocol/limits.h"
#include "serve/hub.h"

namespace pliant::serve {
namespace {

Outcome refusal(const Error& error) {
    const char* code = error.code == ErrorCode::NotFound        ? "no_way"
                       : error.code == ErrorCode::LimitExceeded ? "limit"
                                                                : "out_of_range";
    return {.error_code = code, .message = "path: " + error.message};
}

}  // namespace

void Hub::look_for(Client& client, std::uint32_t id, const PathMessage& path) {
    const std::uint32_t number = client.info.number;
    const bool own = std::any_of(m_paths.begin(), m_paths.end(), [&](const auto& search) {
        return search->question().client == number;
    });
    if (own || m_paths.size() >= kMaxPathSearches)
        return say(client,
                   outcome_text(id, "path", 0,
                                {.error_code = "busy",
                                 .message = own ? "path: expected one search at a time, found "
                                                  "another that is still going on"
                                                : "path: expected up to 2 searches at once, found "
                                                  "those of others still going on"}));
    SharedState state;
    m_scene->describe(state);
    m_paths.reserve(m_paths.size() + 1);
    try {
        m_paths.push_back(std::make_unique<PathSearch>(
            PathQuestion{.id = id,
                         .client = number,
                         .step = m_step,
                         .volume = m_scene->info().id,
                         .from_mm = path.from_mm,
                         .to_mm = path.to_mm,
                         .settings = {.iso_hu = path.iso_hu.value_or(state.iso_hu),
                                      .polarity = path.polarity.value_or(state.polarity),
                                      .reach_mm = path.reach_mm}},
            m_scene->deformed()));
    } catch (const std::system_error& error) {
        say(client, outcome_text(id, "path", 0,
                                 {.error_code = "limit",
                                  .message = std::string("path: a thread can't be started: ") +
                                             error.code().message()}));
    }
}

void Hub::tell_paths() {
    for (auto at = m_paths.begin(); at != m_paths.end();) {
        const PathSearch& search = **at;
        if (!search.is_done()) {
            ++at;
            continue;
        }
        const PathQuestion& asked = search.question();
        for (Client& client : m_clients) {
            if (client.info.number != asked.client) continue;
            const auto& found = search.found();
            say(client, found ? path_text(asked.id, asked.step, asked.volume, *found)
                              : outcome_text(asked.id, "path", 0, refusal(found.error())));
        }
        at = m_paths.erase(at);
    }
}

void Hub::give_up_paths(std::uint32_t client) {
    for (const auto& search : m_paths)
        if (search->question().client == client) search->give_up();
}

}  // namespace pliant::serve
