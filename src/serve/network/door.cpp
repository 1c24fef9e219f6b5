// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "network/door.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <random>
#include <system_error>
#include <utility>

#include "base/descriptor.h"
#include "base/errors.h"
#include "protocol/messages.h"

namespace pliant::serve {
namespace {

constexpr std::size_t kDigits = 32;

std::string random_token() {
    std::random_device device;
    std::string text;
    while (text.size() < kDigits) text += hex_text(device(), 8);
    return text;
}

bool is_token(const std::string& text) {
    return text.size() == kDigits &&
           text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

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

namespace {

constexpr std::string_view kHttp = "http://", kHttps = "https://";

std::string in_lower_case(std::string_view text) {
    std::string lower(text);
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return lower;
}

/// An origin as browsers write it. @param authority  host, or host:port
std::string origin_of(std::string_view scheme, std::string_view authority) {
    const std::string_view default_port = scheme == kHttps ? ":443" : ":80";
    if (authority.ends_with(default_port)) authority.remove_suffix(default_port.size());
    return in_lower_case(std::string(scheme).append(authority));
}

bool is_host_character(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("-._:[]").find(c) != std::string_view::npos;
}

}  // namespace

bool is_host(std::string_view text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), is_host_character);
}

OwnOrigins::OwnOrigins(std::string_view scheme, int port) : m_has_tls(scheme == "https") {
    for (const char* name : {"127.0.0.1", "localhost", "[::1]"}) add(scheme, name, port);
}

void OwnOrigins::add(std::string_view scheme, std::string_view host, int port) {
    std::string origin =
        origin_of(std::string(scheme) + "://", std::string(host) + ":" + std::to_string(port));
    if (!has(origin)) m_origins.push_back(std::move(origin));
}

bool OwnOrigins::add_url(std::string_view url) {
    const std::string_view scheme = url.starts_with(kHttps) ? kHttps : kHttp;
    if (!url.starts_with(scheme)) return false;
    url.remove_prefix(scheme.size());
    const std::string_view authority = url.substr(0, url.find('/'));
    if (!is_host(authority)) return false;
    m_origins.push_back(origin_of(scheme, authority));
    return true;
}

bool OwnOrigins::add_frame(std::string_view origin) {
    const std::string_view scheme = origin.starts_with(kHttps) ? kHttps : kHttp;
    if (!origin.starts_with(scheme)) return false;
    std::string_view host = origin.substr(scheme.size());
    if (host.ends_with(":*")) host.remove_suffix(2);
    if (!is_host(host)) return false;
    m_frames += (m_frames.empty() ? "" : " ") + std::string(origin);
    return true;
}

std::string OwnOrigins::frames() const {
    return m_frames.empty() ? "'none'" : m_frames;
}

bool OwnOrigins::has_host(std::string_view host) const {
    return !host.empty() && (has(origin_of(kHttp, host)) || has(origin_of(kHttps, host)));
}

bool OwnOrigins::has(std::string_view origin) const {
    return std::find(m_origins.begin(), m_origins.end(), origin) != m_origins.end();
}

std::string OwnOrigins::websockets() const {
    std::string sources;
    for (const std::string& origin : m_origins) {
        if (origin.find('[') != std::string::npos) continue;  // no source of a policy
        sources +=
            (sources.empty() ? "ws" : " ws") + origin.substr(std::string_view("http").size());
    }
    return sources;
}

bool is_same_secret(std::string_view a, std::string_view b) {
    unsigned difference = unsigned(a.size() != b.size());
    for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n)
        difference |= unsigned(a[n] ^ b[n]);
    return difference == 0;
}

bool TokenBucket::take(std::size_t bytes, std::chrono::steady_clock::time_point now) {
    const double seconds = std::chrono::duration<double>(now - m_at).count();
    m_at = now;
    m_messages = std::min(m_messages + seconds * kMessagesPerSecond, kMessageBurst) - 1;
    m_bytes = std::min(m_bytes + seconds * kBytesPerSecond, kByteBurst) - double(bytes);
    return m_messages >= 0 && m_bytes >= 0;
}

Tokens random_tokens() {
    return {random_token(), random_token()};
}

Result<Tokens> tokens_of_session(const std::filesystem::path& session) {
    const std::filesystem::path path = session.string() + ".links";
    const auto refused = [&](const std::string& what) {
        return unreadable(path, what + "; without the file there are new links");
    };
    const auto unwritable = [&](int error) {
        return Error{ErrorCode::Unwritable, path.string() + ": can't be written: " +
                                                std::generic_category().message(error)};
    };
    Descriptor file = open_file(path, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK, 0600);
    if (!file.is_open() && errno == ELOOP)
        return refused("is a link to another file, expected a file of its own");
    struct stat status {};
    if (!file.is_open() || ::fstat(file.number(), &status) != 0) return unwritable(errno);
    if (!S_ISREG(status.st_mode)) return refused("is no regular file, expected one");
    // The links of a file that others write or read would be theirs too.
    if (status.st_uid != ::geteuid())
        return refused("belongs to another user, expected a file of one's own");
    if ((status.st_mode & 0077) != 0)
        return refused("can be read or written by other users, expected none (chmod 600)");
    std::array<char, 2 * (kDigits + 1) + 1> bytes;
    std::size_t count = 0;
    if (const int error = read_at(file.number(), bytes.data(), bytes.size(), 0, &count))
        return unreadable(path, "can't be read: " + std::generic_category().message(error));
    if (count > 0) {
        const std::string_view text(bytes.data(), count);
        const Tokens tokens{std::string(text.substr(0, kDigits)),
                            std::string(text.substr(std::min(count, kDigits + 1), kDigits))};
        if (text == tokens.control + "\n" + tokens.view + "\n" && is_token(tokens.control) &&
            is_token(tokens.view) && tokens.control != tokens.view)
            return tokens;
        return refused("expected two different lines of 32 hexadecimal digits, found others");
    }
    // New, or left by a start that failed or was killed.
    const Tokens tokens = random_tokens();
    const std::string text = tokens.control + "\n" + tokens.view + "\n";
    int error = write_all(file.number(), text.data(), text.size());
    if (error) {
        [[maybe_unused]] const int emptied = ::ftruncate(file.number(), 0);
    }
    if (!error) error = file.close();
    if (error) return unwritable(error);
    return tokens;
}

}  // namespace pliant::serve
