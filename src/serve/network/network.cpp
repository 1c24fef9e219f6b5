// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "network/network.h"

#include "network/hidden_boost.h"

#include <algorithm>
#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <deque>
#include <limits>
#include <list>
#include <map>
#include <optional>

#include "base/errors.h"
#include "network/door.h"
#include "network/http_answer.h"
#include "network/page.h"
#include "network/transfers.h"
#include "protocol/limits.h"
#include "session/guarded.h"

namespace pliant::serve {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using boost::system::error_code;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

std::string_view view_of(beast::string_view text) {
    return {text.data(), text.size()};
}

class HttpConnection;
class WebSocketConnection;

}  // namespace

struct Network::Impl {
    Impl(Hub& h, Tokens t, TransferSettings s, std::unique_ptr<Tls> front)
        : hub(h),
          tokens(std::move(t)),
          tls(std::move(front)),
          acceptor(context),
          grace(context),
          transfers(context, h, tokens, std::move(s)) {}

    void accept();
    void welcome(tcp::socket socket);
    void forget(ConnectionId connection);
    void end_if_empty();

    Hub& hub;
    const Tokens tokens;
    asio::io_context context{1};
    const std::unique_ptr<Tls> tls;  ///< null: plain HTTP
    std::optional<OwnOrigins> own;   ///< set before the first connection
    std::string url;
    tcp::acceptor acceptor;
    asio::steady_timer grace;
    int port = 0;
    bool stopping = false;
    ConnectionId last_id = 0;
    std::list<std::weak_ptr<HttpConnection>> guests;  ///< oldest first
    std::map<ConnectionId, std::shared_ptr<WebSocketConnection>> clients;
    Transfers transfers;
};

namespace {

/// A client with a valid token.
class WebSocketConnection : public std::enable_shared_from_this<WebSocketConnection> {
  public:
    WebSocketConnection(Network::Impl& network, ConnectionId id, beast::tcp_stream&& stream,
                        bool may_control)
        : m_network(network),
          m_id(id),
          m_may_control(may_control),
          m_socket(std::move(stream)),
          m_force(network.context),
          m_again(network.context),
          m_bucket(std::chrono::steady_clock::now()) {}

    void accept(const Request& request) {
        beast::get_lowest_layer(m_socket).expires_never();
        m_socket.set_option(websocket::stream_base::timeout{kHttpTime, kSilentTime, true});
        m_socket.auto_fragment(false);
        m_socket.read_message_max(kMaxMessageBytes);
        m_socket.async_accept(request, [self = shared_from_this()](error_code error) {
            if (error) return self->finish();
            self->m_open = true;
            self->m_network.hub.post({self->m_id, Event::Opened{self->m_may_control}});
            self->read();
        });
    }

    void send(std::vector<Outgoing> batch) {
        if (m_closing) return;
        for (Outgoing& message : batch) m_queue.push_back(std::move(message));
        m_is_batch = true;
        write();
    }

    void close(int code, const std::string& message) {
        if (m_closing || m_finished) return;
        m_closing = true;
        constexpr std::size_t kMaxReason = 120;
        m_reason = {std::uint16_t(code), message.substr(0, kMaxReason)};
        // The message being written must be completed; waiting ones are dropped.
        while (m_queue.size() > (m_writing ? 1U : 0U)) m_queue.pop_back();
        m_queue.push_back({true, std::make_shared<const std::string>(bye_text(code, message))});
        m_force.expires_after(kCloseTime);
        m_force.async_wait([self = shared_from_this()](error_code error) {
            if (!error) self->finish();
        });
        write();
    }

    void taken() {
        --m_untaken;
        if (m_paused && m_untaken < kMaxUntaken) {
            m_paused = false;
            read();
        }
    }

    void finish() {
        if (m_finished) return;
        m_finished = m_closing = true;
        m_force.cancel();
        m_again.cancel();
        error_code ignored;
        beast::get_lowest_layer(m_socket).socket().close(ignored);
        if (m_open) m_network.hub.post({m_id, Event::Closed{}});
        m_network.forget(m_id);
    }

  private:
    void read() {
        if (m_closing) return;
        if (m_untaken >= kMaxUntaken) {
            m_paused = true;
            return;
        }
        m_socket.async_read(m_buffer, [self = shared_from_this()](error_code error, std::size_t) {
            if (error) {
                // During the closing handshake, the end of reading is expected.
                if (!self->m_closing) self->finish();
            } else if (!self->m_closing) {
                self->handle_or_wait();
            }
        });
    }

    /// Handles a message, or leaves it in the buffer for a while if memory is lacking.
    void handle_or_wait() {
        try {
            handle_message();
        } catch (const std::bad_alloc&) {
            m_again.expires_after(std::chrono::milliseconds(50));
            m_again.async_wait([self = shared_from_this()](error_code error) {
                if (!error && !self->m_closing) self->handle_or_wait();
            });
        }
    }

    void handle_message() {
        const auto data = m_buffer.cdata();
        const std::string_view text(static_cast<const char*>(data.data()), data.size());
        if (!m_socket.got_text())
            return close(kCloseProtocol, "expected text messages, found a binary one");
        if (!m_bucket.take(text.size(), std::chrono::steady_clock::now()))
            return close(kCloseFlood,
                         "expected up to 240 messages and 1 MiB per second, found more");
        auto parsed = parse_message(text);
        if (auto* message = std::get_if<Message>(&parsed)) {
            m_network.hub.post({m_id, std::move(*message)});
        } else {
            auto& failure = *std::get_if<ParseFailure>(&parsed);
            if (failure.rubbish) return close(kCloseProtocol, failure.message);
            m_network.hub.post({m_id, std::move(failure)});
        }
        ++m_untaken;
        m_buffer.consume(m_buffer.size());
        read();
    }

    void write() {
        if (m_writing || m_finished) return;
        if (m_queue.empty()) {
            if (m_closing) return close_socket();
            if (std::exchange(m_is_batch, false)) m_network.hub.post({m_id, Event::Written{}});
            return;
        }
        m_writing = true;
        m_socket.text(m_queue.front().is_text);
        m_socket.async_write(asio::buffer(*m_queue.front().bytes),
                             [self = shared_from_this()](error_code error, std::size_t) {
                                 self->m_writing = false;
                                 if (error) return self->finish();
                                 self->m_queue.pop_front();
                                 self->write();
                             });
    }

    void close_socket() {
        const websocket::close_reason reason(websocket::close_code(m_reason.first),
                                             m_reason.second);
        m_writing = true;
        m_socket.async_close(reason, [self = shared_from_this()](error_code) { self->finish(); });
    }

    Network::Impl& m_network;
    const ConnectionId m_id;
    const bool m_may_control;
    websocket::stream<beast::tcp_stream> m_socket;
    beast::flat_buffer m_buffer;
    asio::steady_timer m_force, m_again;
    std::deque<Outgoing> m_queue;  ///< the first one is being written
    TokenBucket m_bucket;
    int m_untaken = 0;
    bool m_paused = false;
    bool m_open = false, m_writing = false, m_is_batch = false;
    bool m_closing = false, m_finished = false;
    std::pair<std::uint16_t, std::string> m_reason;
};

/// An unauthenticated connection.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
  public:
    HttpConnection(Network::Impl& network, tcp::socket socket)
        : m_network(network), m_stream(std::move(socket)), m_buffer(2 * kMaxHeaderBytes) {}

    void read() {
        m_parser.emplace();
        m_parser->header_limit(kMaxHeaderBytes);
        // The body isn't read here. (In Boost 1.74 "no limit" is always exceeded.)
        m_parser->body_limit(std::numeric_limits<std::uint64_t>::max());
        m_stream.expires_after(kHttpTime);
        http::async_read_header(m_stream, m_buffer, *m_parser,
                                [self = shared_from_this()](error_code error, std::size_t) {
                                    if (error) return self->refuse_malformed(error);
                                    self->answer(self->m_parser->get());
                                });
    }

    void close() {
        error_code ignored;
        m_stream.socket().shutdown(tcp::socket::shutdown_both, ignored);
        m_stream.socket().close(ignored);
    }

  private:
    /// Answers a malformed request; a closed connection gets no answer.
    void refuse_malformed(error_code error) {
        static const auto* const of_http = &make_error_code(http::error::bad_method).category();
        if (error.category() != *of_http || error == http::error::end_of_stream ||
            error == http::error::partial_message)
            return close();
        const bool is_long = error == http::error::header_limit;
        refuse({},
               is_long ? http::status::request_header_fields_too_large : http::status::bad_request,
               is_long ? "expected up to 8 KiB of header" : "expected a request of HTTP");
    }

    void answer(const Request& request) {
        const std::string_view target = view_of(request.target());
        const OwnOrigins& own = *m_network.own;
        const auto origin = request.find(http::field::origin);
        if (request.count(http::field::host) != 1 || request.count(http::field::origin) > 1)
            return refuse(request, http::status::bad_request, "Host, Origin: expected one of each");
        if (!own.has_host(view_of(request[http::field::host])))
            return refuse(request, http::status::forbidden, "Host: expected this server's name");
        if (origin != request.end() && !own.has(view_of(origin->value())))
            return refuse(request, http::status::forbidden, "Origin: expected this server's page");
        if (Transfers::takes(path_of(target)))
            return m_network.transfers.begin({std::move(m_stream), std::move(m_buffer),
                                              std::make_unique<BodyParser>(std::move(*m_parser)),
                                              own});
        if (!m_parser->is_done())
            return refuse(request, http::status::bad_request, "expected a body with files only");
        if (path_of(target) == "/ws") return upgrade(request, query_value(target, "token"));
        if (request.method() != http::verb::get && request.method() != http::verb::head)
            return refuse(request, http::status::method_not_allowed, "expected GET or HEAD");
        if (!target.starts_with("/"))
            return refuse(request, http::status::bad_request, "expected a path");
        const PageFile* file = find_page_file(path_of(target).substr(1));
        if (!file) return refuse(request, http::status::not_found, "there is no such file");
        Response response(http::status::ok, request.version());
        response.set(http::field::content_type, std::string(media_type(file->name)));
        response.body() = file->bytes;
        response.keep_alive(request.keep_alive());
        reply(request, std::move(response));
    }

    void upgrade(const Request& request, std::string_view token) {
        const bool may_control = is_same_secret(token, m_network.tokens.control);
        if (!may_control && !is_same_secret(token, m_network.tokens.view))
            return refuse(request, http::status::forbidden, "token: expected that of the link");
        if (!websocket::is_upgrade(request))
            return refuse(request, http::status::bad_request, "expected a WebSocket's upgrade");
        // All clients, and as many connections again before their hello.
        if (m_network.clients.size() >= 2 * std::size_t(kMaxClients) || m_network.stopping)
            return refuse(request, http::status::service_unavailable, "too many connections");
        const ConnectionId id = ++m_network.last_id;
        auto client =
            std::make_shared<WebSocketConnection>(m_network, id, std::move(m_stream), may_control);
        m_network.clients.emplace(id, client);
        client->accept(request);
    }

    /// The connection ends: following bytes may be the body of the refused request.
    void refuse(const Request& request, http::status status, const char* message) {
        Response response(status, request.version());
        response.keep_alive(false);
        response.set(http::field::content_type, "text/plain; charset=utf-8");
        response.body() = std::string(message) + "\n";
        reply(request, std::move(response));
    }

    void reply(const Request& request, Response response) {
        set_common_fields(response, *m_network.own);
        response.content_length(response.body().size());
        if (request.method() == http::verb::head) response.body().clear();
        m_response = std::make_shared<Response>(std::move(response));
        m_stream.expires_after(kHttpTime);
        http::async_write(m_stream, *m_response,
                          [self = shared_from_this()](error_code error, std::size_t) {
                              if (error || !self->m_response->keep_alive()) return self->close();
                              self->m_response.reset();
                              self->read();
                          });
    }

    Network::Impl& m_network;
    beast::tcp_stream m_stream;
    beast::flat_buffer m_buffer;
    std::optional<http::request_parser<http::empty_body>> m_parser;
    std::shared_ptr<Response> m_response;
};

}  // namespace

void Network::Impl::accept() {
    acceptor.async_accept([this](error_code error, tcp::socket socket) {
        if (stopping) return;
        if (!error) {
            // A failure closes one connection only.
            guarded("network", [&] {
                if (!tls) return welcome(std::move(socket));
                tls->greet(std::move(socket),
                           [this](tcp::socket plain) { welcome(std::move(plain)); });
            });
            return accept();
        }
        // Perhaps no descriptors are left; retry after a moment.
        grace.expires_after(std::chrono::milliseconds(50));
        grace.async_wait([this](error_code cancelled) {
            if (!cancelled && !stopping) accept();
        });
    });
}

void Network::Impl::welcome(tcp::socket socket) {
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    guests.remove_if([](const auto& guest) { return guest.expired(); });
    // The connection with the longest silence is evicted.
    if (guests.size() >= std::size_t(kMaxConnections) / 2) {
        if (const auto oldest = guests.front().lock()) oldest->close();
        guests.pop_front();
    }
    const auto guest = std::make_shared<HttpConnection>(*this, std::move(socket));
    guests.push_back(guest);
    guest->read();
}

void Network::Impl::forget(ConnectionId connection) {
    clients.erase(connection);
    end_if_empty();
}

void Network::Impl::end_if_empty() {
    if (stopping && clients.empty()) context.stop();
}

namespace {

/// The host of a URL for an address.
std::string host_of(const asio::ip::address& address) {
    return address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
}

std::string page_url(const std::string& url, const Tls* tls, const asio::ip::address& ip,
                     int port) {
    if (!url.empty()) return url.ends_with('/') ? url : url + "/";
    std::string host = ip.is_unspecified() ? "127.0.0.1" : host_of(ip);
    if (tls && !tls->names().empty()) host = tls->names().front();
    return (tls ? "https://" : "http://") + host + ":" + std::to_string(port) + "/";
}

}  // namespace

Result<std::unique_ptr<Network>> Network::listen(Address address, Tokens tokens, Hub& hub,
                                                 TransferSettings transfers) {
    error_code error;
    const asio::ip::address ip = asio::ip::make_address(address.host, error);
    if (error)
        return about(
            "host", ErrorCode::InvalidArgument,
            "expected an address of this machine, such as 0.0.0.0 for all, found " + address.host);
    if (!ip.is_loopback() && !address.tls)
        return about("host", ErrorCode::InvalidArgument,
                     "expected a certificate too, since links are secrets, found " + address.host +
                         " without one");
    const bool has_tls = address.tls != nullptr;
    auto impl = std::make_unique<Impl>(hub, std::move(tokens), std::move(transfers),
                                       std::move(address.tls));
    const tcp::endpoint endpoint(ip, std::uint16_t(address.port));
    impl->acceptor.open(endpoint.protocol(), error);
    if (!error) impl->acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) impl->acceptor.bind(endpoint, error);
    if (!error) impl->acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error)
        return about("port", ErrorCode::InvalidArgument,
                     "expected one that can be listened to, found " + std::to_string(address.port) +
                         ": " + error.message());
    impl->port = impl->acceptor.local_endpoint(error).port();
    const char* const scheme = has_tls ? "https" : "http";
    impl->own.emplace(scheme, impl->port);
    if (!ip.is_unspecified()) impl->own->add(scheme, host_of(ip), impl->port);
    if (has_tls)
        for (const std::string& name : impl->tls->names()) impl->own->add(scheme, name, impl->port);
    if (!address.url.empty() && !impl->own->add_url(address.url))
        return about("url", ErrorCode::InvalidArgument,
                     "expected http(s)://name[:port][/path], found " + address.url);
    for (const std::string& origin : address.embed_in)
        if (!impl->own->add_frame(origin))
            return about("embed_in", ErrorCode::InvalidArgument,
                         "expected http(s)://name[:port], found " + origin);
    impl->url = page_url(address.url, impl->tls.get(), ip, impl->port);
    impl->accept();
    return std::unique_ptr<Network>(new Network(std::move(impl)));
}

Network::Network(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
Network::~Network() = default;

int Network::port() const {
    return m_impl->port;
}
const std::string& Network::url() const {
    return m_impl->url;
}

void Network::run() {
    // A handler without memory is lost, and with it at most its connection.
    while (!guarded("network", [&] { m_impl->context.run(); })) continue;
    // Connections refer to the context, so they are destroyed before it.
    m_impl->clients.clear();
    if (m_impl->tls) m_impl->tls->close();
}

void Network::stop() {
    asio::post(m_impl->context, [impl = m_impl.get()] {
        impl->stopping = true;
        error_code ignored;
        impl->acceptor.close(ignored);
        impl->grace.expires_after(std::chrono::milliseconds(500));
        impl->grace.async_wait([impl](error_code) { impl->context.stop(); });
        impl->end_if_empty();
    });
}

void Network::send(ConnectionId connection, std::vector<Outgoing> batch) {
    asio::post(m_impl->context,
               [impl = m_impl.get(), connection, sent = std::move(batch)]() mutable {
                   const auto found = impl->clients.find(connection);
                   if (found != impl->clients.end()) found->second->send(std::move(sent));
               });
}

void Network::close(ConnectionId connection, int code, const std::string& message) {
    asio::post(m_impl->context, [impl = m_impl.get(), connection, code, message] {
        const auto found = impl->clients.find(connection);
        if (found == impl->clients.end()) return;
        const auto kept = found->second;
        kept->close(code, message);
    });
}

void Network::taken(ConnectionId connection) {
    asio::post(m_impl->context, [impl = m_impl.get(), connection] {
        const auto found = impl->clients.find(connection);
        if (found == impl->clients.end()) return;
        const auto kept = found->second;
        kept->taken();
    });
}

}  // namespace pliant::serve
