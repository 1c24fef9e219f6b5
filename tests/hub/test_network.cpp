// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The server for other machines: with a certificate, and behind a proxy; links of a session.
// Covers: network/network.cpp, network/page.cpp, network/tls.cpp, network/door.cpp.

#include "network/hidden_boost.h"

#include <gtest/gtest.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>

#include <array>
#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "hub/test_client.h"
#include "support/certificate.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

namespace asio = boost::asio;
namespace ssl = asio::ssl;
using tcp = asio::ip::tcp;

/// A proxy of the tests: encrypts each connection to its port, and passes it on to the server. It
/// refuses a server whose certificate it doesn't trust.
class Encrypting {
  public:
    Encrypting(const std::filesystem::path& trusted, const std::string& name) : m_name(name) {
        m_ssl.load_verify_file(trusted.string());
        m_ssl.set_verify_mode(ssl::verify_peer);
    }
    ~Encrypting() { m_context.stop(); }

    /// Speaks TLS 1.2 with these ciphers alone.
    void use_ciphers(const char* list) {
        SSL_CTX_set_max_proto_version(m_ssl.native_handle(), TLS1_2_VERSION);
        EXPECT_TRUE(SSL_CTX_set_cipher_list(m_ssl.native_handle(), list));
    }

    int port() const { return m_acceptor.local_endpoint().port(); }
    void pass_on_to(int port) {
        m_to = port;
        accept();
        m_thread = std::jthread([this] { m_context.run(); });
    }

  private:
    struct Connection {
        Connection(tcp::socket plain, ssl::context& context)
            : client(std::move(plain)), server(client.get_executor(), context) {}
        tcp::socket client;
        ssl::stream<tcp::socket> server;
        std::array<std::array<char, 4096>, 2> data;
    };
    using Shared = std::shared_ptr<Connection>;

    void accept() {
        m_acceptor.async_accept([this](boost::system::error_code error, tcp::socket socket) {
            if (error) return;
            const auto made = std::make_shared<Connection>(std::move(socket), m_ssl);
            made->server.set_verify_callback(ssl::host_name_verification(m_name));
            boost::system::error_code failed;
            made->server.lowest_layer().connect(
                {asio::ip::address_v4::loopback(), std::uint16_t(m_to)}, failed);
            if (!failed) made->server.handshake(ssl::stream_base::client, failed);
            if (!failed) {
                move(made, made->client, made->server, 0);
                move(made, made->server, made->client, 1);
            }
            accept();
        });
    }
    template <class From, class To>
    void move(const Shared& made, From& from, To& to, std::size_t way) {
        from.async_read_some(
            asio::buffer(made->data[way]),
            [this, made, &from, &to, way](boost::system::error_code error, std::size_t count) {
                if (error) return end(*made);
                asio::async_write(
                    to, asio::buffer(made->data[way], count),
                    [this, made, &from, &to, way](boost::system::error_code failed, std::size_t) {
                        if (failed) return end(*made);
                        move(made, from, to, way);
                    });
            });
    }
    static void end(Connection& made) {
        boost::system::error_code ignored;
        made.client.close(ignored);
        made.server.lowest_layer().close(ignored);
    }

    asio::io_context m_context{1};
    ssl::context m_ssl{ssl::context::tls_client};
    tcp::acceptor m_acceptor{m_context, {asio::ip::address_v4::loopback(), 0}};
    const std::string m_name;
    int m_to = 0;
    std::jthread m_thread;
};

class ServedToOthers : public ::testing::Test {
  protected:
    std::string refused(ServerSettings settings) {
        settings.phantom_size = {16, 16, 16};
        const auto server = Server::start(settings, m_arena);
        return server.ok() ? "" : server.error().message;
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_folder;
};

TEST_F(ServedToOthers, ACertificateEncryptsPageSceneAndFiles) {
    const Certificate own =
        make_certificate(m_folder.path(), "own", "DNS:class.example,DNS:*.example,IP:127.0.0.1");
    Encrypting proxy(own.file, "class.example");
    auto server = Server::start({.phantom_size = {48, 48, 48},
                                 .certificate = own.file.string(),
                                 .key = own.key.string(),
                                 .url = "http://127.0.0.1:" + std::to_string(proxy.port())},
                                m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    proxy.pass_on_to(server->port());
    EXPECT_TRUE(server->link().starts_with("http://127.0.0.1:" + std::to_string(proxy.port()) +
                                           "/#token="));

    TestClient client(proxy.port(), server->link());
    client.enter();
    client.command({{"do", "push"}, {"point", {0, 0, 0}}, {"push", {3, 0, 0}}, {"radius", 8}});
    const Json sum = client.checked_checksum();
    ASSERT_TRUE(sum.is_object());
    RawConnection page(proxy.port());
    page.send("GET / HTTP/1.1\r\nHost: " + page.host() + "\r\n\r\n");
    EXPECT_TRUE(page.read_response().starts_with("HTTP/1.1 200 "));
    RawConnection download(proxy.port());
    download.send("GET /save/volume.nrrd?token=" + token_of(server->link()) +
                  " HTTP/1.1\r\nHost: " + download.host() + "\r\n\r\n");
    const std::string response = download.read_response();
    const auto begin = response.find("\r\n\r\n");
    ASSERT_NE(begin, std::string::npos);
    const auto volume = read_volume(m_folder.write("volume.nrrd", response.substr(begin + 4)));
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016lx", static_cast<unsigned long>(hash_volume(*volume)));
    EXPECT_EQ(sum["volume"], hash);

    // Plain text gets no answer, and another certificate isn't trusted.
    RawConnection plain(server->port());
    plain.send("GET / HTTP/1.1\r\nHost: " + plain.host() + "\r\n\r\n");
    EXPECT_EQ(plain.read_response().find("200 OK"), std::string::npos);
    const Certificate other =
        make_certificate(m_folder.path(), "other", "DNS:class.example,IP:127.0.0.1");
    Encrypting distrusting(other.file, "class.example");
    distrusting.pass_on_to(server->port());
    RawConnection none(distrusting.port());
    none.send("GET / HTTP/1.1\r\nHost: " + none.host() + "\r\n\r\n");
    EXPECT_EQ(none.read_response(), "");
}

TEST_F(ServedToOthers, EncryptionIsAuthenticatedAndStaysOn) {
    const Certificate own = make_certificate(m_folder.path(), "own", "DNS:class.example");
    auto server = Server::start(
        {.phantom_size = {16, 16, 16}, .certificate = own.file.string(), .key = own.key.string()},
        m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    const auto page = [&](const char* ciphers) {
        Encrypting proxy(own.file, "class.example");
        proxy.use_ciphers(ciphers);
        proxy.pass_on_to(server->port());
        return RawConnection(proxy.port())
            .get("/", "class.example:" + std::to_string(server->port()));
    };
    const std::string good = page("ECDHE-ECDSA-AES128-GCM-SHA256");
    EXPECT_TRUE(good.starts_with("HTTP/1.1 200"));
    EXPECT_NE(good.find("Strict-Transport-Security: max-age=31536000\r\n"), std::string::npos);
    EXPECT_TRUE(page("ECDHE-ECDSA-CHACHA20-POLY1305").starts_with("HTTP/1.1 200"));
    EXPECT_EQ(page("ECDHE-ECDSA-AES128-SHA256"), "") << "CBC";
    EXPECT_EQ(page("ECDHE-ECDSA-AES256-SHA"), "") << "CBC";
}

TEST_F(ServedToOthers, LinksHaveTheCertificatesFirstName) {
    const Certificate own =
        make_certificate(m_folder.path(), "own", "DNS:*.example,DNS:Class.example,IP:::1");
    const ServerSettings settings{.phantom_size = {16, 16, 16},
                                  .host = "0.0.0.0",
                                  .certificate = own.file.string(),
                                  .key = own.key.string()};
    auto server = Server::start(settings, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    EXPECT_TRUE(server->link().starts_with(
        "https://Class.example:" + std::to_string(server->port()) + "/#token="))
        << server->link();
}

TEST_F(ServedToOthers, AProxysNameIsAnsweredAndNoOther) {
    auto server = Server::start(
        {.phantom_size = {16, 16, 16}, .url = "https://class.example/pliant"}, m_arena);
    ASSERT_TRUE(server.ok()) << server.error().message;
    EXPECT_TRUE(server->link().starts_with("https://class.example/pliant/#token="));
    const std::string token = token_of(server->link());
    const auto answer = [&](const std::string& host, const std::string& origin) {
        return RawConnection(server->port()).upgrade(token, host, origin).substr(9, 3);
    };
    EXPECT_EQ(answer("class.example", "https://class.example"), "101");
    EXPECT_EQ(answer("127.0.0.1:" + std::to_string(server->port()), "https://class.example"),
              "101");
    EXPECT_EQ(answer("class.example", "http://class.example"), "403");
    EXPECT_EQ(answer("class.example", "https://other.example"), "403");
    EXPECT_EQ(answer("other.example", "https://class.example"), "403");
}

TEST_F(ServedToOthers, WhatIsMissingOrWrongIsSaidInALine) {
    const Certificate own = make_certificate(m_folder.path(), "own", "DNS:class.example");
    const Certificate other = make_certificate(m_folder.path(), "other", "DNS:class.example");
    const std::string file = own.file.string(), key = own.key.string();
    EXPECT_EQ(refused({.host = "0.0.0.0"}),
              "host: expected a certificate too, since links are secrets, found 0.0.0.0 without "
              "one");
    EXPECT_EQ(refused({.host = "class.example"}),
              "host: expected an address of this machine, such as 0.0.0.0 for all, found "
              "class.example");
    EXPECT_EQ(refused({.certificate = file}),
              "key: expected a file, since certificate and key belong together, found none");
    EXPECT_EQ(refused({.key = key}),
              "certificate: expected a file, since certificate and key belong together, found "
              "none");
    EXPECT_TRUE(refused({.certificate = key, .key = key})
                    .starts_with("certificate: expected a certificate in PEM, found " + key));
    EXPECT_TRUE(refused({.certificate = file, .key = other.key.string()})
                    .starts_with("key: expected the certificate's private key in PEM, found " +
                                 other.key.string()));
    const auto certified = [&](const std::string& names) {
        const Certificate odd = make_certificate(m_folder.path(), "odd", names);
        return refused({.certificate = odd.file.string(), .key = odd.key.string()});
    };
    EXPECT_EQ(certified("DNS:class.example,DNS:a;b \x1b[31m"),
              "certificate: expected names of hosts in it, found a;b ?[31m");
    std::string many = "DNS:n0";
    for (int n = 1; n <= 100; ++n) many += ",DNS:n" + std::to_string(n);
    EXPECT_EQ(certified(many), "certificate: expected up to 100 names in it, found 101");
    EXPECT_EQ(refused({.url = "class.example"}),
              "url: expected http(s)://name[:port][/path], found class.example");
}

TEST_F(ServedToOthers, TheLinksOfASessionOutliveARestart) {
    const ServerSettings settings{.phantom_size = {16, 16, 16}, .session = m_folder / "s.pls"};
    const auto links = [&] {
        auto server = Server::start(settings, m_arena);
        EXPECT_TRUE(server.ok()) << server.error().message;
        return std::pair{token_of(server->link()), token_of(server->view_link())};
    };
    const auto first = links();
    EXPECT_EQ(links(), first);
    EXPECT_NE(first.first, first.second);
    const std::filesystem::path file = m_folder / "s.pls.links";
    EXPECT_EQ(std::filesystem::status(file).permissions(),
              std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    std::filesystem::remove(file);
    EXPECT_NE(links(), first);
    std::filesystem::resize_file(file, 40);
    EXPECT_EQ(refused(settings), file.string() +
                                     ": expected two different lines of 32 hexadecimal digits, "
                                     "found others; without the file there are new links");
}

}  // namespace
}  // namespace pliant::test
