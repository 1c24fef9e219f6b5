# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Boost's headers: Beast and Asio. BSL-1.0. HTTP and WebSocket of the server, with exact
# back-pressure for each client; nothing of Boost needs to be linked.
# Boost's own configuration; CMake's module, which newer CMakes warn of, where there is none.
find_package(Boost 1.74 CONFIG QUIET)
if(NOT Boost_FOUND)
    find_package(Boost 1.74 REQUIRED)
endif()
