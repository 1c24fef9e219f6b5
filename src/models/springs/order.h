// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Breadth-first search with reused memory.

#pragma once

#include <pliant/models/springs.h>

namespace pliant {

/// @param argument  its name in the message
Status check_sources(const SpringNetwork& network, std::span<const std::int32_t> sources,
                     const char* argument);
Status check_depth(std::int32_t depth);

class OrderSearch {
  public:
    /// @pre sources and depth are checked. @param[out] order  has fewer nodes than sources if one
    /// occurs twice
    void run(const SpringNetwork& network, std::span<const std::int32_t> sources,
             std::int32_t depth, TransmittalOrder& order);

  private:
    std::vector<std::uint32_t> m_seen;  ///< [node]: last search that reached it
    std::uint32_t m_turn = 0;
};

}  // namespace pliant
