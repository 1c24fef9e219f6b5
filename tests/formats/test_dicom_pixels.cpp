// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Every layout of pixels and every transfer syntax, against recorded hashes of the voxels
// (recorded_dicom.h).

#include "base/hash.h"
#include "formats/recorded_dicom.h"
#include "support/compressed_dicom.h"
#include "support/scan_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstring>

namespace pliant {
namespace {

using test::compressed;
using test::DicomFile;
using test::Recorded;

const std::string kLittleEndian = "1.2.840.10008.1.2.1", kBigEndian = "1.2.840.10008.1.2.2";

/// Values, and whether they are 16-bit integers or floats.
std::uint64_t hash_of(const Volume& volume) {
    Hash64 hash;
    hash.add_word(std::uint64_t(volume.is_16_bit()));
    std::visit(
        [&](const auto& voxels) {
            for (const auto value : voxels) {
                const auto number = float(value);
                std::uint32_t bits = 0;
                std::memcpy(&bits, &number, sizeof bits);
                hash.add_word(bits);
            }
        },
        volume.voxels);
    return hash.value();
}

std::string text_of(std::uint64_t hash) {
    char text[20];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

/// Hash of a series of two slices, the second at 1 mm; a text with the error where there is none.
std::string read_pair(DicomFile first, DicomFile second) {
    const test::TemporaryFolder folder;
    folder.write("a.dcm", first.bytes());
    second.position[2] = 1;
    folder.write("b.dcm", second.bytes());
    testing::internal::CaptureStderr();
    const auto volume = read_volume(folder.path());
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    if (!volume.ok()) return volume.error().message.substr(folder.path().string().size() + 1);
    return text_of(hash_of(*volume));
}

void expect_recorded(const Recorded& found, const Recorded& recorded) {
    for (const auto& [name, hash] : found) {
        const auto row = recorded.find(name);
        EXPECT_EQ(hash, row == recorded.end() ? "" : row->second)
            << "{\"" << name << "\", \"" << hash << "\"},";
    }
    EXPECT_EQ(found.size(), recorded.size());
}

TEST(DicomPixels, TheSharedFolderIsWhatItWas) {
    const std::filesystem::path folder =
        std::filesystem::path(PLIANT_SHARED_DATA) / "dicom_thorax_10";
    if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is missing";
    const auto volume = read_volume(folder);
    ASSERT_TRUE(volume.ok()) << volume.error().message;
    EXPECT_EQ(text_of(hash_of(*volume)), test::kSharedFolder);
}

/// Adds a hash; several ways to write the same pixels have the same.
void expect_same(Recorded& found, const std::string& name, const std::string& hash) {
    EXPECT_EQ(found.emplace(name, hash).first->second, hash) << name;
}

/// Bytes that use all bits, with the smallest and the largest of each kind of number among them.
std::string every_bit(std::size_t count) {
    std::string bytes("\0\0\0\0\xff\xff\xff\xff\0\0\0\x80\xff\xff\xff\x7f\0\x80\xff\x7f", 20);
    for (std::uint32_t state = 12345; bytes.size() < count;) {
        state = state * 1664525u + 1013904223u;
        bytes += char(state >> 24);
    }
    bytes.resize(count);
    return bytes;
}

TEST(DicomPixels, UncompressedOnesAreWhatTheyWere) {
    Recorded found;
    struct Rescale {
        const char *name, *slope, *intercept;
    };
    const Rescale rescales[] = {{"plain", "1", "0"},          {"shifted", "1", "-1024"},
                                {"scaled", "3", "-7"},        {"negative", "-1", "4"},
                                {"fraction", "0.1", "-1000"}, {"half", "1", "0.5"}};
    for (const std::string& syntax : {std::string("1.2.840.10008.1.2"), kLittleEndian, kBigEndian})
        for (const int bits : {8, 16, 32})
            for (const int is_signed : {0, 1})
                for (const Rescale& rescale : rescales) {
                    DicomFile slice;
                    slice.syntax = syntax;
                    slice.bits_allocated = slice.bits_stored = std::uint16_t(bits);
                    slice.high_bit = std::uint16_t(bits - 1);
                    slice.is_signed = std::uint16_t(is_signed);
                    slice.slope = rescale.slope;
                    slice.intercept = rescale.intercept;
                    slice.pixel_type = bits == 8 ? "OB" : "OW";
                    slice.raw = every_bit(12 * std::size_t(bits) / 8);
                    const std::string name = std::string(syntax == kBigEndian ? "big" : "little") +
                                             (is_signed ? " int" : " uint") + std::to_string(bits) +
                                             " " + rescale.name;
                    expect_same(found, name, read_pair(slice, slice));
                }
    expect_recorded(found, test::kUncompressed);
}

TEST(DicomPixels, BitsBesideThemAreWhatTheyWere) {
    Recorded found;
    for (const int stored : {15, 12, 10, 8, 1})
        for (const int is_signed : {0, 1}) {
            DicomFile slice;
            slice.bits_stored = std::uint16_t(stored);
            slice.high_bit = std::uint16_t(stored - 1);
            slice.is_signed = std::uint16_t(is_signed);
            slice.raw = every_bit(24);
            found[std::to_string(stored) + (is_signed ? " signed" : " unsigned")] =
                read_pair(slice, slice);
        }
    expect_recorded(found, test::kBitsStored);
}

TEST(DicomPixels, SlopesThatDifferAreWhatTheyWere) {
    Recorded found;
    DicomFile first, second;
    first.raw = second.raw = every_bit(24);
    second.slope = "0.3";
    found["1 and 0.3"] = read_pair(first, second);
    first.slope = "0.7";
    found["0.7 and 0.3"] = read_pair(first, second);
    first.slope = "1e5";
    found["1e5 and 0.3"] = read_pair(first, second);
    first.slope = "1e10";
    found["1e10 and 0.3"] = read_pair(first, second);
    first.slope = "0";
    found["0 and 0.3"] = read_pair(first, second);
    expect_recorded(found, test::kSlopes);
}

TEST(DicomPixels, BytesInWordsAreWhatTheyWere) {
    Recorded found;
    for (const std::string& syntax : {kLittleEndian, kBigEndian})
        for (const char* type : {"OB", "OW"})
            for (const int bits : {8, 16, 32}) {
                DicomFile slice;
                slice.syntax = syntax;
                slice.pixel_type = type;
                slice.bits_allocated = slice.bits_stored = std::uint16_t(bits);
                slice.high_bit = std::uint16_t(bits - 1);
                slice.raw = every_bit(12 * std::size_t(bits) / 8);
                found[syntax.substr(13) + " " + type + std::to_string(bits)] =
                    read_pair(slice, slice);
            }
    expect_recorded(found, test::kWords);
}

TEST(DicomPixels, CompressedOnesAreWhatTheyWere) {
    Recorded found;
    for (const auto& [syntax, codec] :
         {std::array{"5", "rle"}, std::array{"4.57", "jpeg_lossless"},
          std::array{"4.70", "jpeg_lossless"}, std::array{"4.80", "jpeg_ls"},
          std::array{"4.81", "jpeg_ls"}, std::array{"4.90", "jpeg_2000"},
          std::array{"4.91", "jpeg_2000"}})
        for (const char* kind : {"u8", "s8", "u12", "s12", "u16", "s16"}) {
            DicomFile slice = compressed(syntax, codec, kind);
            expect_same(found, kind, read_pair(slice, slice));
            DicomFile other = slice;
            other.slope = "0.25";
            other.intercept = "0.1";
            expect_same(found, std::string(kind) + " scaled", read_pair(slice, other));
        }
    for (const auto& [syntax, name, kind] :
         {std::array{"4.50", "jpeg_baseline", "u8"}, std::array{"4.51", "jpeg_extended", "u8"},
          std::array{"4.51", "jpeg_extended", "u12"}}) {
        const DicomFile slice = compressed(syntax, name, kind);
        found[std::string(syntax) + " " + kind] = read_pair(slice, slice);
    }
    expect_recorded(found, test::kCompressed);
}

TEST(DicomPixels, CodestreamsInPiecesAreReadLikeThoseInOne) {
    Recorded found;
    for (const auto& [syntax, name] :
         {std::array{"4.50", "jpeg_baseline"}, std::array{"4.70", "jpeg_lossless"},
          std::array{"4.80", "jpeg_ls"}, std::array{"4.90", "jpeg_2000"}}) {
        DicomFile slice = compressed(syntax, name, "u8");
        const std::string whole = slice.fragments[0];
        slice.fragments = {whole.substr(0, 50), whole.substr(50, 30), whole.substr(80)};
        found[syntax] = read_pair(slice, slice);
    }
    EXPECT_EQ(found["4.50"], test::kCompressed.at("4.50 u8"));
    for (const char* syntax : {"4.70", "4.80", "4.90"})
        EXPECT_EQ(found[syntax], test::kCompressed.at("u8")) << syntax;
}

/// Headers that say more or fewer bits than the codestream has.
TEST(DicomPixels, HeadersThatDisagreeWithTheCodestreamAreWhatTheyWere) {
    Recorded found;
    const auto said = [&](const char* syntax, const char* name, const char* kind, int allocated,
                          int stored, int is_signed) {
        DicomFile slice = compressed(syntax, name, kind);
        slice.bits_allocated = std::uint16_t(allocated);
        slice.bits_stored = std::uint16_t(stored);
        slice.high_bit = std::uint16_t(stored - 1);
        slice.is_signed = std::uint16_t(is_signed);
        found[std::string(name) + " " + kind + " as " + (is_signed ? "s" : "u") +
              std::to_string(stored) + "/" + std::to_string(allocated)] = read_pair(slice, slice);
    };
    for (const auto& [syntax, name] :
         {std::array{"4.70", "jpeg_lossless"}, std::array{"4.80", "jpeg_ls"},
          std::array{"4.90", "jpeg_2000"}}) {
        said(syntax, name, "u12", 16, 16, 0);
        said(syntax, name, "u16", 16, 12, 0);
        said(syntax, name, "s12", 16, 16, 1);
        said(syntax, name, "u12", 16, 12, 1);
        said(syntax, name, "s12", 16, 12, 0);
        said(syntax, name, "s16", 16, 16, 0);
        said(syntax, name, "u8", 16, 8, 0);
        said(syntax, name, "u8", 16, 16, 0);
    }
    expect_recorded(found, test::kDisagreeing);
}

}  // namespace
}  // namespace pliant
