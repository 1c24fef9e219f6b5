// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Labels of the deformed scan for clients that request them: the label of the tissue that is shown
// at a voxel. They are sent like overlays: after the voxels, within a budget per step. A client
// starts without any label, so it receives the whole map first.

#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "hub/feed.h"
#include "hub/label_map.h"

namespace pliant::serve {

class LabelFeed final : public Feed {
  public:
    using Feed::Feed;

    /// Shows another map to all clients; null: the bodies of the scene, if there are several.
    /// @pre on the scene's grid
    void show(std::shared_ptr<const LabelMap> map);

    bool take(Client& client, const Message& message) override;
    bool follow(std::span<const Box3i> boxes) override;
    void refresh() override;
    void add(Client& client, std::vector<Outgoing>& batch) override;
    void lost(Client& client) override;
    bool is_due(const Client& client) const override;
    std::optional<Clock::time_point> unseen_since(const Client& client) const override;
    void leave(Client& client) override;
    void enter_scene() noexcept override;

  private:
    void tell(Client& client);
    std::string encode(const Box3i& box, std::uint8_t flags, bool pack);
    int number_at(Vec3i voxel) const;
    int striped(std::uint16_t number, Vec3d rest_mm) const;

    std::shared_ptr<const LabelMap> m_map;        ///< null: none
    std::map<std::uint32_t, Delivery> m_clients;  ///< by number
    SharedFrames m_frames;
    std::int64_t m_left = 0;  ///< budget of voxels in this step
    bool m_has_sources = false;
};

}  // namespace pliant::serve
