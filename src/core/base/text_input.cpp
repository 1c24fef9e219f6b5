// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/files.h>

#include <algorithm>
#include <cstdint>
#include <system_error>

#include "base/errors.h"
#include "base/input_file.h"

namespace pliant {
namespace fs = std::filesystem;

Status check_is_file(const fs::path& path, std::string_view expected) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    const std::string kind(expected);
    if (fs::is_directory(status)) return unreadable(path, "is a folder, expected " + kind);
    if (status.type() == fs::file_type::not_found)
        return Error{ErrorCode::NotFound,
                     path.string() + ": expected " + kind + " that can be read, found no file"};
    if (status.type() == fs::file_type::none)
        return Error{ErrorCode::NotFound, path.string() + ": expected " + kind +
                                              " that can be read (" + error.message() + ")"};
    if (!fs::is_regular_file(status))
        return unreadable(path, "is no regular file, expected " + kind);
    return Ok{};
}

Result<std::string> read_small_file(const fs::path& path, std::size_t max_bytes,
                                    std::string_view expected) {
    if (const Status s = check_is_file(path, expected); !s) return s.error();
    return InputFile(path).read_rest(max_bytes, expected);
}

namespace {

/// Counts brackets and dots; skips strings and comments.
class NestingScan {
  public:
    NestingScan(std::string_view text, TextSyntax syntax)
        : m_text(text), m_is_toml(syntax == TextSyntax::Toml) {}

    Status check() {
        constexpr int kMaxBrackets = 64, kMaxDots = 32;
        int brackets = 0, dots = 0;
        while (m_at < m_text.size()) {
            const char c = m_text[m_at];
            if (c == '"' || (m_is_toml && c == '\'')) {
                skip_text(c);
                continue;
            }
            if (m_is_toml && c == '#') {
                m_at = std::min(m_text.find('\n', m_at), m_text.size());
                continue;
            }
            ++m_at;
            if (c == '[' || c == '{') ++brackets;
            if ((c == ']' || c == '}') && brackets > 0) --brackets;
            if (c == '.') ++dots;
            if (std::string_view("\n=,[]{}").find(c) != std::string_view::npos) dots = 0;
            if (brackets > kMaxBrackets)
                return too_deep("lists and tables nested up to " + std::to_string(kMaxBrackets));
            if (m_is_toml && dots > kMaxDots)
                return too_deep("keys of up to " + std::to_string(kMaxDots) + " dots");
        }
        return Ok{};
    }

  private:
    /// Skips a string. An unterminated one ends with its line, or the file; the parser refuses it.
    void skip_text(char quote) {
        const std::string three(3, quote);
        if (m_is_toml && m_text.substr(m_at, 3) == three) {
            m_at += 3;
            while (m_at < m_text.size() && m_text.substr(m_at, 3) != three) skip_one(quote);
            // Up to two more quotes belong to the string.
            while (m_at < m_text.size() && m_text[m_at] == quote) ++m_at;
            return;
        }
        ++m_at;
        while (m_at < m_text.size() && m_text[m_at] != quote && m_text[m_at] != '\n')
            skip_one(quote);
        if (m_at < m_text.size() && m_text[m_at] == quote) ++m_at;
    }
    void skip_one(char quote) { m_at += quote == '"' && m_text[m_at] == '\\' ? 2 : 1; }

    Error too_deep(const std::string& expected) const {
        const auto line =
            1 + std::count(m_text.begin(), m_text.begin() + std::ptrdiff_t(m_at), '\n');
        return {ErrorCode::Unreadable,
                "line " + std::to_string(line) + ": expected " + expected + ", found more"};
    }

    std::string_view m_text;
    bool m_is_toml;
    std::size_t m_at = 0;
};

/// Length of the well-formed UTF-8 sequence at the start; 0: none.
std::size_t sequence_length(std::string_view text) {
    const auto byte = [&](std::size_t n) { return static_cast<unsigned char>(text[n]); };
    const unsigned char first = byte(0);
    const std::size_t length = first < 0x80   ? 1
                               : first < 0xc2 ? 0
                               : first < 0xe0 ? 2
                               : first < 0xf0 ? 3
                               : first < 0xf5 ? 4
                                              : 0;
    if (length == 0 || length > text.size()) return 0;
    std::uint32_t code = length == 1 ? first : first & (0x7fu >> length);
    for (std::size_t n = 1; n < length; ++n) {
        if ((byte(n) & 0xc0) != 0x80) return 0;
        code = code << 6 | (byte(n) & 0x3f);
    }
    constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool is_surrogate = code >= 0xd800 && code < 0xe000;
    return code < kLeast[length] || code > 0x10ffff || is_surrogate ? 0 : length;
}

bool is_control(std::string_view sequence) {
    const auto first = static_cast<unsigned char>(sequence[0]);
    if (sequence.size() == 1) return first < 0x20 || first == 0x7f;
    // U+0080 to U+009F are control characters in some terminals; U+2028 and U+2029 end lines,
    // U+202A to U+202E and U+2066 to U+2069 change the text direction.
    if (sequence.size() == 2 && first == 0xc2)
        return static_cast<unsigned char>(sequence[1]) < 0xa0;
    return sequence.size() == 3 && ((sequence.substr(0, 2) == "\xe2\x80" && sequence[2] >= '\xa8' &&
                                     sequence[2] <= '\xae') ||
                                    (sequence.substr(0, 2) == "\xe2\x81" && sequence[2] >= '\xa6' &&
                                     sequence[2] <= '\xa9'));
}

/// Whether a cut before this byte leaves whole characters.
bool is_start(char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
}

}  // namespace

Status check_nesting(std::string_view text, TextSyntax syntax) {
    return NestingScan(text, syntax).check();
}

std::string shown(std::string_view text) {
    constexpr std::size_t kMost = 60;
    std::string result(text.substr(0, kMost));
    for (char& c : result)
        if (c < ' ' || c > '~') c = '?';
    return text.size() > kMost ? result + "…" : result;
}

std::string printable(std::string_view text, std::size_t max_bytes) {
    std::string line;
    while (!text.empty()) {
        const std::size_t length = sequence_length(text);
        if (line.size() + std::max<std::size_t>(length, 1) > max_bytes) return line + "…";
        if (text[0] == '\n' || text[0] == '\r' || text[0] == '\t')
            line += ' ';
        else if (length == 0 || is_control(text.substr(0, length)))
            line += '?';
        else
            line.append(text.substr(0, length));
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return line;
}

std::string one_line(std::string_view message) {
    constexpr std::size_t kMost = 400, kHead = 180, kTail = 210;
    if (message.size() <= kMost) return printable(message);
    std::size_t head = kHead, tail = message.size() - kTail;
    while (head > 0 && !is_start(message[head])) --head;
    while (tail < message.size() && !is_start(message[tail])) ++tail;
    return printable(message.substr(0, head)) + " … " + printable(message.substr(tail));
}

}  // namespace pliant
