// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Hostile and faulty clients: they are disconnected with a reason, and the scene goes on
// for the others.
// Covers: network/door.cpp, network/server.cpp.

#include <gtest/gtest.h>
#include <pliant/serve.h>
#include <sys/socket.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>

#include "hub/test_client.h"
#include "support/random.h"

namespace pliant::test {
namespace {

/// Value of a header field of a response; empty if it has none.
std::string field_of(const std::string& response, const std::string& name) {
    const std::string head = response.substr(0, response.find("\r\n\r\n") + 2);
    const std::size_t line = head.find("\r\n" + name + ": ");
    if (line == std::string::npos) return {};
    const std::size_t begin = line + 2 + name.size() + 2;
    return head.substr(begin, head.find("\r\n", begin) - begin);
}

class HostileTest : public ::testing::Test {
  protected:
    void SetUp() override {
        auto started = Server::start({.phantom_size = {32, 32, 32}}, m_arena);
        ASSERT_TRUE(started.ok()) << started.error().message;
        m_server.emplace(std::move(*started));
        m_friend.emplace(port(), m_server->link());
        m_friend->enter();
        m_first_tick = m_server->ticks();
        m_since = std::chrono::steady_clock::now();
    }
    /// After every attack an honest client is still served.
    void TearDown() override {
        // The owner's count of ticks: a busy or instrumented machine leaves it at least 1/50 of its
        // rate.
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - m_since;
        const double ticks = double(m_server->ticks() - m_first_tick);
        EXPECT_GE(ticks, std::floor(seconds.count() * 60 / 50)) << "in " << seconds.count() << " s";
        RecordProperty("steps_per_second", std::to_string(ticks / seconds.count()));
        for (int n = 0; n < 3; ++n)
            EXPECT_EQ(m_friend->command({{"do", "iso"}, {"iso_hu", -400 - n}})["t"], "done");
        m_friend->checked_checksum();
        // Silent clients have their five seconds.
        const std::string token = token_of(m_server->link());
        for (int n = 0; n < 100; ++n) {
            if (RawConnection(port()).upgrade(token).starts_with("HTTP/1.1 101")) break;
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
        TestClient newcomer(port(), m_server->link());
        EXPECT_FALSE(newcomer.enter().is_null());
    }
    int port() const { return m_server->port(); }
    std::string own_host() const { return "127.0.0.1:" + std::to_string(port()); }
    /// A client that has said hello.
    std::unique_ptr<TestClient> enter() {
        auto client = std::make_unique<TestClient>(port(), m_server->link());
        client->enter();
        return client;
    }

    const TaskArena m_arena{2};
    std::optional<Server> m_server;
    std::optional<TestClient> m_friend;
    std::int64_t m_first_tick = 0;
    std::chrono::steady_clock::time_point m_since{};
};

TEST_F(HostileTest, StrangersStayOutside) {
    const std::string token = token_of(m_server->link());
    const auto status = [&](const std::string& used, const std::string& host,
                            const std::string& origin) {
        return RawConnection(port()).upgrade(used, host, origin).substr(9, 3);
    };
    EXPECT_EQ(status(token, "", ""), "101");
    EXPECT_EQ(status(token, "", "http://" + own_host()), "101");
    EXPECT_EQ(status("", "", ""), "403");
    EXPECT_EQ(status("wrong", "", ""), "403");
    EXPECT_EQ(status(token + "0", "", ""), "403");
    EXPECT_EQ(status(token, "evil.example:" + std::to_string(port()), ""), "403");
    EXPECT_EQ(status(token, "", "http://evil.example"), "403");
    EXPECT_EQ(status(token, "", "null"), "403");
    RawConnection browser(port());
    const std::string page = browser.get("/", own_host());
    EXPECT_TRUE(page.starts_with("HTTP/1.1 200")) << page.substr(0, 100);
    const std::string port_text = std::to_string(port());
    EXPECT_EQ(field_of(page, "Content-Security-Policy"),
              "default-src 'none'; script-src 'self'; style-src 'self'; "
              "img-src 'self' blob: data:; connect-src 'self' ws://127.0.0.1:" +
                  port_text + " ws://localhost:" + port_text +
                  "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    EXPECT_EQ(field_of(page, "X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(field_of(page, "Referrer-Policy"), "no-referrer");
    EXPECT_EQ(field_of(page, "Cross-Origin-Resource-Policy"), "same-origin");
    EXPECT_EQ(page.find(token), std::string::npos);
    EXPECT_TRUE(browser.get("/app.js", own_host()).starts_with("HTTP/1.1 200"));
    EXPECT_TRUE(browser.get("/../../etc/passwd", own_host()).starts_with("HTTP/1.1 404"));
    EXPECT_EQ(browser.get("/", own_host()), "") << "a refused request ends the connection";
    RawConnection poster(port());
    poster.send("POST / HTTP/1.1\r\nHost: " + own_host() + "\r\nContent-Length: 0\r\n\r\n");
    EXPECT_TRUE(poster.read_response().starts_with("HTTP/1.1 405"));
}

TEST_F(HostileTest, TheBodyOfARefusedRequestIsNoRequest) {
    const std::string own = "Host: " + own_host() + "\r\n";
    const std::string body = "GET /save/session.pls?token=" + token_of(m_server->link()) +
                             " HTTP/1.1\r\n" + own + "\r\n";
    for (const std::string& head :
         {std::string("POST / HTTP/1.1\r\nHost: evil.example\r\n"),
          "POST /open HTTP/1.1\r\n" + own + "Origin: http://evil.example\r\n",
          "POST /ws HTTP/1.1\r\n" + own, "POST /open?token=wrong HTTP/1.1\r\n" + own,
          "DELETE / HTTP/1.1\r\n" + own}) {
        RawConnection connection(port());
        connection.send(head + "Content-Type: text/plain\r\nContent-Length: " +
                        std::to_string(body.size()) + "\r\n\r\n" + body);
        EXPECT_TRUE(connection.read_response().starts_with("HTTP/1.1 40")) << head;
        EXPECT_EQ(connection.read_response(), "") << head;
    }
}

TEST_F(HostileTest, BrokenRequestsAreAnswered) {
    const std::string host = "Host: " + own_host() + "\r\n";
    const auto status = [&](const std::string& request) {
        RawConnection connection(port());
        connection.send(request);
        return connection.read_response().substr(0, 12);
    };
    EXPECT_EQ(status("GET / HTTP/1.1\r\n" + host + host + "\r\n"), "HTTP/1.1 400");
    EXPECT_EQ(status("GET / HTTP/1.1\r\n" + host + "Host: evil.example\r\n\r\n"), "HTTP/1.1 400");
    EXPECT_EQ(status("GET / HTTP/1.1\r\n\r\n"), "HTTP/1.1 400");
    EXPECT_EQ(status("GARBAGE\r\n\r\n"), "HTTP/1.1 400");
    EXPECT_EQ(status("GET / HTTP/1.1\r\n" + host + "Content-Length: x\r\n\r\n"), "HTTP/1.1 400");
    EXPECT_EQ(status("GET / HTTP/1.1\r\n" + host + "Content-Length: 5\r\n\r\n"), "HTTP/1.1 400");
    EXPECT_EQ(status("GET / HTTP/1.1\r\n" + host + "X: " + std::string(9000, 'x') + "\r\n\r\n"),
              "HTTP/1.1 431");
}

TEST_F(HostileTest, RubbishClosesTheConnectionWithAReason) {
    const std::string deep =
        "{\"do\":\"ping\",\"x\":" + std::string(1000, '[') + std::string(1000, ']') + "}";
    for (const std::string& text : std::vector<std::string>{
             "", "hello", "[1,2,3]", R"({"do":"fly"})", R"({"do":"push","point":7})", deep,
             R"({"do":"hello","protocol":2})"}) {
        const auto client = enter();
        client->send_frame(1, text);
        EXPECT_EQ(client->wait_for_close(), 4000) << text.substr(0, 50);
        EXPECT_FALSE(client->close_reason.empty());
    }
    const auto binary = enter();
    binary->send_frame(2, "PLNT");
    EXPECT_EQ(binary->wait_for_close(), 4000);
    // Text that is no UTF-8 is against the WebSocket's own rules.
    const auto garbled = enter();
    garbled->send_frame(1, "{\"do\":\"\xff\xfe\"}");
    EXPECT_NE(garbled->wait_for_close(), 0);
    // Before hello.
    TestClient early(port(), m_server->link());
    early.send_frame(1, R"({"do":"ping"})");
    EXPECT_EQ(early.wait_for_close(), 4000);
    TestClient newer(port(), m_server->link());
    newer.say({{"do", "hello"}, {"protocol", 3}});
    EXPECT_EQ(newer.wait_for_close(), 4000);
    EXPECT_NE(newer.close_reason.find("protocol"), std::string::npos);
}

TEST_F(HostileTest, LengthsThatAreTooLargeAreNotWaitedFor) {
    // 2⁶³ − 1 bytes announced, then nothing.
    const auto huge = enter();
    huge->send(std::string("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\x01\x02\x03\x04", 14));
    EXPECT_NE(huge->wait_for_close(), 1000);
    const auto large = enter();
    large->send_frame(1, std::string(70'000, ' '));
    EXPECT_EQ(large->wait_for_close(), 1009);
    // In many small pieces.
    const auto pieces = enter();
    std::string frame("\x01\xfe\x03\xe8\x00\x00\x00\x00", 8);
    frame += std::string(1000, ' ');
    for (int n = 0; n < 100; ++n) {
        if (!pieces->send(frame)) break;
        frame[0] = '\x00';
    }
    EXPECT_EQ(pieces->wait_for_close(), 1009);
    // Headers without an end.
    RawConnection endless(port());
    std::string header = "GET / HTTP/1.1\r\nX: ";
    header += std::string(100'000, 'a');
    endless.send(header);
    EXPECT_FALSE(endless.fill(100'000));
}

TEST_F(HostileTest, FloodsAreCutOff) {
    const auto client = enter();
    for (int n = 0; n < 20'000; ++n) {
        client->send_frame(1, R"({"do":"ping"})");
        if (n % 500 != 499) continue;
        // Meanwhile another client is served. (A client without messages for 30 s is dropped, and
        // with a sanitizer all this takes longer.)
        ASSERT_EQ(m_friend->command({{"do", "iso"}, {"iso_hu", -500 - n / 500}})["t"], "done");
        char byte = 0;
        if (::recv(client->descriptor(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0) break;
    }
    EXPECT_EQ(client->wait_for_close(), 4002);
}

TEST_F(HostileTest, FloodsOfWorkAreAnsweredBusyOrCutOff) {
    const auto client = enter();
    for (int n = 1; n <= 300; ++n)
        client->say({{"do", "push"},
                     {"id", n},
                     {"point", {0, 0, 0}},
                     {"push", {0, n % 2 ? 3 : -3, 0}},
                     {"radius", 30}});
    int done = 0, busy = 0;
    for (int n = 1; n <= 300; ++n) {
        const Json answer = client->until([](const Json& t) { return t["t"] != "state"; });
        if (answer.is_null()) break;
        done += answer["t"] == "done";
        busy += answer["t"] == "error" && answer["code"] == "busy";
        // Meanwhile another client is served.
        if (n % 100 == 0) {
            EXPECT_EQ(m_friend->command({{"do", "iso"}, {"iso_hu", -n}})["t"], "done");
        }
    }
    EXPECT_EQ(done + busy, 300);
    EXPECT_GE(done, 64);
}

TEST_F(HostileTest, AThousandConnectionsLeaveRoomForOne) {
    std::vector<std::unique_ptr<RawConnection>> crowd;
    int refused = 0;
    const std::string token = token_of(m_server->link());
    for (int n = 0; n < 1000; ++n) {
        crowd.push_back(std::make_unique<RawConnection>(port()));
        switch (n % 4) {
            case 0:
                break;  // says nothing
            case 1:
                crowd.back()->send("GET / HT");
                break;  // stops in the middle
            case 2:
                crowd.back()->send("\x16\x03\x01\xff\r\n\r\n");
                break;
            default:
                // Comes in, and says no hello.
                if (!crowd.back()->upgrade(token).starts_with("HTTP/1.1 101")) ++refused;
                break;
        }
        if (crowd.size() > 600) crowd.erase(crowd.begin());
        if (n % 250 == 249) {
            EXPECT_EQ(m_friend->command({{"do", "iso"}, {"iso_hu", -n}})["t"], "done");
        }
    }
    EXPECT_GT(refused, 100) << "there are more than 64 WebSockets";
    crowd.clear();
}

TEST_F(HostileTest, TornFramesEndTheirConnectionOnly) {
    const std::uint64_t seed = 2026;
    SCOPED_TRACE(seed);
    Random random(seed);
    const std::string token = token_of(m_server->link());
    for (int n = 0; n < 120; ++n) {
        RawConnection client(port());
        if (!client.upgrade(token).starts_with("HTTP/1.1 101")) {
            // The last ones are being taken away.
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            continue;
        }
        std::string bytes;
        for (int k = random.whole(0, 200); k > 0; --k) bytes += char(random.whole(0, 255));
        // Half of them begin well.
        if (n % 2) bytes = std::string("\x81\xa0", 2) + bytes;
        client.send(bytes);
        if (n % 10 == 0) {
            EXPECT_EQ(m_friend->command({{"do", "iso"}, {"iso_hu", -n}})["t"], "done");
        }
    }
}

TEST_F(HostileTest, WrongTypesAreRefusedOrEndTheirConnectionOnly) {
    const std::uint64_t seed = 31;
    SCOPED_TRACE(seed);
    Random random(seed);
    const std::vector<Json> good = {
        {{"do", "push"}, {"point", {1, 2, 3}}, {"push", {0, 1, 0}}, {"radius", 3}, {"slide", true}},
        {{"do", "grab"}, {"point", {0, 0, 0}}, {"radius", 3}},
        {{"do", "drag"}, {"offset", {0, 1, 0}}},
        {{"do", "cut"}, {"line", {{-5, -5, 0}, {5, -5, 0}}}, {"depth", {0, 9, 0}}},
        {{"do", "carve"}, {"from", {1, 0, 0}}, {"to", {2, 0, 0}}, {"radius", 2}},
        {{"do", "relax"}, {"on", false}},
        {{"do", "materials"}, {"offset", 0.2}, {"air_enabled", true}},
        {{"do", "iso"}, {"iso_hu", -400}, {"polarity", "rising"}},
        {{"do", "tool"}, {"kind", "sphere"}, {"position", {0, 0, 0}}, {"radius", 3}},
        {{"do", "seen"}, {"step", 1}},
        {{"do", "hello"}, {"protocol", 2}, {"name", "x"}}};
    const std::vector<std::string> wrong = {"null",
                                            "true",
                                            "\"x\"",
                                            "[]",
                                            "{}",
                                            "1e999",
                                            "-1e300",
                                            "[1,2]",
                                            "18446744073709551616",
                                            "[[]]",
                                            "[null,null,0]",
                                            "\"\\u0000\""};
    for (int n = 0; n < 60; ++n) {
        Json message = good[std::size_t(random.whole(0, int(good.size()) - 1))];
        auto field = message.begin();
        std::advance(field, random.whole(0, int(message.size()) - 1));
        *field = "HERE";
        std::string text = message.dump();
        text.replace(text.find("\"HERE\""), 6,
                     wrong[std::size_t(random.whole(0, int(wrong.size()) - 1))]);
        if (n % 10 == 0) {
            ASSERT_EQ(m_friend->command({{"do", "iso"}, {"iso_hu", -500 - n}})["t"], "done");
        }
        const auto client = enter();
        client->send_frame(1, text);
        client->say({{"do", "ping"}, {"id", 5}});
        // Refused, carried out where the value is a good one after all, or dropped.
        const Json answer = client->until("pong");
        EXPECT_TRUE(!answer.is_null() || client->close_code == 4000)
            << text << ": " << client->close_code;
    }
}

TEST_F(HostileTest, WhoBreaksOffAnywhereEndsTheirConnectionOnly) {
    const std::uint64_t seed = 32;
    SCOPED_TRACE(seed);
    Random random(seed);
    const std::string token = token_of(m_server->link());
    std::string good;
    for (const std::string text :
         {R"({"do":"hello","protocol":2})", R"({"do":"grab","point":[0,0,0],"radius":5})",
          R"({"do":"drag","offset":[0,1,0]})", R"({"do":"checksum","id":1})"})
        good += std::string{char(0x81), char(0x80 | text.size())} + std::string(4, '\0') + text;
    for (int n = 0; n < 60; ++n) {
        RawConnection client(port());
        if (!client.upgrade(token).starts_with("HTTP/1.1 101")) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            continue;
        }
        client.send(good.substr(0, std::size_t(random.whole(0, int(good.size())))));
        // Half of them with a reset, so that data in flight is lost.
        const linger at_once{1, 0};
        if (n % 2)
            ::setsockopt(client.descriptor(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    }
}

TEST_F(HostileTest, WhoTakesNothingIsSentNoMoreThanSocketsHold) {
    // Reads nothing, and asks for a lot: the scene goes on at its rate.
    const auto stuffed = enter();
    stuffed->sends_seen = false;
    const int small = 4096;
    ::setsockopt(stuffed->descriptor(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    for (int n = 0; n < 60; ++n) {
        stuffed->say({{"do", "checksum"}, {"id", n}});
        ASSERT_EQ(m_friend->command({{"do", "push"},
                                     {"point", {0, 0, 0}},
                                     {"push", {0, n % 2 ? 1 : -1, 0}},
                                     {"radius", 20}})["t"],
                  "done");
    }
    m_friend->checked_checksum();
}

}  // namespace
}  // namespace pliant::test
