// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Labels of the deformed scan for clients that request them: the label of the tissue that is shown
// at a voxel. A client starts without any label, so it receives the whole map first.

#pragma once

#include <memory>
#include <span>
#include <vector>

#include "hub/box_feed.h"
#include "protocol/limits.h"
#include "session/label_map.h"

namespace pliant::serve {

class LabelFeed final : public BoxFeed {
  public:
    explicit LabelFeed(FeedHost& host) : BoxFeed(host, kMaxLabelVoxels) {}

    /// Shows another map to all clients; null: the bodies of the scene, if there are several.
    /// @pre on the scene's grid
    void show(std::shared_ptr<const LabelMap> map);

    bool take(Client& client, const Message& message) override;
    bool follow(std::span<const Box3i> boxes) override;
    void refresh() override;
    void enter_scene() noexcept override;

  private:
    void send_list(Client& client);
    bool is_ready() const override { return m_map && m_has_sources && !m_host.is_behind(); }
    std::vector<std::uint16_t> halves_of(const Box3i& box, std::uint16_t format) override;
    int number_at(Vec3i voxel) const;
    int striped(std::uint16_t number, Vec3d rest_mm) const;

    std::shared_ptr<const LabelMap> m_map;  ///< null: none
    bool m_has_sources = false;
};

}  // namespace pliant::serve
