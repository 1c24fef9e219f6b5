// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/mark_feed.h"

#include <algorithm>

#include "protocol/limits.h"

namespace pliant::serve {

bool MarkFeed::take(Client& client, const Message& message) {
    if (const auto* mark = std::get_if<MarkMessage>(&message.action)) {
        set(client, message.id, *mark);
        return true;
    }
    const auto* wish = std::get_if<MarksMessage>(&message.action);
    if (!wish) return false;
    std::string text = marks_text(m_marks);
    if (wish->on)
        m_clients.insert(client.info.number);
    else
        m_clients.erase(client.info.number);
    m_host.say(client, outcome_text(message.id, "marks", m_host.step(), {}));
    if (wish->on) m_host.say(client, std::move(text));
    return true;
}

void MarkFeed::set(Client& client, std::uint32_t id, const MarkMessage& mark) {
    const auto refuse = [&](const char* code, const char* why) {
        m_host.say(client, outcome_text(id, "mark", 0, {.error_code = code, .message = why}));
    };
    if (client.info.view) return refuse("view_only", "mark: expected the role control, found view");
    const auto found = std::find_if(m_marks.begin(), m_marks.end(), [&](const MarkMessage& other) {
        return other.key == mark.key;
    });
    if (found == m_marks.end() && m_marks.size() >= kMaxMarks)
        return refuse("limit", "mark: expected up to 256 marks, found more");
    std::string text = mark_text(mark);
    if (mark.kind == MarkKind::None) {
        if (found != m_marks.end()) m_marks.erase(found);
    } else if (found != m_marks.end()) {
        *found = mark;
    } else {
        m_marks.push_back(mark);
    }
    m_host.say(client, outcome_text(id, "mark", m_host.step(), {}));
    for (Client& other : m_host.clients())
        if (&other != &client && m_clients.contains(other.info.number)) m_host.say(other, text);
}

void MarkFeed::leave(Client& client) {
    m_clients.erase(client.info.number);
}

void MarkFeed::enter_scene() noexcept {
    m_marks.clear();
    m_clients.clear();
}

}  // namespace pliant::serve
