// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Clients' messages: round trip of every message, an error for every mistake, and many random
// texts.

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "network/door.h"
#include "protocol/commands.h"
#include "support/random.h"

namespace pliant::serve {
namespace {

using test::Random;

const std::vector<std::string>& good_messages() {
    static const std::vector<std::string> messages = {
        R"({"do":"push","id":7,"point":[1.5,-2,3],"push":[0,0.1,6],"radius":4,"stroke":2})",
        R"({"do":"slide","point":[1,2,3],"push":[0,0,6],"radius":4})",
        R"({"do":"grab","id":8,"point":[1,2,3],"radius":0,"reach":12})",
        R"({"do":"drag","id":9,"offset":[1,2,3e-3]})",
        R"({"do":"let_go"})",
        R"({"do":"cut","id":4294967295,"line":[[0,0,0],[1,0,0],[2,1,0]],"depth":[0,0,5]})",
        R"({"do":"carve","from":[0,0,0],"to":[1,1,1],"radius":0.1,"spare_fixed":true,"stroke":1})",
        R"({"do":"relax","on":true})",
        R"({"do":"release"})",
        R"({"do":"reset"})",
        R"({"do":"materials","offset":0.3,"air_enabled":false,"limits":"rounded","yield":0})",
        R"({"do":"materials","max_movement_mm":30,"bone_threshold_hu":250})",
        R"({"do":"materials","air_threshold_hu":-600})",
        R"({"do":"iso","iso_hu":-450.5,"polarity":"falling"})",
        R"({"do":"undo"})",
        R"({"do":"redo"})",
        R"({"do":"tissue","model":"chainmail"})",
        R"({"do":"tissue","id":2,"model":"springs"})",
        R"({"do":"tissue","model":"springs","centre":[1,2,3],"nodes":8,"cell_mm":6.5,"depth":4})",
        R"({"do":"tissue","model":"springs","young_modulus_pa":500,"fixed_hu":3000})",
        R"({"do":"tissue","model":"elastic"})",
        R"({"do":"tissue","model":"elastic","moduli_kpa":[[-950,0],[40,8.5]],"poisson_ratio":0.3})",
        R"({"do":"tissue","model":"elastic","held_sides":["-x","+z"],"held_above_hu":900})",
        R"({"do":"tissue","model":"elastic","held_sides":[]})",
        R"({"do":"depth","layers":6})",
        R"({"do":"depth","within_mm":0.25})",
        R"({"do":"tissue","model":"vessel"})",
        R"({"do":"catheter","id":4,"insert_mm_s":-100,"rotate_deg_s":90.5})",
        R"({"do":"catheter","bend_first_deg":30,"bend_second_deg":-180})",
        R"({"do":"vessel","on":true})",
        R"({"do":"hello","protocol":2,"role":"view","name":"Änne","lz4":true})",
        R"({"coarse":true,"do":"hello","lz4":false,"name":"","protocol":2,"role":"control"})",
        R"({"do":"hello","protocol":2,"resume":"ab","step":0})",
        R"({"do":"tool","kind":"sphere","position":[1,2,3],"direction":[0,0,1],"radius":4})",
        R"({"do":"tool","kind":"none"})",
        R"({"do":"checksum","id":3})",
        R"({"do":"seen","step":17})",
        R"({"do":"seen","step":17,"format":3})",
        R"({"do":"overlay","id":5,"kind":"displacement"})",
        R"({"do":"overlay","kind":"jacobian"})",
        R"({"do":"overlay","kind":"none"})",
        R"({"do":"rest","id":6,"on":true})",
        R"({"do":"rest","on":false})",
        R"({"do":"camera"})",
        R"({"do":"camera","eye":[1,2,3],"look":[0,1,0],"up":[0,0,1]})",
        R"({"do":"follow","id":9,"client":3})",
        R"({"do":"follow","client":0})",
        R"({"do":"labels","id":7,"on":true})",
        R"({"do":"marks","on":false})",
        R"({"do":"mark","id":3,"key":"a","kind":"point","name":"Änne","points":[[1,2,3.5]]})",
        R"({"do":"mark","key":"b","kind":"ruler","points":[[1,2,3],[0,0,0]],"shown":false})",
        R"({"do":"mark","key":"a","kind":"none"})",
        R"({"do":"ping"})",
        R"({"do":"path","id":5,"from":[1,2,3],"to":[4,5.5,6],"reach":7})",
        R"({"do":"path","from":[1,2,3],"to":[4,5,6],"iso_hu":-600,"polarity":"falling"})",
        R"({"do":"haptics","id":4,"wish":"stop"})",
        R"({"do":"haptics","wish":"go"})",
        R"({"do":"haptics","wish":"end"})",
        R"({"do":"haptics","wish":"start","device":"virtual:tap","position":[1,2,3],)"
        R"("look":[0,0,-1],"up":[0,1,0],"scale":0.5,"radius":3})",
        R"({"do":"haptic_pose","position":[1,-2,3.5]})",
        R"({"do":"haptic_pose","position":[1,-2,3.5],"roll_deg":-400.5})",
    };
    return messages;
}

TEST(Messages, ComeBackAsTheyWere) {
    for (const std::string& text : good_messages()) {
        const auto first = parse_message(text);
        const auto* message = std::get_if<Message>(&first);
        ASSERT_TRUE(message) << text << std::get_if<ParseFailure>(&first)->message;
        const std::string once = text_of(*message);
        const auto second = parse_message(once);
        ASSERT_TRUE(std::get_if<Message>(&second)) << once;
        EXPECT_EQ(text_of(*std::get_if<Message>(&second)), once);
        EXPECT_EQ(std::get_if<Message>(&second)->action.index(), message->action.index());
        // Nothing that was said is lost.
        const auto before = nlohmann::json::parse(text), after = nlohmann::json::parse(once);
        for (const auto& [key, value] : before.items()) {
            EXPECT_TRUE(after.contains(key)) << key << " of " << text;
            if (after.contains(key)) {
                EXPECT_EQ(after[key], value) << text;
            }
        }
    }
}

TEST(Messages, WithUnknownFieldsAreAnsweredWithTheKnownOnes) {
    for (const std::string& text : good_messages()) {
        const auto fields = nlohmann::json::parse(text);
        auto json = fields;
        json["id"] = 5;
        // Fields of a session's lines.
        json["client"] = json.value("client", 2);
        json["refused"] = true;
        ASSERT_TRUE(std::holds_alternative<Message>(parse_message(json.dump()))) << text;
        json["foo"] = {1, 2};
        const auto read = parse_message(json.dump());
        if (json["do"] == "hello") {
            EXPECT_TRUE(std::holds_alternative<Message>(read)) << "of a newer client";
            continue;
        }
        const auto* failure = std::get_if<ParseFailure>(&read);
        ASSERT_TRUE(failure) << text;
        EXPECT_FALSE(failure->rubbish);
        EXPECT_EQ(failure->id, 5U);
        EXPECT_NE(failure->message.find("\"foo\": found an unknown field, expected "),
                  std::string::npos)
            << failure->message;
        for (const auto& [key, value] : fields.items())
            if (key != "do" && key != "id" && key != "client") {
                EXPECT_NE(failure->message.find(key), std::string::npos) << failure->message;
            }
    }
    const auto message = [](const char* text) {
        const auto read = parse_message(text);
        return std::get_if<ParseFailure>(&read)->message;
    };
    EXPECT_EQ(message(R"({"do":"undo","steps":2})"),
              "undo: \"steps\": found an unknown field, expected none");
    EXPECT_EQ(message(R"({"do":"push","point":[1,2,3],"push":[0,0,1],"radius":1,"foo":1})"),
              "push: \"foo\": found an unknown field, expected one of point, push, radius, stroke");
}

TEST(Messages, OfOlderSessionsAreUnderstood) {
    for (const auto& [flag, limits] : {std::pair("true", "rounded"), {"false", "box"}}) {
        const auto read =
            parse_message(R"({"do":"materials","rounded":)" + std::string(flag) + "}");
        const auto* message = std::get_if<Message>(&read);
        ASSERT_TRUE(message);
        EXPECT_EQ(std::get_if<MaterialsCommand>(&message->action)->values,
                  (Record{{"limits", limits}}));
    }
}

TEST(Messages, CarryTheirNumbersExactly) {
    const std::uint64_t seed = 1001;
    SCOPED_TRACE(seed);
    Random random(seed);
    for (int n = 0; n < 2000; ++n) {
        const PushCommand push{
            .push = {random.vector(1000), random.vector(100), random.real(0.1, 100)},
            .slide = random.whole(0, 1) == 1,
            .stroke = std::uint32_t(random.next()) | 1};
        const auto read = parse_message(text_of(Message{std::uint32_t(n), push}));
        const auto* message = std::get_if<Message>(&read);
        ASSERT_TRUE(message);
        const auto& back = *std::get_if<PushCommand>(&message->action);
        EXPECT_EQ(back.push.point_mm, push.push.point_mm);
        EXPECT_EQ(back.push.push_mm, push.push.push_mm);
        EXPECT_EQ(back.push.sphere_radius_mm, push.push.sphere_radius_mm);
        EXPECT_EQ(back.slide, push.slide);
        EXPECT_EQ(back.stroke, push.stroke);
        EXPECT_EQ(message->id, std::uint32_t(n));
    }
}

TEST(Messages, ThatAreRubbishCloseTheConnection) {
    const std::string deep(5, '[');
    for (const std::string& text : std::vector<std::string>{
             "",
             "null",
             "[]",
             "17",
             "\"push\"",
             "{",
             "{}",
             R"({"do":7})",
             R"({"do":"fly"})",
             R"({"do":"push"})",
             R"({"do":"push","point":[1,2],"push":[0,0,1],"radius":1})",
             R"({"do":"push","point":[1,2,"3"],"push":[0,0,1],"radius":1})",
             R"({"do":"push","point":[1,2,1e999],"push":[0,0,1],"radius":1})",
             R"({"do":"push","point":[1,2,3],"push":[0,0,1],"radius":"4"})",
             R"({"do":"push","id":-1,"point":[1,2,3],"push":[0,0,1],"radius":1})",
             R"({"do":"push","id":4294967296,"point":[1,2,3],"push":[0,0,1],"radius":1})",
             R"({"do":"push","point":[1,2,3],"push":[0,0,1],"radius":1,"stroke":1.5})",
             R"({"do":"cut","line":[[1,2,3],[1,2]],"depth":[0,0,1]})",
             R"({"do":"cut","line":7})",
             R"({"do":"relax","on":1})",
             R"({"do":"iso","polarity":"sideways"})",
             R"({"do":"materials","limits":"round"})",
             R"({"do":"materials","offset":"soft"})",
             R"({"do":"materials","offset":{}})",
             R"({"do":"tissue","model":"springs","nodes":6.5})",
             R"({"do":"tissue","model":"elastic","moduli_kpa":[1,2]})",
             R"({"do":"tissue","model":"elastic","moduli_kpa":[[1,2,3]]})",
             R"({"do":"tissue","model":"elastic","moduli_kpa":[[1,2],3]})",
             R"({"do":"tissue","model":"elastic","held_sides":["left"]})",
             R"({"do":"tissue","model":"elastic","held_sides":"-x"})",
             R"({"do":"depth"})",
             R"({"do":"depth","within_mm":"0.1"})",
             R"({"do":"seen","step":-1})",
             R"({"do":"seen","step":1,"format":"2"})",
             R"({"do":"overlay"})",
             R"({"do":"overlay","kind":"strain"})",
             R"({"do":"overlay","kind":2})",
             R"({"do":"rest"})",
             R"({"do":"camera","eye":[1,2,3]})",
             R"({"do":"follow"})",
             R"({"do":"follow","client":"Anna"})",
             R"({"do":"rest","on":"displacement"})",
             R"({"do":"labels","on":1})",
             R"({"do":"mark","kind":"point","points":[[1,2,3]]})",
             R"({"do":"mark","key":"a","kind":"cube","points":[[1,2,3]]})",
             R"({"do":"mark","key":"a","kind":"point"})",
             R"({"do":"haptics"})",
             R"({"do":"haptics","wish":"start","device":3,"position":[1,2,3]})",
             R"({"do":"haptic_pose","position":[1,2]})",
             R"({"do":"haptic_pose","position":[1,2,3],"roll_deg":"round"})",
             R"({"do":"tool","kind":"hammer"})",
             "{\"do\":\"\xff\"}",
             R"({"do":"ping","x":)" + deep + "]]]]]}",
             R"({"do":"push","point":[1e9,0,0],"push":[0,0,1],"radius":[]})"}) {
        const auto read = parse_message(text);
        const auto* failure = std::get_if<ParseFailure>(&read);
        ASSERT_TRUE(failure) << text;
        EXPECT_TRUE(failure->rubbish) << text;
        EXPECT_NE(failure->message.find("expected"), std::string::npos) << failure->message;
    }
}

TEST(Messages, OutOfRangeAreAnsweredByTheirNumber) {
    for (const char* text :
         {R"({"do":"push","id":5,"point":[1,2,3],"push":[0,0,501],"radius":1})",
          R"({"do":"push","id":5,"point":[1,2,3],"push":[0,0,1],"radius":-1})",
          R"({"do":"slide","id":5,"point":[1,2,3],"push":[0,0,1],"radius":0})",
          R"({"do":"eye","id":5,"position":[1,2,3],"radius":101})",
          R"({"do":"push","id":5,"point":[1e6,2,3],"push":[0,0,1],"radius":1})",
          R"({"do":"push","id":5,"point":[1,2,3],"push":[0,0,1],"radius":1,"stroke":0})",
          R"({"do":"grab","id":5,"point":[1,2,3],"radius":101})",
          R"({"do":"cut","id":5,"line":[[1,2,3]],"depth":[0,0,1]})",
          R"({"do":"catheter","id":5,"bend_deg":[90,0]})",
          R"({"do":"materials","id":5,"offset":1.5})",
          R"({"do":"materials","id":5,"elastic":[10,0.45]})",
          R"({"do":"tissue","id":5,"model":"springs","nodes":65})",
          R"({"do":"tissue","id":5,"model":"springs","cell_mm":0})",
          R"({"do":"tissue","id":5,"model":"elastic","poisson_ratio":0.5})",
          R"({"do":"iso","id":5,"iso_hu":1e6})"}) {
        const auto read = parse_message(text);
        const auto* failure = std::get_if<ParseFailure>(&read);
        ASSERT_TRUE(failure) << text;
        EXPECT_FALSE(failure->rubbish) << failure->message;
        EXPECT_EQ(failure->id, 5U);
        EXPECT_NE(failure->message.find("found"), std::string::npos);
    }
}

TEST(Messages, OfAnyBytesAtAllDoNoHarm) {
    const std::uint64_t seed = 0x5eed;
    SCOPED_TRACE(seed);
    Random random(seed);
    const std::string alphabet = "{}[]\",:0123456789.eE+-truefalsn \\u\xc3\xa4\xff\x01";
    int understood = 0;
    for (int n = 0; n < 40'000; ++n) {
        std::string text;
        if (n % 5 == 0) {
            for (int k = random.whole(0, 60); k > 0; --k)
                text += alphabet[std::size_t(random.whole(0, int(alphabet.size()) - 1))];
        } else {
            const auto& all = good_messages();
            text = all[std::size_t(random.whole(0, int(all.size()) - 1))];
            for (int k = random.whole(1, 4); k > 0; --k) {
                const auto at = std::size_t(random.whole(0, int(text.size()) - 1));
                switch (random.whole(0, 4)) {
                    case 0:
                        text[at] = char(random.whole(0, 255));
                        break;
                    case 1:
                        text.erase(at, std::size_t(random.whole(1, 9)));
                        break;
                    case 2:
                        text.insert(at, text.substr(at / 2, 12));
                        break;
                    case 3:
                        text.insert(at, std::string(1, alphabet[at % alphabet.size()]));
                        break;
                    default:
                        text.resize(at);
                        break;
                }
                if (text.empty()) text = "{";
            }
        }
        const auto read = parse_message(text);
        if (const auto* message = std::get_if<Message>(&read)) {
            ++understood;
            // Accepted messages round-trip.
            const std::string once = text_of(*message);
            const auto again = parse_message(once);
            ASSERT_TRUE(std::get_if<Message>(&again)) << text << "\n" << once;
            ASSERT_EQ(text_of(*std::get_if<Message>(&again)), once) << text;
        } else {
            // Unknown fields are answered with the list of known ones.
            ASSERT_LT(std::get_if<ParseFailure>(&read)->message.size(), 800U) << text;
        }
    }
    EXPECT_GT(understood, 50);
}

TEST(Door, OpensForThisMachineOnly) {
    const OwnOrigins own("http", 8765);
    for (const char* host : {"127.0.0.1:8765", "localhost:8765", "[::1]:8765"}) {
        EXPECT_TRUE(own.has_host(host)) << host;
        EXPECT_TRUE(own.has("http://" + std::string(host))) << host;
    }
    for (const char* host : {"", "127.0.0.1", "127.0.0.1:8766", "evil.example:8765",
                             "127.0.0.1:8765.evil.example", "localhost.evil.example:8765"}) {
        EXPECT_FALSE(own.has_host(host)) << host;
        EXPECT_FALSE(own.has("http://" + std::string(host))) << host;
    }
    EXPECT_TRUE(OwnOrigins("http", 80).has_host("localhost"));
    EXPECT_TRUE(OwnOrigins("https", 443).has("https://localhost"));
    EXPECT_FALSE(own.has("https://localhost:8765"));
    EXPECT_FALSE(own.has("null"));
    EXPECT_EQ(own.websockets(), "ws://127.0.0.1:8765 ws://localhost:8765");
    OwnOrigins proxied("http", 8765);
    EXPECT_TRUE(proxied.add_url("https://Class.example.org:443/pliant/"));
    EXPECT_TRUE(proxied.has_host("class.example.org"));
    EXPECT_TRUE(proxied.has_host("class.example.org:443"));
    EXPECT_TRUE(proxied.has("https://class.example.org"));
    EXPECT_FALSE(proxied.has("http://class.example.org"));
    EXPECT_FALSE(proxied.has_host("class.example.org.evil.example"));
    for (const char* url : {"", "class.example.org", "ftp://class.example.org", "https://",
                            "https://a b/", "https://a;b/", "https:///path"})
        EXPECT_FALSE(proxied.add_url(url)) << url;
    EXPECT_EQ(proxied.frames(), "'none'");
    for (const char* origin : {"http://localhost:*", "https://lab.example.org"})
        EXPECT_TRUE(proxied.add_frame(origin)) << origin;
    for (const char* origin : {"", "*", "localhost:8888", "http://*", "http://:*", "http://a/b",
                               "https://a; script-src *", "http://a\r\nX: y"})
        EXPECT_FALSE(proxied.add_frame(origin)) << origin;
    EXPECT_EQ(proxied.frames(), "http://localhost:* https://lab.example.org");
    EXPECT_TRUE(is_same_secret("abc", "abc"));
    EXPECT_FALSE(is_same_secret("abd", "abc"));
    EXPECT_FALSE(is_same_secret("", "abc"));
    EXPECT_FALSE(is_same_secret("abcd", "abc"));
}

TEST(Door, FindsWhatTheQuerySays) {
    EXPECT_EQ(path_of("/ws?token=1"), "/ws");
    EXPECT_EQ(query_value("/ws?token=12", "token"), "12");
    EXPECT_EQ(query_value("/ws?a=1&token=12&b=2", "token"), "12");
    EXPECT_EQ(query_value("/ws?mytoken=12", "token"), "");
    EXPECT_EQ(query_value("/ws?token", "token"), "");
    EXPECT_EQ(query_value("/ws?&&&", "token"), "");
    EXPECT_EQ(query_value("/ws", "token"), "");
}

TEST(TokenBucket, LetsBurstsPassAndFloodsNot) {
    const auto start = std::chrono::steady_clock::now();
    TokenBucket steady(start), burst(start), large(start);
    for (int n = 1; n <= 2400; ++n)  // ten seconds at the limit
        ASSERT_TRUE(steady.take(100, start + n * std::chrono::microseconds(4167)));
    int taken = 0;
    while (burst.take(10, start)) ++taken;
    EXPECT_EQ(taken, int(kMessageBurst));
    taken = 0;
    while (large.take(kMaxMessageBytes, start)) ++taken;
    EXPECT_EQ(taken, 64);
}

}  // namespace
}  // namespace pliant::serve
