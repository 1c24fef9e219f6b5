// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Unauthenticated input: a request as Boost.Beast parses it with our limits, and the door's
// interpretation of its fields.

#include <boost/beast/http.hpp>

#include "fuzz/fuzz.h"
#include "network/door.h"
#include "network/page.h"

using namespace pliant;

namespace {

void look_at(std::string_view target, std::string_view host, std::string_view origin) {
    const std::string_view path = serve::path_of(target),
                           token = serve::query_value(target, "token");
    fuzz::expect(target.starts_with(path), "a path that begins the target");
    fuzz::expect(path.find('?') == path.npos, "a path without a query");
    fuzz::expect(token.find('&') == token.npos, "one value");
    fuzz::expect(token.empty() || target.find("token=" + std::string(token)) != target.npos,
                 "a value that stands in the target");
    if (!path.empty()) (void)serve::find_page_file(path.substr(1));
    const std::string known(host.substr(0, host.rfind(':')));
    static const serve::OwnOrigins own("http", 8080);
    fuzz::expect(
        !own.has_host(host) || known == "127.0.0.1" || known == "localhost" || known == "[::1]",
        "this machine's names only", std::string(host));
    fuzz::expect(!own.has(origin) || origin.starts_with("http://"), "this server's pages only",
                 std::string(origin));
    fuzz::expect(serve::is_same_secret(host, origin) == (host == origin), "equal secrets");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    namespace http = boost::beast::http;
    const std::string_view bytes = fuzz::text_of(data, size);
    look_at(bytes, bytes, bytes);
    http::request_parser<http::empty_body> parser;
    parser.header_limit(serve::kMaxHeaderBytes);
    parser.body_limit(0);
    parser.eager(true);
    boost::beast::error_code error;
    std::size_t at = 0;
    // As it comes from a socket: a few bytes more each time.
    for (std::size_t end = 1; !error && !parser.is_done() && at < size; end += 1 + end / 2) {
        const std::size_t last = std::min(end, size);
        if (last <= at) continue;
        at += parser.put(boost::asio::buffer(data + at, last - at), error);
        if (error == http::error::need_more && last < size) error = {};
        if (last == size) break;
    }
    if (!parser.is_header_done()) return 0;
    const auto& request = parser.get();
    const auto view = [](auto text) { return std::string_view(text.data(), text.size()); };
    look_at(view(request.target()), view(request[http::field::host]),
            view(request[http::field::origin]));
    return 0;
}
