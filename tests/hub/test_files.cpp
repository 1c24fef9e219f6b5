// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Downloads and uploads over real connections: downloads equal the library's files for the same
// pushes, and the scene survives every upload.
// Covers: network/opening.cpp, network/transfers*.cpp, network/upload.cpp, hub/hub.cpp.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/data/session.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/serve.h>
#include <pliant/volume.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <thread>

#include "hub/files_test.h"
#include "network/upload.h"
#include "support/random.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

TEST_F(FilesTest, WhatIsSavedIsWhatTheLibraryWritesOfTheSamePushes) {
    start();
    TestClient a(port(), m_server->link());
    a.enter();
    EXPECT_EQ(a.welcome["features"],
              Json({"save", "open", "overlay", "path", "tissue", "haptics", "vessel", "rest",
                    "state", "labels", "marks", "follow"}));
    EXPECT_EQ(a.welcome["open_bytes"], kMaxUpload);
    ChainMailSettings settings;
    settings.bone_threshold_hu = 3000;
    auto tissue = ChainMail::create(m_scan, settings, m_arena);
    ASSERT_TRUE(tissue.ok());
    const auto compare = [&] {
        const Deformed deformed = deform_volume(*tissue, Mapping::Cells, true).value();
        for (const char* name : {"volume.nrrd", "volume.nii.gz", "volume.mha", "volume.vti"})
            ASSERT_TRUE(write_volume(m_folder / name, deformed.volume).ok());
        ASSERT_TRUE(
            write_vector_field(m_folder / "displacement.nrrd", displacement_field(*tissue).value())
                .ok());
        ASSERT_TRUE(
            write_vector_field(m_folder / "transform.nrrd", inverse_field(deformed).value()).ok());
        for (const std::string name : {"volume.nrrd", "volume.nii.gz", "volume.mha", "volume.vti",
                                       "displacement.nrrd", "transform.nrrd"}) {
            const std::string response = save(name);
            EXPECT_EQ(status_of(response), "200");
            EXPECT_NE(
                response.find("Content-Disposition: attachment; filename=\"" + name + "\"\r\n"),
                std::string::npos);
            EXPECT_TRUE(body_of(response) == bytes_of(m_folder / name)) << name;
        }
    };
    compare();
    Random random(4711);
    for (int n = 0; n < 6; ++n) {
        const Push by{random.vector(8), random.vector(3), 4};
        ASSERT_TRUE(tissue->push(by).ok());
        EXPECT_EQ(a.command(push(by.point_mm, by.push_mm))["t"], "done");
    }
    compare();
    // Cut and carved, and in the middle of a drag.
    const CutSurface cut{.line_mm = {{-5, -5, 0.3}, {5, -5, 0.3}}, .depth_mm = {0, 10, 0}};
    ASSERT_TRUE(tissue->cut(cut).ok());
    a.command({{"do", "cut"}, {"line", {{-5, -5, 0.3}, {5, -5, 0.3}}}, {"depth", {0, 10, 0}}});
    ASSERT_TRUE(tissue->carve({.from_mm = {6, 0, 0}, .to_mm = {9, 0, 0}, .radius_mm = 3}).ok());
    a.command({{"do", "carve"}, {"from", {6, 0, 0}}, {"to", {9, 0, 0}}, {"radius", 3}});
    ASSERT_TRUE(tissue->grab({{0, 0, 0}, {0, 0, 0}, 5}, 20).ok());
    ASSERT_TRUE(tissue->drag_to({0, 1.5, 0.4}).ok());
    a.command({{"do", "grab"}, {"point", {0, 0, 0}}, {"radius", 5}});
    EXPECT_EQ(a.command({{"do", "drag"}, {"offset", {0, 1.5, 0.4}}})["t"], "done");
    compare();
    // The files are scans that `pliant info` can read.
    ASSERT_TRUE(read_volume(m_folder / "volume.nrrd").ok());
    const auto field = read_vector_field(m_folder / "displacement.nrrd");
    ASSERT_TRUE(field.ok());
    EXPECT_EQ(field->kind, FieldKind::Modeling);
    // Saving ended nothing.
    EXPECT_EQ(a.command({{"do", "drag"}, {"offset", {0, 1, 0}}})["t"], "done");
}

TEST_F(FilesTest, ASavedSessionReplaysToTheSameHash) {
    start();
    TestClient a(port(), m_server->link());
    a.enter();
    Random random(99);
    for (int n = 0; n < 5; ++n) a.command(push(random.vector(8), random.vector(3)));
    const std::string response = save("session.pls");
    ASSERT_EQ(status_of(response), "200");
    const Json sums = a.checked_checksum();
    const auto file = m_folder.write("saved.pls", body_of(response));
    const auto report = replay_session(file, m_arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->commands, 5);
    EXPECT_EQ(report->marks, 1);
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016lx", static_cast<unsigned long>(report->tissue_hash));
    EXPECT_EQ(sums["tissue"], hash);
    // One byte of it changed is found.
    std::string damaged = body_of(response);
    damaged[damaged.size() / 2] ^= 1;
    EXPECT_FALSE(replay_session(m_folder.write("damaged.pls", damaged), m_arena).ok());
}

TEST_F(FilesTest, TokensAndNamesAreLookedAtBeforeAnythingIsDone) {
    start();
    const std::string view = token_of(m_server->view_link());
    EXPECT_EQ(status_of(save("volume.nrrd", view)), "200");
    EXPECT_EQ(status_of(save("volume.nrrd", "wrong")), "403");
    EXPECT_EQ(status_of(RawConnection(port()).get("/save/volume.nrrd", host())), "403");
    EXPECT_EQ(status_of(save("tissue.nrrd")), "404");
    EXPECT_EQ(status_of(save("../../etc/passwd")), "404");
    const std::string scan = other_scan();
    EXPECT_EQ(line_of(post("/open?token=" + view + "&name=a.nrrd", scan)),
              "open: expected the link of those who may change the scene");
    EXPECT_EQ(status_of(post("/open?token=wrong&name=a.nrrd", scan)), "403");
    EXPECT_EQ(status_of(RawConnection(port()).get("/open?token=" + token(), host())), "405");
    EXPECT_EQ(status_of(post("/save/volume.nrrd?token=" + token(), "")), "405");
    RawConnection stranger(port());
    stranger.send("POST /open?token=" + token() + "&name=a.nrrd HTTP/1.1\r\nHost: " + host() +
                  "\r\nOrigin: http://evil.example\r\nContent-Length: 0\r\n\r\n");
    EXPECT_EQ(status_of(stranger.read_response()), "403");
    EXPECT_EQ(status_of(post("/open/else?token=" + token(), "")), "404");
    EXPECT_EQ(status_of(part("", "a.nrrd", scan)), "400");
    EXPECT_EQ(status_of(part("../x", "a.nrrd", scan)), "400");
    EXPECT_EQ(status_of(done("nobody")), "404");
    EXPECT_EQ(status_of(open("", scan)), "400");
    EXPECT_EQ(status_of(open("..", scan)), "400");
    EXPECT_EQ(status_of(open("%zz", scan)), "400");
}

TEST_F(FilesTest, AnOpenedScanIsANewSceneForEverybody) {
    start();
    TestClient a(port(), m_server->link()), b(port(), m_server->view_link());
    a.enter();
    b.enter({{"lz4", true}});
    a.command(push({0, 0, 0}, {0, 2, 0}));
    a.command({{"do", "grab"}, {"point", {0, 0, 0}}, {"radius", 5}});
    b.until([](const Json& t) { return t["t"] == "state" && t["holder"] != 0; });
    const std::string scan = other_scan();
    const std::string response = open("my%20scan.nrrd", scan);
    EXPECT_EQ(status_of(response), "200") << response;
    follow(a);
    follow(b);
    const Json volume = a.welcome["volume"];
    EXPECT_EQ(volume["id"], 2);
    EXPECT_EQ(volume["name"], "my scan.nrrd");
    EXPECT_EQ(volume["size"], Json({30, 34, 38}));
    const auto read = read_volume(m_folder / "other.nrrd");
    ASSERT_TRUE(read.ok());
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016lx", static_cast<unsigned long>(hash_volume(*read)));
    EXPECT_EQ(a.checked_checksum()["volume"], hash);
    EXPECT_EQ(b.checked_checksum()["volume"], hash);
    // Nothing is held and nothing can be undone.
    EXPECT_EQ(a.command({{"do", "drag"}, {"offset", {0, 1, 0}}})["code"], "not_holding");
    EXPECT_EQ(a.command({{"do", "undo"}})["code"], "nothing");
    EXPECT_EQ(a.command(push({0, 0, 0}, {0, 2, 0}))["t"], "done");
    EXPECT_EQ(a.checked_checksum()["tissue"], b.checked_checksum()["tissue"]);
    // A client that reconnects gets everything.
    TestClient late(port(), m_server->link());
    EXPECT_EQ(late.enter()["volume"]["id"], 2);
    late.checked_checksum();
    // Its session names the file, and replays beside it.
    const auto session = m_folder.write("there/s.pls", body_of(save("session.pls")));
    const auto missing = replay_session(session, m_arena);
    ASSERT_FALSE(missing.ok());
    EXPECT_NE(missing.error().message.find("my scan.nrrd: no such file"), std::string::npos)
        << missing.error().message;
    m_folder.write("there/my scan.nrrd", scan);
    const auto report = replay_session(session, m_arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->commands, 3);
}

TEST_F(FilesTest, BadScansAreRefusedInOneLineAndChangeNothing) {
    start();
    TestClient a(port(), m_server->link());
    a.enter();
    a.command(push({0, 0, 0}, {0, 2, 0}));
    const Json before = a.checked_checksum();
    const std::string scan = other_scan();
    const auto refused = [&](const std::string& name, const std::string& body) {
        const std::string response = open(name, body);
        EXPECT_EQ(status_of(response), "400") << response;
        const std::string line = line_of(response);
        EXPECT_EQ(line.find(m_temporary.path().string()), std::string::npos) << line;
        EXPECT_EQ(line.find("pliant-upload"), std::string::npos) << line;
        return line;
    };
    EXPECT_EQ(refused("a.nrrd", "hello"),
              "a.nrrd: is no NRRD file: starts with 'hello', expected 'NRRD000…'");
    EXPECT_TRUE(refused("a.nrrd", "").starts_with("a.nrrd: is empty"));
    EXPECT_TRUE(refused("a.txt", "hello").starts_with("a.txt: is no scan that can be read"));
    EXPECT_TRUE(refused("a.toml", "[vessel]\nphantom = \"bend\"\n")
                    .starts_with("a.toml: is a vessel's scene, expected a scan"));
    EXPECT_TRUE(refused("a.nrrd", scan.substr(0, scan.size() / 2)).starts_with("a.nrrd: "));
    EXPECT_TRUE(refused("..%2f..%2fa.mha", "hello").starts_with("a.mha: "));
    // A header that leads elsewhere: the data are there, and must not be read.
    m_folder.write("secret.raw", packed(small_values()));
    const std::string secret = (m_folder / "secret.raw").string();
    NrrdFile nrrd{.extra = "data file: " + secret + "\n", .data = ""};
    EXPECT_TRUE(refused("a.nhdr", nrrd.bytes()).find("expected one without a folder") !=
                std::string::npos);
    nrrd.extra = "data file: LIST\n" + secret + "\n";
    EXPECT_TRUE(refused("a.nhdr", nrrd.bytes()).find("without a folder") != std::string::npos);
    // However long the header is, and whether the file exists or not: the same words.
    const std::string gone = (m_folder / "gone.raw").string();
    std::vector<std::string> answers;
    for (const std::string& file : {secret, gone}) {
        nrrd.extra = "# " + std::string(50000, 'x') + "\n# " + std::string(50000, 'x') +
                     "\ndata file: " + file + "\n";
        std::string answer = refused("a.nhdr", nrrd.bytes());
        const auto at = answer.find(std::filesystem::path(file).filename().string());
        ASSERT_NE(at, std::string::npos) << answer;
        answers.push_back(answer.erase(at, std::filesystem::path(file).filename().string().size()));
    }
    EXPECT_EQ(answers[0], answers[1]);
    EXPECT_NE(answers[0].find("without a folder"), std::string::npos) << answers[0];
    const MetaFile meta{.data_file = secret, .data = ""};
    EXPECT_TRUE(refused("a.mhd", meta.bytes()).find("without a folder") != std::string::npos);
    const MetaFile list{.data_file = "LIST\n" + secret, .data = ""};
    EXPECT_TRUE(refused("a.mhd", list.bytes()).find("without a folder") != std::string::npos);
    const MetaFile above{.data_file = "../secret.raw", .data = ""};
    EXPECT_TRUE(refused("a.mhd", above.bytes()).find("without a folder") != std::string::npos);
    const Json after = a.checked_checksum();
    EXPECT_EQ(after["volume"], before["volume"]);
    EXPECT_EQ(after["tissue"], before["tissue"]);
    EXPECT_EQ(a.command({{"do", "undo"}})["t"], "done");
}

TEST_F(FilesTest, ScansOfSeveralFilesComeInParts) {
    start();
    TestClient a(port(), m_server->link());
    a.enter();
    const std::string data = packed(small_values());
    // A header with its data beside it, in any order, with arbitrary folders in their names.
    EXPECT_EQ(status_of(part("one", "C%3A%5Cscans%5Cx.raw", data)), "200");
    const MetaFile meta{.data_file = "x.raw", .data = ""};
    EXPECT_EQ(status_of(part("one", "/scans/../x.mhd", meta.bytes())), "200");
    const std::string answer = done("one");
    EXPECT_EQ(status_of(answer), "200") << answer;
    follow(a);
    EXPECT_EQ(a.welcome["volume"]["name"], "x.mhd");
    EXPECT_EQ(a.voxels[0], 0xd640);  // −100
    // A folder of slices.
    for (int n = 0; n < 3; ++n) {
        DicomFile slice;
        slice.position = {0, 0, double(n)};
        slice.pixels.assign(12, std::int16_t(1000 + n));
        EXPECT_EQ(status_of(part("two", "IM" + std::to_string(n), slice.bytes())), "200");
    }
    const std::string opened = done("two", "..%2fCT%20chest");
    EXPECT_EQ(status_of(opened), "200") << opened;
    follow(a);
    EXPECT_EQ(a.welcome["volume"]["name"], "CT chest");
    EXPECT_EQ(a.size, (Vec3i{4, 3, 3}));
    // Files that can't be one scan.
    EXPECT_EQ(status_of(part("three", "a.nrrd", "hello")), "200");
    EXPECT_EQ(line_of(part("three", "b/a.nrrd", "hello")),
              "a.nrrd: expected files of different names, found two");
    EXPECT_EQ(status_of(done("three")), "404") << "given up with the name that came twice";
    EXPECT_EQ(status_of(part("four", "a.nrrd", "hello")), "200");
    EXPECT_EQ(status_of(part("four", "b.nii", "hello")), "200");
    EXPECT_EQ(line_of(done("four")), "expected one scan, found a.nrrd and b.nii");
    EXPECT_EQ(status_of(part("five", "a.dcm", "hello")), "200");
    EXPECT_EQ(status_of(part("five", "b.dcm", "hello")), "200");
    const std::string line = line_of(done("five", "slices"));
    EXPECT_TRUE(line.starts_with("slices: ")) << line;
    a.checked_checksum();
}

TEST_F(FilesTest, OfSeveralSeriesOneIsChosen) {
    start();
    TestClient a(port(), m_server->link());
    a.enter();
    const auto send_all = [&](const std::string& id) {
        for (int n = 0; n < 5; ++n) {
            DicomFile slice;
            slice.position = {0, 0, double(n)};
            slice.series = n < 3 ? "1.2.3" : "1.2.4";
            slice.description = n < 3 ? "arterial" : "venous";
            slice.series_number = n < 3 ? "7" : "2";
            slice.pixels.assign(12, std::int16_t(1000 + n));
            EXPECT_EQ(status_of(part(id, "IM" + std::to_string(n), slice.bytes())), "200");
        }
    };
    send_all("one");
    const std::string asked = done("one", "CT");
    EXPECT_EQ(status_of(asked), "300") << asked;
    const Json list = Json::parse(line_of(asked))["series"];
    ASSERT_EQ(list.size(), 2u);
    const Json venous = {{"number", "2"},
                         {"description", "venous"},
                         {"modality", "CT"},
                         {"slices", 2},
                         {"volumes", 1},
                         {"size", {4, 3, 2}},
                         {"spacing_mm", {0.25, 0.5, 1.0}},
                         {"uid", "1.2.4"}};
    EXPECT_EQ(list[0], venous) << "by number";
    EXPECT_EQ(list[1]["uid"], "1.2.3");
    EXPECT_EQ(list[1]["slices"], 3);
    // Nothing has changed, and the files are still there.
    a.checked_checksum();
    EXPECT_EQ(status_of(done("one", "CT&series=1.2.4")), "200");
    follow(a);
    EXPECT_EQ(a.size, (Vec3i{4, 3, 2}));
    EXPECT_EQ(a.welcome["volume"]["name"], "CT");
    // One that isn't there ends the upload.
    send_all("two");
    const std::string wrong = done("two", "CT&series=9");
    EXPECT_EQ(status_of(wrong), "400");
    EXPECT_NE(line_of(wrong).find("has no series 9"), std::string::npos) << wrong;
    EXPECT_EQ(status_of(done("two", "CT")), "404");
    // The same happens after a cancelled upload; another one can start at once.
    send_all("three");
    EXPECT_EQ(status_of(done("three", "CT")), "300");
    const std::string drop = "/open/drop?token=" + token() + "&upload=";
    EXPECT_EQ(status_of(post(drop + "four", "")), "503");
    EXPECT_EQ(status_of(post(drop + "three", "")), "200");
    EXPECT_EQ(status_of(done("three", "CT")), "404");
    EXPECT_EQ(status_of(part("four", "a.nrrd", "hello")), "200");
    a.checked_checksum();
}

TEST_F(FilesTest, OfSeveralImagesInAFileOneIsChosen) {
    const std::string session = (m_folder / "s.pls").string();
    start(session);
    TestClient a(port(), m_server->link());
    a.enter();
    std::string data;
    for (int frame = 0; frame < 3; ++frame)
        data += packed(std::vector<std::int16_t>(24, std::int16_t(100 * frame)));
    NiftiFile nifti;
    nifti.dim = {4, 4, 3, 2, 3, 1, 1, 1};
    nifti.data = data;
    // Without an ID nothing is kept.
    EXPECT_EQ(line_of(open("time.nii", nifti.bytes())),
              "time.nii: holds 3 images, choose one with the parameter frame, 0…2");
    const auto upload = [&](const std::string& more) {
        return post("/open?token=" + token() + "&upload=abc&name=time.nii" + more, nifti.bytes());
    };
    const std::string asked = upload("");
    EXPECT_EQ(status_of(asked), "300");
    EXPECT_EQ(Json::parse(body_of(asked)), Json({{"frames", 3}}));
    EXPECT_EQ(line_of(done("abc&frame=x")), "frame: expected a whole number, found x");
    EXPECT_EQ(status_of(done("abc&frame=1")), "404") << "it was dropped";
    EXPECT_EQ(status_of(upload("")), "300");
    EXPECT_EQ(status_of(done("abc&frame=2")), "200");
    follow(a);
    EXPECT_EQ(a.welcome["volume"]["name"], "time.nii");
    EXPECT_EQ(a.welcome["volume"]["range_hu"], Json({200, 200}));
    const Json sums = a.checked_checksum();
    // Or at once.
    EXPECT_EQ(line_of(upload("&frame=3")), "--frame: found 3, expected 0…2 for time.nii");
    EXPECT_EQ(status_of(upload("&frame=1")), "200");
    follow(a);
    EXPECT_EQ(a.welcome["volume"]["range_hu"], Json({100, 100}));
    EXPECT_NE(a.checked_checksum()["volume"], sums["volume"]);
    m_server.reset();
    EXPECT_TRUE(replay_session(session, m_arena).ok()) << "it names the image";
}

TEST_F(FilesTest, ALegacyVtkFileWithASurfaceBecomesABody) {
    start();
    TestClient a(port(), m_server->link());
    a.enter();
    const std::string octahedron =
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 6 float\n"
        "20 0 0 -20 0 0 0 20 0 0 -20 0 0 0 20 0 0 -20\nPOLYGONS 8 32\n3 0 2 4\n3 2 1 4\n3 1 3 4\n"
        "3 3 0 4\n3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n";
    const std::string opened = open("organ.vtk", octahedron);
    EXPECT_EQ(status_of(opened), "200") << opened;
    follow(a);
    EXPECT_EQ(a.welcome["volume"]["name"], "organ.vtk");
    const Json done = a.command({{"do", "push"},
                                 {"point", {15, 0, 0}},
                                 {"push", {-2, 0, 0}},
                                 {"radius", 6},
                                 {"stroke", 1}});
    EXPECT_EQ(done["status"], "applied") << done;
}

TEST_F(FilesTest, WhatIsTooLargeIsRefusedBeforeItIsSent) {
    start();
    TestClient a(port(), m_server->link());
    a.enter();
    {
        RawConnection large(port());
        large.send(head("/open?token=" + token() + "&name=a.nrrd", kMaxUpload + 1));
        const std::string response = large.read_response();
        EXPECT_EQ(status_of(response), "413");
        EXPECT_EQ(line_of(response), "expected a scan of up to 4 MiB, found 5 MiB or more");
    }
    {
        // Of unknown length: until it is too large. The answer comes although more is sent.
        RawConnection endless(port());
        endless.send("POST /open?token=" + token() + "&name=a.nrrd HTTP/1.1\r\nHost: " + host() +
                     "\r\nTransfer-Encoding: chunked\r\n\r\n");
        const std::string chunk = "10000\r\n" + std::string(0x10000, 'x') + "\r\n";
        for (int n = 0; n < 80; ++n)
            if (!endless.send(chunk)) break;
        EXPECT_EQ(status_of(endless.read_response()), "413");
    }
    // In parts: all of them together.
    const std::string half(kMaxUpload / 2, 'x');
    EXPECT_EQ(status_of(part("p", "a", half)), "200");
    EXPECT_EQ(status_of(part("p", "b", half)), "200");
    EXPECT_EQ(status_of(part("p", "c", "x")), "413");
    a.checked_checksum();
}

TEST_F(FilesTest, OneScanAtATimeAndWhoIsCutOffMakesRoom) {
    start();
    const std::string scan = other_scan();
    std::optional<RawConnection> first(port());
    first->send(head("/open?token=" + token() + "&name=a.nrrd", scan.size()));
    first->send(scan.substr(0, 100));
    std::string second;
    for (int n = 0; n < 100 && second.empty(); ++n) {
        // The first one may not have been noticed yet.
        const std::string response = part("x" + std::to_string(n), "b.nrrd", "hello");
        if (status_of(response) == "503") second = response;
        if (status_of(response) == "200") done("x" + std::to_string(n));
    }
    EXPECT_EQ(line_of(second), "open: expected one scan at a time, found another");
    first.reset();
    std::string third;
    for (int n = 0; n < 300 && status_of(third) != "200"; ++n) {
        third = open("c.nrrd", scan);
        if (status_of(third) == "503") std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(status_of(third), "200") << third;
    // An upload in parts keeps others out between its parts, too.
    EXPECT_EQ(status_of(part("mine", "a.raw", "hello")), "200");
    EXPECT_EQ(status_of(open("c.nrrd", scan)), "503");
    EXPECT_EQ(status_of(done("mine", "x")), "400");
    EXPECT_EQ(status_of(open("c.nrrd", scan)), "200");
}

TEST_F(FilesTest, AClientThatHangsUpEndsTheReadingOfItsScan) {
    start();
    TestClient a(port(), m_server->link());
    a.enter();
    // Some tenths of a second to inflate, from a few bytes.
    const NrrdFile slow{.type = "uchar",
                        .sizes = "512 512 256",
                        .endian = "",
                        .encoding = "gzip",
                        .data = gzipped(std::string(std::size_t(512) * 512 * 256, '\0'))};
    const std::string bytes = slow.bytes();
    ASSERT_LT(bytes.size(), kMaxUpload);
    for (const bool in_parts : {false, true}) {
        {
            if (in_parts) {
                EXPECT_EQ(status_of(part("slow", "slow.nrrd", bytes)), "200");
            }
            RawConnection gone(port());
            const std::string target = in_parts ? "/open/done?upload=slow&" : "/open?";
            gone.send(
                head(target + "token=" + token() + "&name=slow.nrrd", in_parts ? 0 : bytes.size()));
            if (!in_parts) gone.send(bytes);
        }
        std::string next = open("next.nrrd", other_scan());
        for (int n = 0; n < 3000 && status_of(next) == "503"; ++n) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            next = open("next.nrrd", other_scan());
        }
        EXPECT_EQ(status_of(next), "200") << next;
        // The other scan was never the scene.
        follow(a);
        EXPECT_EQ(a.welcome["volume"]["name"], "next.nrrd");
        EXPECT_EQ(a.welcome["volume"]["id"], in_parts ? 3 : 2);
    }
    a.checked_checksum();
}

TEST_F(FilesTest, ASlowReaderHoldsUpNobodyButThoseWhoSave) {
    // Larger than the sockets' buffers.
    auto large = make_phantom({.name = "cube", .size = {144, 144, 144}}, m_arena);
    ASSERT_TRUE(large.ok());
    Random random(5);
    for (auto& v : std::get<0>(large->volume.voxels))
        v = std::int16_t(random.whole(-30'000, 30'000));  // that no file makes smaller
    ASSERT_TRUE(write_volume(m_folder / "cube.nrrd", large->volume).ok());
    start();
    TestClient a(port(), m_server->link());
    a.enter();
    std::optional<RawConnection> slow(port());
    const int small = 4096;
    ::setsockopt(slow->descriptor(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    slow->send("GET /save/volume.nrrd?token=" + token() + " HTTP/1.1\r\nHost: " + host() +
               "\r\n\r\n");
    ASSERT_TRUE(slow->fill(1000));
    // It reads no more. The scene goes on, and opening works.
    EXPECT_EQ(a.command(push({0, 0, 0}, {0, 2, 0}))["t"], "done");
    EXPECT_EQ(line_of(save("volume.nrrd")), "save: expected one at a time, found another");
    EXPECT_EQ(status_of(open("c.nrrd", other_scan())), "200");
    follow(a);
    a.checked_checksum();
    // It goes away.
    slow.reset();
    std::string next;
    for (int n = 0; n < 300 && status_of(next) != "200"; ++n) {
        next = save("session.pls");
        if (status_of(next) == "503") std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(status_of(next), "200");
}

TEST_F(FilesTest, ARecordedSessionKeepsItsScansAndGoesOnWithTheLast) {
    const std::string session = (m_folder / "s.pls").string();
    start(session);
    Json before;
    {
        TestClient a(port(), m_server->link());
        a.enter();
        a.command(push({0, 0, 0}, {0, 2, 0}));
        EXPECT_EQ(status_of(open("bad.nrrd", "hello")), "400");
        EXPECT_EQ(status_of(open("second.nrrd", other_scan())), "200");
        follow(a);
        a.command(push({0, 0, 0}, {0, 1, 0}));
        EXPECT_EQ(status_of(open("third.nrrd", bytes_of(m_folder / "cube.nrrd"))), "200");
        follow(a);
        a.command(push({1, 0, 0}, {0, 2, 1}));
        a.command(push({1, 2, 0}, {0, 0, 1}));
        before = a.checked_checksum();
    }
    m_server.reset();
    EXPECT_TRUE(std::filesystem::exists(m_folder / "s.pls.scans/1/scan/second.nrrd"));
    EXPECT_TRUE(std::filesystem::exists(m_folder / "s.pls.scans/2/scan/third.nrrd"));
    int kept = 0;
    for ([[maybe_unused]] const auto& entry :
         std::filesystem::directory_iterator(m_folder / "s.pls.scans"))
        ++kept;
    EXPECT_EQ(kept, 2) << "of what was refused nothing is left";
    // All of it replays, also from elsewhere.
    const auto report = replay_session(session, m_arena);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_GE(report->commands, 4);  // and a release, if the client was seen to leave
    std::filesystem::create_directory(m_folder / "moved");
    std::filesystem::copy_file(session, m_folder / "moved/s.pls");
    std::filesystem::copy(m_folder / "s.pls.scans", m_folder / "moved/s.pls.scans",
                          std::filesystem::copy_options::recursive);
    EXPECT_TRUE(replay_session(m_folder / "moved/s.pls", m_arena).ok());
    // And it goes on.
    start(session);
    TestClient a(port(), m_server->link());
    EXPECT_EQ(a.enter()["volume"]["name"], "third.nrrd");
    const Json after = a.checked_checksum();
    EXPECT_EQ(after["volume"], before["volume"]);
    EXPECT_EQ(after["tissue"], before["tissue"]);
    EXPECT_EQ(a.command({{"do", "undo"}})["t"], "done");
    // A part of it is taken home; its scan is looked for beside it.
    m_folder.write("home/s.pls", body_of(save("session.pls")));
    m_folder.write("home/third.nrrd", bytes_of(m_folder / "cube.nrrd"));
    const auto part = replay_session(m_folder / "home/s.pls", m_arena);
    ASSERT_TRUE(part.ok()) << part.error().message;
    EXPECT_EQ(part->commands, 4);  // including the release of the client that left
    // Without a scan that was opened, one line says which.
    m_server.reset();
    std::filesystem::remove_all(m_folder / "s.pls.scans/2");
    const auto lost = replay_session(session, m_arena);
    ASSERT_FALSE(lost.ok());
    EXPECT_NE(lost.error().message.find("third.nrrd: no such file"), std::string::npos);
}

TEST(UploadTest, NamesAreBaseNamesWhateverTheyWere) {
    using serve::base_name;
    EXPECT_EQ(base_name("a.nrrd"), "a.nrrd");
    EXPECT_EQ(base_name("/etc/passwd"), "passwd");
    EXPECT_EQ(base_name("..\\..\\x.raw"), "x.raw");
    EXPECT_EQ(base_name("a/b/"), "");
    EXPECT_EQ(base_name(".."), "");
    EXPECT_EQ(base_name("..."), "");
    EXPECT_EQ(base_name(std::string("a\0b\nc", 5)), "abc");
    EXPECT_EQ(base_name("Lunge ä.nii.gz"), "Lunge ä.nii.gz");
    const std::string cut = base_name(std::string(300, 'x') + "ä" + std::string(199, 'y'));
    EXPECT_EQ(cut, std::string(199, 'y')) << "no half of a character";
}

TEST(UploadTest, LeftoversOfProcessesThatAreGoneAreSwept) {
    namespace fs = std::filesystem;
    TemporaryFolder folder;
    const auto make = [&](const char* name, std::chrono::seconds age) {
        const fs::path place = folder / name;
        fs::create_directories(place / "scan");
        std::ofstream(place / "scan" / "a.dcm") << "x";
        fs::last_write_time(place, fs::file_time_type::clock::now() - age);
        return place;
    };
    const fs::path old = make("pliant-upload-old", std::chrono::seconds(100));
    const fs::path young = make("pliant-upload-young", std::chrono::seconds(1));
    const fs::path kept = make("1", std::chrono::seconds(100));
    const fs::path living = make("pliant-upload-living", std::chrono::seconds(100));
    const int lock = ::open(living.c_str(), O_RDONLY | O_DIRECTORY);
    ASSERT_EQ(::flock(lock, LOCK_EX | LOCK_NB), 0);
    serve::sweep_uploads(folder.path());
    ::close(lock);
    EXPECT_FALSE(fs::exists(old));
    EXPECT_TRUE(fs::exists(young));
    EXPECT_TRUE(fs::exists(kept));
    EXPECT_TRUE(fs::exists(living));
}

TEST(UploadTest, FilesAreCounted) {
    TemporaryFolder folder;
    {
        serve::Upload upload({.folder = folder / "here", .max_bytes = 1000}, "x");
        for (int n = 0; n < serve::kMaxUploadFiles; ++n) {
            ASSERT_FALSE(upload.begin_file(std::to_string(n), 0));
            ASSERT_FALSE(upload.end_file());
        }
        const auto refusal = upload.begin_file("one more", 0);
        ASSERT_TRUE(refusal);
        EXPECT_EQ(refusal->status, 413U);
        EXPECT_EQ(refusal->line, "expected up to 4096 files of one scan, found more");
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder / "here"));
}

}  // namespace
}  // namespace pliant::test
