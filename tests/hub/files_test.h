// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A server whose downloads and uploads are tested, in a folder that is checked for leftovers.

#pragma once

#include <gtest/gtest.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>
#include <pliant/volume.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "hub/test_client.h"
#include "support/temporary_folder.h"

namespace pliant::test {

inline constexpr std::uint64_t kMaxUpload = 4 << 20;

/// Text of a one-line answer.
inline std::string line_of(const std::string& response) {
    const std::string body = body_of(response);
    EXPECT_EQ(std::count(body.begin(), body.end(), '\n'), 1) << body;
    return body.substr(0, body.find('\n'));
}

/// A server of a cube, asked for files and given some.
class FilesTest : public ::testing::Test {
  protected:
    void SetUp() override {
        // Temporary files of the server are searched below.
        ::setenv("TMPDIR", m_temporary.path().c_str(), 1);
        auto phantom = make_phantom({.name = "cube", .size = {48, 40, 44}}, m_arena);
        ASSERT_TRUE(phantom.ok());
        // Its values would count as bone.
        phantom->volume.key_values.emplace_back("bone_threshold_hu", "3000");
        ASSERT_TRUE(write_volume(m_folder / "cube.nrrd", phantom->volume).ok());
        auto scan = read_volume(m_folder / "cube.nrrd");
        ASSERT_TRUE(scan.ok());
        m_scan = std::move(*scan);
    }
    void TearDown() override {
        m_server.reset();
        ::unsetenv("TMPDIR");
        std::error_code error;
        for (const auto& entry : std::filesystem::directory_iterator(m_temporary.path(), error))
            ADD_FAILURE() << "was left behind: " << entry.path();
    }
    void start(const std::string& session = "") {
        auto started = Server::start({.file = (m_folder / "cube.nrrd").string(),
                                      .session = session,
                                      .max_upload_bytes = kMaxUpload},
                                     m_arena);
        ASSERT_TRUE(started.ok()) << started.error().message;
        m_server.emplace(std::move(*started));
    }
    int port() const { return m_server->port(); }
    std::string host() const { return "127.0.0.1:" + std::to_string(port()); }
    std::string token() const { return token_of(m_server->link()); }

    std::string save(const std::string& name, const std::string& used_token = "") {
        return RawConnection(port()).get(
            "/save/" + name + "?token=" + (used_token.empty() ? token() : used_token), host());
    }
    /// Head of a request; its body is the caller's to send.
    std::string head(const std::string& target, std::size_t size) const {
        return "POST " + target + " HTTP/1.1\r\nHost: " + host() +
               "\r\nContent-Length: " + std::to_string(size) + "\r\n\r\n";
    }
    std::string post(const std::string& target, const std::string& body) {
        return RawConnection(port()).post(target, body);
    }
    std::string open(const std::string& name, const std::string& body) {
        return post("/open?token=" + token() + "&name=" + name, body);
    }
    std::string part(const std::string& id, const std::string& name, const std::string& body) {
        return post("/open/part?token=" + token() + "&upload=" + id + "&name=" + name, body);
    }
    std::string done(const std::string& id, const std::string& name = "") {
        return post("/open/done?token=" + token() + "&upload=" + id + "&name=" + name, "");
    }
    /// Until the new scan is there.
    static void follow(TestClient& client) {
        const Json volume = client.until("volume");
        ASSERT_FALSE(volume.is_null());
        client.size = {volume["size"][0], volume["size"][1], volume["size"][2]};
        client.voxels.assign(
            std::size_t(client.size.x) * std::size_t(client.size.y) * std::size_t(client.size.z),
            0xffff);
        client.welcome["volume"] = volume;
        ASSERT_TRUE(client.until_up_to_date());
    }
    static Json push(Vec3d at, Vec3d by, double radius = 4) {
        return {{"do", "push"},
                {"point", {at.x, at.y, at.z}},
                {"push", {by.x, by.y, by.z}},
                {"radius", radius}};
    }
    /// A scan that differs from the first one.
    std::string other_scan(const std::string& name = "other.nrrd") {
        auto phantom = make_phantom({.name = "layers", .size = {30, 34, 38}}, m_arena);
        EXPECT_TRUE(phantom.ok());
        phantom->volume.key_values.emplace_back("bone_threshold_hu", "3000");
        EXPECT_TRUE(write_volume(m_folder / name, phantom->volume).ok());
        return bytes_of(m_folder / name);
    }

    const TaskArena m_arena{2};
    TemporaryFolder m_temporary, m_folder;
    Volume m_scan;
    std::optional<Server> m_server;
};

}  // namespace pliant::test
