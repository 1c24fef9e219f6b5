// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Manual HTTP: it shares no code with the server, and can send invalid requests.

#pragma once

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <string_view>
#include <vector>

namespace pliant::test {

inline std::string token_of(const std::string& link) {
    return link.substr(link.find("token=") + 6);
}

/// "200" of "HTTP/1.1 200 OK…"; empty where there is no answer.
inline std::string status_of(const std::string& response) {
    return response.size() > 12 ? response.substr(9, 3) : "";
}

inline std::string body_of(const std::string& response) {
    const auto end = response.find("\r\n\r\n");
    return end == std::string::npos ? "" : response.substr(end + 4);
}

/// A TCP connection to this machine. All waiting ends after some seconds.
class Connection {
  public:
    explicit Connection(int port)
        : m_port(port), m_descriptor(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(std::uint16_t(port));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        m_is_open =
            ::connect(m_descriptor, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
        const int on = 1;
        ::setsockopt(m_descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    }
    ~Connection() { ::close(m_descriptor); }
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    bool is_open() const { return m_is_open; }
    int port() const { return m_port; }
    std::string host() const { return "127.0.0.1:" + std::to_string(m_port); }
    int descriptor() const { return m_descriptor; }

    /// @returns whether all was taken
    bool send(std::string_view bytes) {
        while (!bytes.empty()) {
            pollfd waits{m_descriptor, POLLOUT, 0};
            if (::poll(&waits, 1, kPatienceMs) <= 0) return false;
            const ssize_t count =
                ::send(m_descriptor, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
            if (count <= 0) return false;
            bytes.remove_prefix(std::size_t(count));
        }
        return true;
    }
    /// @returns false at the end of the connection
    bool fill(std::size_t count) {
        std::vector<char> part(1 << 18);
        while (m_buffer.size() < count) {
            pollfd waits{m_descriptor, POLLIN, 0};
            if (::poll(&waits, 1, kPatienceMs) <= 0) return false;
            const ssize_t got = ::recv(m_descriptor, part.data(), part.size(), 0);
            if (got <= 0) return false;
            m_buffer.append(part.data(), std::size_t(got));
        }
        return true;
    }
    /// Discards received data.
    void forget() { m_buffer.clear(); }
    /// Ends sending; answers can still be read.
    void end_sending() { ::shutdown(m_descriptor, SHUT_WR); }
    /// Reads up to the blank line, then as many bytes as the length states. Empty: closed.
    std::string read_response() {
        std::size_t end = 0;
        while ((end = m_buffer.find("\r\n\r\n")) == std::string::npos)
            if (!fill(m_buffer.size() + 1)) return {};
        std::string response = m_buffer.substr(0, end + 4);
        m_buffer.erase(0, end + 4);
        const auto at = response.find("Content-Length: ");
        if (at == std::string::npos) return response;
        const auto length = std::size_t(std::stoul(response.substr(at + 16)));
        if (!fill(length)) return {};
        response += m_buffer.substr(0, length);
        m_buffer.erase(0, length);
        return response;
    }
    /// Asks for a path. @param more  further header lines, each with its end
    std::string get(const std::string& path, const std::string& host,
                    const std::string& more = "") {
        send("GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n");
        return read_response();
    }
    std::string post(const std::string& target, std::string_view body) {
        send("POST " + target + " HTTP/1.1\r\nHost: " + host() +
             "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n");
        send(body);
        return read_response();
    }

  protected:
    static constexpr int kPatienceMs = 30'000;  // far longer than anything takes

    int m_port;
    int m_descriptor;
    bool m_is_open = false;
    std::string m_buffer;
};

}  // namespace pliant::test
