# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# Boost's headers: Beast and Asio. BSL-1.0. HTTP and WebSocket of the server, with exact
# back-pressure for each client; nothing of Boost needs to be linked.
find_package(Boost 1.74 REQUIRED)
