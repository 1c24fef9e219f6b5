// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks that the clients of a scan share: points, rulers, angles and curves, by their positions at
// rest. The newest version of each mark counts. Marks don't change the scene, and are not recorded.

#include <algorithm>
#include <set>

#include "hub/feed.h"
#include "protocol/limits.h"

namespace pliant::serve {
namespace {

class MarkFeed final : public Feed {
  public:
    using Feed::Feed;

    bool take(Client& client, const Message& message) override;
    void leave(Client& client) override { m_clients.erase(client.info.number); }
    void enter_scene() noexcept override {
        m_marks.clear();
        m_clients.clear();
    }

  private:
    void set(Client& client, std::uint32_t id, const MarkMessage& mark);

    std::vector<MarkMessage> m_marks;
    std::set<std::uint32_t> m_clients;  ///< by number
};

bool MarkFeed::take(Client& client, const Message& message) {
    if (const auto* mark = std::get_if<MarkMessage>(&message.action)) {
        set(client, message.id, *mark);
        return true;
    }
    const auto* wish = std::get_if<MarksMessage>(&message.action);
    if (!wish) return false;
    if (wish->on)
        m_clients.insert(client.info.number);
    else
        m_clients.erase(client.info.number);
    m_host.accept(client, message.id, "marks");
    if (wish->on) m_host.send(client, marks_text(m_marks));
    return true;
}

void MarkFeed::set(Client& client, std::uint32_t id, const MarkMessage& mark) {
    if (client.info.view)
        return m_host.refuse(client, id, "mark", "view_only",
                             "expected the role control, found view");
    const auto found = std::find_if(m_marks.begin(), m_marks.end(), [&](const MarkMessage& other) {
        return other.key == mark.key;
    });
    if (found == m_marks.end() && m_marks.size() >= kMaxMarks)
        return m_host.refuse(client, id, "mark", "limit", "expected up to 256 marks, found more");
    std::string text = mark_text(mark);
    if (mark.kind == MarkKind::None) {
        if (found != m_marks.end()) m_marks.erase(found);
    } else if (found != m_marks.end()) {
        *found = mark;
    } else {
        m_marks.push_back(mark);
    }
    m_host.accept(client, id, "mark");
    for (Client& other : m_host.clients())
        if (&other != &client && m_clients.contains(other.info.number)) m_host.send(other, text);
}

}  // namespace

std::unique_ptr<Feed> make_mark_feed(FeedHost& host) {
    return std::make_unique<MarkFeed>(host);
}

}  // namespace pliant::serve
