// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/header_lines.h"

#include "base/errors.h"

namespace pliant {

Result<std::optional<std::string>> HeaderLines::next() {
    ++m_number;
    std::string line;
    for (int c = m_file.get(); c != '\n'; c = m_file.get()) {
        if (c == InputFile::kEnd) {
            if (Status status = m_file.status(); !status) return status.error();
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
