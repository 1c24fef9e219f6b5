// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A feed of numbers on a grid, for clients that request them. They are sent like voxels, in boxes,
// but after the voxels, and within a budget per step that all clients share.

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hub/feed.h"

namespace pliant::serve {

class BoxFeed : public Feed {
  public:
    /// @param budget   nodes per step
    /// @param max_box  nodes of a box
    BoxFeed(FeedHost& host, std::int64_t budget, std::int64_t max_box = INT64_MAX)
        : Feed(host), m_budget(budget), m_max_box(max_box) {}

    void refresh() override;
    void add(Client& client, std::vector<Outgoing>& batch) override;
    bool is_due(const Client& client) const override;
    std::optional<Clock::time_point> unseen_since(const Client& client) const override;
    void leave(Client& client) override { m_subscriptions.erase(client.info.number); }
    void enter_scene() noexcept override {
        m_subscriptions.clear();
        m_requests.clear();
    }

  protected:
    struct Subscription {
        std::uint16_t format;
        Delivery delivery;
    };
    /// Whether the numbers are known.
    virtual bool is_ready() const { return true; }
    /// Numbers of a box as they are sent.
    virtual std::vector<std::uint16_t> halves_of(const Box3i& box, std::uint16_t format) = 0;

    /// Makes the delivery of a new subscription. @returns nothing for lack of memory
    virtual std::optional<Delivery> start_delivery() { return {}; }

    /// Subscribes a client to a format, in refresh(); 0: to none.
    void request(const Client& client, const Message& message, std::uint16_t format);
    /// Takes the acknowledgement of a subscription. @returns whether it is one
    bool take_seen(const Client& client, const Message& message);
    void mark(std::span<const Box3i> boxes);

    std::map<std::uint32_t, Subscription> m_subscriptions;  ///< by client

  private:
    struct Request {
        std::uint32_t client, id;
        std::string_view name;
        std::uint16_t format;
    };
    void answer(Client& client, const Request& request);
    void add_parts(const Box3i& box, std::vector<Box3i>& boxes) const;
    std::string encode(const Box3i& box, std::uint8_t flags, std::uint16_t format, bool pack);

    std::int64_t m_budget, m_max_box;
    std::int64_t m_left = 0;          ///< of the budget
    std::vector<Request> m_requests;  ///< of this step
    SharedFrames m_frames;
};

}  // namespace pliant::serve
