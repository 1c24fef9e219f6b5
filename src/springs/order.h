// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The breadth-first search, with memory that is kept from one to the next.

#pragma once

#include <pliant/springs.h>

namespace pliant {

/// @param what  names the argument in the message
Status check_sources(const SpringNetwork& network, std::span<const std::int32_t> sources,
                     const char* what);
Status check_depth(std::int32_t depth);

class OrderSearch {
  public:
    /// @pre sources and depth are checked. @param[out] order  nodes may be fewer than sources,
    /// where one comes twice
    void run(const SpringNetwork& network, std::span<const std::int32_t> sources,
             std::int32_t depth, TransmittalOrder& order);

  private:
    std::vector<std::uint32_t> m_seen;  ///< [node]: the turn in which it was
    std::uint32_t m_turn = 0;
};

}  // namespace pliant
