// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A client's text. Every accepted message round-trips.

#include "fuzz/fuzz.h"
#include "protocol/commands.h"
#include "session/session_log.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto parsed = serve::parse_message(fuzz::text_of(data, size));
    const auto* message = std::get_if<serve::Message>(&parsed);
    if (!message) {
        fuzz::expect_one_line(std::get_if<serve::ParseFailure>(&parsed)->message);
        return 0;
    }
    const std::string text = serve::text_of(*message);
    const auto again = serve::parse_message(text);
    const auto* same = std::get_if<serve::Message>(&again);
    fuzz::expect(same, "what was written can be read", text);
    fuzz::expect(serve::text_of(*same) == text, "the same text again", text);
    if (!serve::is_command(message->action)) return 0;
    const std::string line = serve::text_of(serve::SessionCommand{7, message->action, false});
    const auto record = serve::parse_session_record(line);
    fuzz::expect(record.ok(), "a record that can be read", line);
    fuzz::expect(serve::text_of(*record) == line, "the same record again", line);
    return 0;
}
