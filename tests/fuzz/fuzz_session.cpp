// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A session's file. Damage is found by its checksums; so that the fuzzer gets past them, lines are
// also read one by one, as if each had the checksum that it should.

#include "fuzz/fuzz.h"
#include "session/session_log.h"

using namespace pliant;

namespace {

void read_line(std::string_view line) {
    if (const auto header = serve::parse_session_header(line); header.ok()) {
        const std::string text = serve::text_of(*header);
        const auto again = serve::parse_session_header(text);
        fuzz::expect(again.ok() && serve::text_of(*again) == text, "the same header again", text);
    } else {
        fuzz::expect_one_line(header.error().message);
    }
    if (const auto record = serve::parse_session_record(line); record.ok()) {
        const std::string text = serve::text_of(*record);
        const auto again = serve::parse_session_record(text);
        fuzz::expect(again.ok() && serve::text_of(*again) == text, "the same record again", text);
    } else {
        fuzz::expect_one_line(record.error().message);
    }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::string_view bytes = fuzz::text_of(data, size);
    const auto file = serve::read_session(fuzz::write_anew("s.pls", bytes));
    if (!file.ok())
        fuzz::expect_one_line(file.error().message);
    else
        fuzz::expect(file->good_bytes + file->cut_off_bytes == size, "each byte once");
    while (!bytes.empty()) {
        const std::size_t end = std::min(bytes.find('\n'), bytes.size());
        // With its checksum, and without.
        read_line(bytes.substr(0, end));
        if (end > 17) read_line(bytes.substr(17, end - 17));
        bytes.remove_prefix(std::min(end + 1, bytes.size()));
    }
    return 0;
}
