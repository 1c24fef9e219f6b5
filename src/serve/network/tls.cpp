// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "network/tls.h"

#include <arpa/inet.h>
#include <openssl/x509v3.h>

#include <array>
#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <cstddef>
#include <string_view>
#include <utility>

#include "base/errors.h"
#include "network/door.h"
#include "protocol/limits.h"

namespace pliant::serve {
namespace {

namespace asio = boost::asio;
namespace ssl = asio::ssl;
using tcp = asio::ip::tcp;
using local = asio::local::stream_protocol;
using boost::system::error_code;
using Greeted = std::function<void(tcp::socket plain)>;

/// One browser's connection.
class Relay : public std::enable_shared_from_this<Relay> {
  public:
    Relay(tcp::socket browser, ssl::context& context, Greeted welcome)
        : m_browser(std::move(browser), context),
          m_server(m_browser.get_executor()),
          m_timer(m_browser.get_executor()),
          m_welcome(std::move(welcome)) {}

    void start() {
        m_timer.expires_after(kHttpTime);
        m_timer.async_wait([self = shared_from_this()](error_code error) {
            if (!error) self->close();
        });
        m_browser.async_handshake(ssl::stream_base::server,
                                  [self = shared_from_this()](error_code error) {
                                      self->m_timer.cancel();
                                      if (error || !self->connect()) return self->close();
                                      self->move_in();
                                      self->move_out();
                                  });
    }

    bool is_greeted() const { return !m_welcome; }

    void close() {
        error_code ignored;
        m_timer.cancel();
        m_browser.lowest_layer().close(ignored);
        m_server.close(ignored);
    }

  private:
    using Piece = std::array<char, std::size_t(16) << 10>;  // of a TLS record

    /// Hands the other end of a new pair of sockets to the server.
    bool connect() {
        error_code error;
        local::socket other(m_browser.get_executor());
        asio::local::connect_pair(m_server, other, error);
        if (error) return false;
        // Asio only reads, writes and closes it, which is the same for both kinds of socket.
        tcp::socket plain(m_browser.get_executor());
        plain.assign(tcp::v4(), other.release(), error);
        if (error) return false;
        std::exchange(m_welcome, nullptr)(std::move(plain));
        return true;
    }

    void move_in() {
        m_browser.async_read_some(
            asio::buffer(m_in), [self = shared_from_this()](error_code error, std::size_t count) {
                if (error) {
                    error_code ignored;
                    self->m_server.shutdown(local::socket::shutdown_send, ignored);
                    return;
                }
                asio::async_write(self->m_server, asio::buffer(self->m_in, count),
                                  [self](error_code failed, std::size_t) {
                                      failed ? self->close() : self->move_in();
                                  });
            });
    }

    void move_out() {
        m_server.async_read_some(
            asio::buffer(m_out), [self = shared_from_this()](error_code error, std::size_t count) {
                if (error) return self->say_goodbye();
                asio::async_write(self->m_browser, asio::buffer(self->m_out, count),
                                  [self](error_code failed, std::size_t) {
                                      failed ? self->close() : self->move_out();
                                  });
            });
    }

    void say_goodbye() {
        m_timer.expires_after(kCloseTime);
        m_timer.async_wait([self = shared_from_this()](error_code error) {
            if (!error) self->close();
        });
        m_browser.async_shutdown([self = shared_from_this()](error_code) { self->close(); });
    }

    ssl::stream<tcp::socket> m_browser;
    local::socket m_server;
    asio::steady_timer m_timer;
    Greeted m_welcome;  ///< empty after the greeting
    Piece m_in, m_out;
};

/// More would make a header that browsers and proxies refuse.
constexpr std::size_t kMaxNames = 100;

/// The names for which a certificate is valid.
std::vector<std::string> names_of(const X509* certificate) {
    std::vector<std::string> names;
    auto* const all = static_cast<GENERAL_NAMES*>(
        ::X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr));
    for (int n = 0; n < sk_GENERAL_NAME_num(all); ++n) {
        const GENERAL_NAME* const name = sk_GENERAL_NAME_value(all, n);
        const ASN1_STRING* const value = name->type == GEN_DNS     ? name->d.dNSName
                                         : name->type == GEN_IPADD ? name->d.iPAddress
                                                                   : nullptr;
        if (!value) continue;
        const unsigned char* const bytes = ::ASN1_STRING_get0_data(value);
        const int size = ::ASN1_STRING_length(value);
        std::array<char, INET6_ADDRSTRLEN> text{};
        if (name->type == GEN_DNS) {
            const std::string_view dns(reinterpret_cast<const char*>(bytes), std::size_t(size));
            if (dns.find('*') == dns.npos) names.emplace_back(dns);
        } else if (size == 4 && ::inet_ntop(AF_INET, bytes, text.data(), text.size())) {
            names.emplace_back(text.data());
        } else if (size == 16 && ::inet_ntop(AF_INET6, bytes, text.data(), text.size())) {
            names.push_back(std::string("[").append(text.data()) + "]");
        }
    }
    ::GENERAL_NAMES_free(all);
    return names;
}

Error bad_file(const char* field, const char* expected, const std::string& file,
               const error_code& error) {
    return about(field, ErrorCode::InvalidArgument,
                 std::string("expected ") + expected + ", found " + file + ": " + error.message());
}

}  // namespace

struct Tls::Impl {
    ssl::context context{ssl::context::tls_server};
    std::vector<std::string> names;
    std::list<std::weak_ptr<Relay>> relays;  ///< oldest first
};

Result<std::unique_ptr<Tls>> Tls::create(const std::string& certificate, const std::string& key) {
    auto impl = std::make_unique<Impl>();
    error_code error;
    impl->context.set_options(ssl::context::default_workarounds | ssl::context::no_sslv2 |
                                  ssl::context::no_sslv3 | ssl::context::no_tlsv1 |
                                  ssl::context::no_tlsv1_1,
                              error);
    // OpenSSL takes an error of reading for the end of the chain.
    const auto chain = read_small_file(certificate, kMaxSmallFileBytes, "a certificate");
    if (!chain) return about("certificate", chain.error().code, chain.error().message);
    const auto secret = read_small_file(key, kMaxSmallFileBytes, "a private key");
    if (!secret) return about("key", secret.error().code, secret.error().message);
    impl->context.use_certificate_chain(asio::buffer(*chain), error);
    if (error) return bad_file("certificate", "a certificate in PEM", certificate, error);
    impl->context.use_private_key(asio::buffer(*secret), ssl::context::pem, error);
    if (error) return bad_file("key", "the certificate's private key in PEM", key, error);
    // Those of TLS 1.2 whose ciphers authenticate; TLS 1.3 has no others.
    ::SSL_CTX_set_cipher_list(impl->context.native_handle(), "ECDHE+AESGCM:ECDHE+CHACHA20");
    impl->names = names_of(::SSL_CTX_get0_certificate(impl->context.native_handle()));
    if (impl->names.size() > kMaxNames)
        return expected_error("certificate", "up to " + std::to_string(kMaxNames) + " names in it",
                              std::to_string(impl->names.size()));
    for (const std::string& name : impl->names)
        if (!is_host(name))
            return in_one_line(expected_error("certificate", "names of hosts in it", name));
    return std::unique_ptr<Tls>(new Tls(std::move(impl)));
}

Tls::Tls(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}
Tls::~Tls() = default;

const std::vector<std::string>& Tls::names() const {
    return m_impl->names;
}

void Tls::greet(tcp::socket browser, Greeted welcome) {
    auto& relays = m_impl->relays;
    relays.remove_if([](const auto& relay) { return relay.expired(); });
    // Closes the oldest connections whose TLS handshake is incomplete.
    std::size_t silent = 0;
    for (const auto& relay : relays) silent += !relay.lock()->is_greeted();
    if (silent >= std::size_t(kMaxConnections) / 2)
        for (const auto& relay : relays)
            if (const auto oldest = relay.lock(); !oldest->is_greeted()) {
                oldest->close();
                break;
            }
    const auto relay =
        std::make_shared<Relay>(std::move(browser), m_impl->context, std::move(welcome));
    relays.push_back(relay);
    relay->start();
}

void Tls::close() {
    for (const auto& relay : m_impl->relays)
        if (const auto open = relay.lock()) open->close();
}

}  // namespace pliant::serve
