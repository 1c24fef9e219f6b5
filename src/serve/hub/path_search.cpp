// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/path_search.h"

#include "base/errors.h"

#include <utility>

#include "protocol/limits.h"

namespace pliant::serve {

PathSearch::PathSearch(PathQuestion question, Volume volume)
    : m_question(std::move(question)), m_volume(std::move(volume)) {
    m_question.settings.max_voxels = kMaxPathVoxels;
    m_found.emplace(out_of_memory());  // reserves memory for the thread's answer
    m_thread = std::jthread([this](const std::stop_token& stop) {
        const auto end = std::chrono::steady_clock::now() + kPathTime;
        LumenPathSettings settings = m_question.settings;
        settings.give_up = [&] {
            return stop.stop_requested() || std::chrono::steady_clock::now() > end;
        };
        m_found.emplace(attempt([&] {
            const TaskArena arena(1);  // the scene uses the other threads
            return find_lumen_path(m_volume, m_question.from_mm, m_question.to_mm, settings, arena);
        }));
        m_done.store(true, std::memory_order_release);
    });
}

}  // namespace pliant::serve
