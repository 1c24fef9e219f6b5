// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// One scene's part of a session as a separate session: the same lines with new checksums. Uploaded
// states are named without the server's folder.

#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <system_error>

#include "session/session_line.h"
#include "session/session_log.h"

namespace pliant::serve {
namespace {

Result<std::string> portable(std::string_view text) {
    if (text.find("\"do\":\"state\"") == std::string_view::npos) return std::string(text);
    auto record = parse_session_record(text);
    if (!record.ok()) return record.error();
    auto* state = std::get_if<SessionState>(&*record);
    if (!state || std::filesystem::path(state->file).is_absolute()) return std::string(text);
    state->file = std::filesystem::path(state->file).filename().string();
    return text_of(*record);
}

}  // namespace

Status write_session(const std::filesystem::path& path, const SessionPart& part,
                     const SessionMark& mark) {
    std::ofstream out(path, std::ios::binary);
    std::uint64_t chain = 0;
    out << session_line(chain, text_of(part.scene));
    std::string rest;  // of a line that continues in the next piece
    std::array<char, 1 << 16> piece;
    for (std::uint64_t at = part.begin; at < part.end;) {
        const auto wanted = std::size_t(std::min<std::uint64_t>(piece.size(), part.end - at));
        std::size_t count = 0;
        const int error = read_at(part.file->number(), piece.data(), wanted, at, &count);
        if (error || count == 0)
            return Error{ErrorCode::Unreadable,
                         "session: expected the recorded bytes, found " +
                             (error ? std::generic_category().message(error) : "the file's end")};
        at += count;
        rest.append(piece.data(), count);
        std::size_t begin = 0;
        for (std::size_t end = 0; (end = rest.find('\n', begin)) != std::string::npos;
             begin = end + 1) {
            const std::string_view line(rest.data() + begin, end - begin);
            const auto text = portable(line.substr(std::min(kChecksumDigits + 1, line.size())));
            if (!text.ok()) return text.error();
            out << session_line(chain, *text);
        }
        rest.erase(0, begin);
    }
    out << session_line(chain, text_of(SessionRecord(mark)));
    out.close();
    if (out) return Ok{};
    return Error{ErrorCode::Unwritable, path.filename().string() + ": can't be written"};
}

}  // namespace pliant::serve
