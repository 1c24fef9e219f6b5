// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Header fields of all answers: the browser's security policy.

#pragma once

#include "network/hidden_boost.h"

#include <boost/beast/http.hpp>

#include "network/door.h"

namespace pliant::serve {

inline void set_common_fields(boost::beast::http::fields& fields, const OwnOrigins& own) {
    namespace http = boost::beast::http;
    fields.set(http::field::server, "pliant");
    fields.set("Content-Security-Policy",
               "default-src 'none'; script-src 'self'; style-src 'self'; "
               "img-src 'self' blob: data:; connect-src 'self' " +
                   own.websockets() + "; base-uri 'none'; form-action 'none'; frame-ancestors " +
                   own.frames());
    if (own.has_tls()) fields.set("Strict-Transport-Security", "max-age=31536000");
    fields.set("X-Content-Type-Options", "nosniff");
    fields.set("Cross-Origin-Resource-Policy", "same-origin");
    fields.set("Referrer-Policy", "no-referrer");
    fields.set(http::field::cache_control, "no-cache");
}

}  // namespace pliant::serve
