// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Background search of a path through the lumen, on its own thread, in a copy of the deformed
// volume at the time of the request.

#pragma once

#include <pliant/render.h>

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>

namespace pliant::serve {

struct PathQuestion {
    std::uint32_t id = 0;      ///< of the client's message
    std::uint32_t client = 0;  ///< client that asked
    std::uint32_t step = 0;    ///< step of the volume
    std::uint32_t volume = 0;  ///< id of the volume
    Vec3d from_mm{0, 0, 0}, to_mm{0, 0, 0};
    LumenPathSettings settings{};
};

class PathSearch {
  public:
    /// @param volume  private copy
    PathSearch(PathQuestion question, Volume volume);

    const PathQuestion& question() const { return m_question; }
    bool is_done() const { return m_done.load(std::memory_order_acquire); }
    /// @pre is_done()
    const Result<LumenPath>& found() const { return *m_found; }
    /// Cancels the search; it ends soon.
    void give_up() { m_thread.request_stop(); }

  private:
    PathQuestion m_question;
    Volume m_volume;
    std::optional<Result<LumenPath>> m_found;
    std::atomic<bool> m_done{false};
    std::jthread m_thread;  // declared last, so that it ends first
};

}  // namespace pliant::serve
