// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "serve/door.h"

#include <algorithm>
#include <charconv>

namespace pliant::serve {

std::string_view path_of(std::string_view target) {
    return target.substr(0, target.find('?'));
}

std::string_view query_value(std::string_view target, std::string_view key) {
    const auto question = target.find('?');
    if (question == std::string_view::npos) return {};
    std::string_view left = target.substr(question + 1);
    while (!left.empty()) {
        const std::string_view pair = left.substr(0, left.find('&'));
        if (pair.size() > key.size() && pair.starts_with(key) && pair[key.size()] == '=')
            return pair.substr(key.size() + 1);
        left.remove_prefix(std::min(pair.size() + 1, left.size()));
    }
    return {};
}

std::optional<std::string> decoded(std::string_view query_value) {
    std::string text;
    for (std::size_t n = 0; n < query_value.size(); ++n) {
        if (query_value[n] != '%') {
            text += query_value[n] == '+' ? ' ' : query_value[n];
            continue;
        }
        unsigned code = 0;
        const char* digits = query_value.data() + n + 1;
        if (query_value.size() - n < 3) return {};
        const auto [end, error] = std::from_chars(digits, digits + 2, code, 16);
        if (error != std::errc{} || end != digits + 2) return {};
        text += char(code);
        n += 2;
    }
    return text;
}

bool is_own_host(std::string_view host, int port) {
    const std::string number = ":" + std::to_string(port);
    for (const std::string name : {"127.0.0.1", "localhost", "[::1]"}) {
        if (host == name + number) return true;
        if (port == 80 && host == name) return true;
    }
    return false;
}

bool is_own_origin(std::string_view origin, int port) {
    constexpr std::string_view kScheme = "http://";
    return origin.starts_with(kScheme) && is_own_host(origin.substr(kScheme.size()), port);
}

bool is_same_secret(std::string_view a, std::string_view b) {
    unsigned difference = unsigned(a.size() != b.size());
    for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n)
        difference |= unsigned(a[n] ^ b[n]);
    return difference == 0;
}

bool Allowance::take(std::size_t bytes, std::chrono::steady_clock::time_point now) {
    const double seconds = std::chrono::duration<double>(now - m_at).count();
    m_at = now;
    m_messages = std::min(m_messages + seconds * kMessagesPerSecond, kMessageBurst) - 1;
    m_bytes = std::min(m_bytes + seconds * kBytesPerSecond, kByteBurst) - double(bytes);
    return m_messages >= 0 && m_bytes >= 0;
}

}  // namespace pliant::serve
