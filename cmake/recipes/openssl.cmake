# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# OpenSSL. Apache-2.0. TLS of the server, through Asio.
find_package(OpenSSL 3 ${PLIANT_FIND})
set(PLIANT_RECIPE_FOUND ${OPENSSL_FOUND})
