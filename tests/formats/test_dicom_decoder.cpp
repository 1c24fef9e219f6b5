// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Programs in the decoder's place that end, crash, hang or lie; and the decoder itself, with
// damaged codestreams and on several threads.
// Covers: decoder/main.cpp, formats/find_pixel_decoder.cpp, formats/pixel_decoder.cpp.

#include "base/memory_budget.h"
#include "formats/dicom_series.h"
#include "formats/pixel_decoder.h"
#include "support/compressed_dicom.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <sys/wait.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace pliant {
namespace {

namespace fs = std::filesystem;
using test::Codec;
using test::compressed;
using test::DicomFile;

/// The bytes of an answer, as `printf` of a shell takes them.
const char* const kGoodAnswer =
    "'\\061\\101\\114\\120\\001\\000\\000\\000\\000\\000\\000\\000\\000\\000\\000\\000'";

class DicomDecoder : public testing::Test {
  protected:
    DicomDecoder() {
        DicomFile slice = compressed("4.90", "jpeg_2000", "u8");
        m_folder.write("scan/a.dcm", slice.bytes());
        slice.position[2] = 1;
        m_folder.write("scan/b.dcm", slice.bytes());
    }
    /// The error of reading with a script in the decoder's place.
    std::string error_with(const std::string& script, double seconds = 5) {
        const fs::path program = m_folder.write("decoder", "#!/bin/sh\n" + script + "\n");
        fs::permissions(program, fs::perms::owner_all);
        return error_of({program, seconds});
    }
    std::string error_of(const DecoderChoice& decoder) {
        ReadNotes notes;
        testing::internal::CaptureStderr();
        const auto volume = read_dicom_folder(m_folder / "scan", {}, notes, decoder);
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
        // Its process is gone.
        EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
        EXPECT_EQ(errno, ECHILD);
        if (volume.ok()) return "was read";
        const std::string& message = volume.error().message;
        EXPECT_EQ(message.find('\n'), message.npos) << message;
        const std::string start = (m_folder / "scan/a.dcm").string() + ": ";
        EXPECT_TRUE(message.starts_with(start)) << message;
        return message.substr(std::min(start.size(), message.size()));
    }
    test::TemporaryFolder m_folder;
};

TEST_F(DicomDecoder, OneThatEndsIsAnError) {
    const std::string ended = "its pixels can't be decoded (the decoder ended)";
    EXPECT_EQ(error_with("exit 0"), ended);
    EXPECT_EQ(error_with("exit 1"), ended);
    EXPECT_EQ(error_with("kill -SEGV $$"), ended);
    EXPECT_EQ(error_with("kill -ABRT $$"), ended);
    EXPECT_EQ(error_with("head -c 100 <&3 >/dev/null; kill -SEGV $$"), ended);
}

TEST_F(DicomDecoder, OneThatSaysTooLittleIsAnError) {
    const std::string ended = "its pixels can't be decoded (the decoder ended)";
    EXPECT_EQ(error_with("printf 1AL >&3"), ended);
    EXPECT_EQ(error_with(std::string("printf ") + kGoodAnswer + " >&3"), ended);
    EXPECT_EQ(
        error_with(std::string("{ printf ") + kGoodAnswer + "; head -c 119 /dev/zero; } | cat >&3"),
        ended);
}

TEST_F(DicomDecoder, OneThatSaysTooMuchOrNonsenseIsAnError) {
    EXPECT_EQ(error_with(std::string("{ printf ") + kGoodAnswer +
                         "; head -c 121 /dev/zero; } | cat >&3; exec sleep 9"),
              "its pixels can't be decoded");
    EXPECT_EQ(error_with("head -c 100000 /dev/urandom >&3; exec sleep 9"),
              "its pixels can't be decoded");
}

TEST_F(DicomDecoder, OneThatHangsIsAnError) {
    EXPECT_EQ(error_with("exec sleep infinity", 0.3), "its pixels take longer than 1 s to decode");
    EXPECT_EQ(error_with(std::string("printf ") + kGoodAnswer + " >&3; exec sleep infinity", 0.3),
              "its pixels take longer than 1 s to decode");
}

TEST_F(DicomDecoder, OneThatIsMissingIsAnError) {
    const std::string message = error_of({m_folder / "none", 5});
    EXPECT_TRUE(message.starts_with("the decoder can't be started (")) << message;
    const auto positions = decoder_paths();
    ASSERT_GE(positions.size(), 3u);
    for (const fs::path& place : positions) {
        EXPECT_TRUE(place.is_absolute()) << place;
        EXPECT_EQ(place.filename(), kDecoderName);
    }
    EXPECT_TRUE(find_pixel_decoder().ok());
}

TEST_F(DicomDecoder, IsNotTakenWhereAllMayWriteIt) {
    const fs::path program = m_folder.write(kDecoderName, "#!/bin/sh\n");
    EXPECT_FALSE(find_pixel_decoder({program}).ok());  // can't be run
    fs::permissions(program, fs::perms::owner_all | fs::perms::others_write);
    const auto found = find_pixel_decoder({program});
    ASSERT_FALSE(found.ok());
    EXPECT_NE(found.error().message.find("looked for in " + m_folder.path().string()),
              std::string::npos)
        << found.error().message;
    fs::permissions(program, fs::perms::owner_all);
    EXPECT_TRUE(find_pixel_decoder({m_folder / "none", program}).ok());
}

TEST_F(DicomDecoder, GetsNoEnvironmentAndNoDescriptors) {
    ::setenv("PLIANT_TEST_SECRET", "1", 1);
    const fs::path out = m_folder / "out";
    error_with("{ env; ls -l /proc/$$/fd; } >" + out.string());
    ::unsetenv("PLIANT_TEST_SECRET");
    const std::string said = test::bytes_of(out);
    EXPECT_EQ(said.find("PLIANT_TEST_SECRET"), said.npos) << said;
    EXPECT_NE(said.find("3 -> socket"), said.npos) << said;
    // The shell itself keeps its script at 10 or above.
    for (const char* other : {" 4 ->", " 5 ->", " 6 ->", " 7 ->", " 8 ->", " 9 ->"})
        EXPECT_EQ(said.find(other), said.npos) << said;
}

TEST_F(DicomDecoder, StrayDescriptorsAndSignalsAreNotInherited) {
    const int stray = ::dup(0);
    EXPECT_EQ(error_of({}), "was read");
    ::close(stray);
}

TEST_F(DicomDecoder, LittleMemoryIsAnError) {
    const auto program = find_pixel_decoder();
    ASSERT_TRUE(program.ok()) << program.error().message;
    auto decoder = PixelDecoder::start(*program, {5, 1, 0});
    ASSERT_TRUE(decoder.ok()) << decoder.error().message;
    PixelRequest request;
    request.dicom_bytes = std::uint64_t(1) << 40;
    std::vector<std::uint8_t> message(sizeof request), pixels(1);
    std::memcpy(message.data(), &request, sizeof request);
    const auto is_signed = decoder->decode(message, pixels);
    ASSERT_FALSE(is_signed.ok());
    EXPECT_EQ(is_signed.error().code, ErrorCode::LimitExceeded);
    EXPECT_NE(is_signed.error().message.find("not enough memory"), std::string::npos);
}

/// Empty codestreams of JPEG 2000 may have any size, in few bytes.
TEST_F(DicomDecoder, MemoryThatIsNotThereIsNotAskedFor) {
    constexpr std::uint16_t kSide = 1500;
    DicomFile slice = compressed("4.90", "jpeg_2000", "u8");
    slice.rows = slice.columns = kSide;
    std::string& bytes = slice.fragments[0];
    const std::size_t size = bytes.find("\xff\x51") + 6;
    for (const std::size_t at : {size, size + 4, size + 16, size + 20})
        bytes.replace(at, 4, {0, 0, char(kSide >> 8), char(kSide & 0xff)});
    m_folder.write("scan/a.dcm", slice.bytes());
    slice.position[2] = 1;
    m_folder.write("scan/b.dcm", slice.bytes());
    const auto with_memory = [&](const std::string& kib) {
        m_folder.write("system/proc/meminfo", "MemAvailable: " + kib + " kB\n");
        const MemorySources sources{m_folder / "system"};
        const UseMemorySources use(sources);
        const auto volume = read_volume(m_folder / "scan");
        return volume.ok() ? "was read" : volume.error().message;
    };
    EXPECT_EQ(with_memory("8000"), (m_folder / "scan").string() + ": not enough memory to read it");
    EXPECT_EQ(with_memory("20000"),
              (m_folder / "scan/a.dcm").string() + ": not enough memory to decode its pixels");
    EXPECT_EQ(with_memory("200000").find("memory"), std::string::npos);
}

TEST_F(DicomDecoder, SeveralThreadsReadAtOnce) {
    std::atomic<int> read = 0;
    std::vector<std::thread> threads;
    for (int n = 0; n < 4; ++n)
        threads.emplace_back([&] {
            for (int round = 0; round < 5; ++round) read += read_volume(m_folder / "scan").ok();
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(read, 20);
}

std::string damaged(std::string bytes, std::size_t from, std::mt19937& random) {
    const auto place = [&](std::size_t first, std::size_t last) {
        return std::uniform_int_distribution<std::size_t>(first, last)(random);
    };
    for (std::size_t n = place(1, 4); n > 0; --n)
        bytes[place(from, bytes.size() - 1)] = char(place(0, 255));
    return bytes;
}

TEST_F(DicomDecoder, DamagedCodestreamsAreReadOrRefusedInOneLine) {
    constexpr unsigned kSeed = 4711;
    constexpr int kRounds = 50;
    std::mt19937 random(kSeed);
    testing::internal::CaptureStderr();
    int refused = 0;
    for (const Codec& codec : test::kCodecs) {
        DicomFile slice = compressed(codec);
        m_folder.write("scan/a.dcm", slice.bytes());
        slice.position[2] = 1;
        const std::string good = slice.bytes();
        for (int n = 0; n < kRounds; ++n) {
            // Every other time the header as well, behind the name of the series.
            const std::size_t from =
                n % 2 ? good.find("\x28\0\x02\0") : good.size() - slice.fragments[0].size() - 8;
            fs::remove(m_folder / "scan/b.dcm");
            m_folder.write("scan/b.dcm", damaged(good, from, random));
            const auto volume = read_volume(m_folder / "scan");
            if (volume.ok()) continue;
            ++refused;
            const std::string& message = volume.error().message;
            EXPECT_EQ(message.find('\n'), message.npos) << message;
            EXPECT_TRUE(message.starts_with((m_folder / "scan").string())) << message;
        }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "seed " << kSeed;
    EXPECT_GT(refused, 0);
}

/// The same change in the headers of all slices, so that it gets as far as the decoder.
TEST_F(DicomDecoder, DamagedHeadersOfAllSlicesAreReadOrRefusedInOneLine) {
    constexpr unsigned kSeed = 99;
    std::mt19937 random(kSeed);
    testing::internal::CaptureStderr();
    for (const auto& [syntax, name, kind] :
         {std::array{"4.80", "jpeg_ls", "u16"}, std::array{"4.90", "jpeg_2000", "s12"},
          std::array{"5", "rle", "u16"}, std::array{"4.70", "jpeg_lossless", "s16"}})
        for (int n = 0; n < 40; ++n) {
            DicomFile slice = compressed(syntax, name, kind);
            std::uint16_t* const fields[] = {
                &slice.rows,        &slice.columns,  &slice.samples,  &slice.bits_allocated,
                &slice.bits_stored, &slice.high_bit, &slice.is_signed};
            std::uint16_t& field = *fields[random() % std::size(fields)];
            field = random() % 2 ? std::uint16_t(random() % 40) : std::uint16_t(random());
            m_folder.write("scan/a.dcm", slice.bytes());
            slice.position[2] = 1;
            m_folder.write("scan/b.dcm", slice.bytes());
            const auto volume = read_volume(m_folder / "scan");
            if (volume.ok()) continue;
            const std::string& message = volume.error().message;
            EXPECT_EQ(message.find('\n'), message.npos) << message;
        }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "seed " << kSeed;
}

}  // namespace
}  // namespace pliant
