// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/header_lines.h"

#include "base/errors.h"

namespace pliant {

Result<std::optional<std::string>> HeaderLines::next() {
    ++m_number;
    std::streambuf& source = *m_file.rdbuf();
    constexpr int kEnd = std::streambuf::traits_type::eof();
    std::string line;
    for (int c = source.sbumpc(); c != '\n'; c = source.sbumpc()) {
        if (c == kEnd) {
            if (line.empty()) return std::optional<std::string>();
            break;
        }
        ++m_bytes_read;
        line += char(c);
        if (line.size() > kMaxHeaderLineBytes)
            return unreadable(m_path, "line " + std::to_string(m_number) +
                                          " of its header has more than " +
                                          std::to_string(kMaxHeaderLineBytes) + " bytes");
    }
    ++m_bytes_read;
    if (m_bytes_read > kMaxHeaderBytes)
        return unreadable(m_path,
                          "its header has more than " + std::to_string(kMaxHeaderBytes) + " bytes");
    if (line.ends_with('\r')) line.pop_back();
    return std::optional(std::move(line));
}

}  // namespace pliant
