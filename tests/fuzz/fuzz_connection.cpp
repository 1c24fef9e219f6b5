// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A whole server, and a connection with arbitrary input: from the first byte on (if the first byte
// of the input is even), or after a WebSocket's upgrade and hello. The rest of the input consists
// of frames, or of bytes that resemble them.

#include <pliant/serve.h>

#include "fuzz/fuzz.h"
#include "hub/test_client.h"

using namespace pliant;

namespace {

/// A text frame as browsers send it, with a mask of zeros.
std::string frame_of(std::string_view text) {
    std::string frame{char(0x81), char(0x80 | text.size())};
    return frame + std::string(4, '\0') + std::string(text);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const TaskArena arena(1);
    static const auto server = Server::start({.phantom_size = {8, 8, 8}}, arena);
    fuzz::expect(server.ok(), "a server");
    if (size == 0) return 0;
    const std::string_view bytes = fuzz::text_of(data + 1, size - 1);
    test::RawConnection connection(server->port());
    if (data[0] % 2) {
        const std::string status = connection.upgrade(test::token_of(server->link()));
        // There may be too many that have not gone yet.
        if (!status.starts_with("HTTP/1.1 101")) return 0;
        connection.send(frame_of(R"({"do":"hello","protocol":2})"));
    }
    connection.send(bytes);
    connection.end_sending();
    while (connection.fill(1)) connection.forget();
    // The page is still there in every case.
    static int runs = 0;
    if (++runs % 64 == 0) {
        const std::string host = "127.0.0.1:" + std::to_string(server->port());
        const std::string page = test::RawConnection(server->port()).get("/", host);
        fuzz::expect(page.starts_with("HTTP/1.1 200"), "the page", page.substr(0, 80));
    }
    return 0;
}
