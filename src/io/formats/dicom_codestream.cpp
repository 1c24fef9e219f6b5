// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_codestream.h"

#include "base/errors.h"

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <string>

namespace pliant {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// Size in a codestream's header.
struct CodestreamSize {
    std::uint64_t columns = 0, rows = 0;
    int components = 0, bits = 0;
    std::uint64_t smallest_bytes = 0;  ///< minimum length of an encoding of all pixels
};

std::uint32_t u16(Bytes bytes, std::size_t at) {
    return std::uint32_t(bytes[at]) << 8 | bytes[at + 1];
}
std::uint32_t u32(Bytes bytes, std::size_t at) {
    return u16(bytes, at) << 16 | u16(bytes, at + 2);
}
std::uint32_t u32_little(Bytes bytes, std::size_t at) {
    return std::uint32_t(bytes[at + 3]) << 24 | std::uint32_t(bytes[at + 2]) << 16 |
           std::uint32_t(bytes[at + 1]) << 8 | bytes[at];
}

/// Lower bound of the encoded bits: one code per pixel without a transform; two codes (DC, end of
/// block) per block of 8 × 8; one end of run per row in JPEG-LS. Progressive JPEG has no such
/// bound.
std::uint64_t smallest_bits(std::uint8_t frame, std::uint64_t columns, std::uint64_t rows) {
    if (frame == 0xc3) return columns * rows;
    if (frame == 0xf7) return rows;
    return frame == 0xc2 ? 0 : 2 * ((columns + 7) / 8) * ((rows + 7) / 8);
}

/// @param frames  allowed SOFn markers of the transfer syntax
std::optional<CodestreamSize> jpeg_size(Bytes bytes, std::initializer_list<std::uint8_t> frames) {
    if (bytes.size() < 4 || u16(bytes, 0) != 0xffd8) return std::nullopt;
    for (std::size_t at = 2; at + 4 <= bytes.size();) {
        if (bytes[at] != 0xff) return std::nullopt;
        const std::uint8_t marker = bytes[at + 1];
        if (marker == 0xff) {  // fill bytes may precede a marker
            ++at;
            continue;
        }
        const std::size_t length = u16(bytes, at + 2);
        if (marker < 0xc0 || (marker >= 0xd0 && marker <= 0xda) || length < 2) return std::nullopt;
        const bool starts_frame =
            (marker < 0xd0 && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) || marker == 0xf7;
        if (starts_frame) {
            if (std::find(frames.begin(), frames.end(), marker) == frames.end()) return {};
            if (length < 8 || at + 10 > bytes.size()) return std::nullopt;
            CodestreamSize size;
            size.bits = bytes[at + 4];
            size.rows = u16(bytes, at + 5);
            size.columns = u16(bytes, at + 7);
            size.components = bytes[at + 9];
            size.smallest_bytes = smallest_bits(marker, size.columns, size.rows) / 8;
            return size;
        }
        at += 2 + length;
    }
    return std::nullopt;
}

/// Extracts the codestream from JP2's boxes: length(4) type(4), and length(8) if the first is 1.
Bytes inside_of_boxes(Bytes bytes) {
    constexpr std::uint32_t kSignature = 0x6a502020, kCodestream = 0x6a703263;
    if (bytes.size() < 12 || u32(bytes, 0) != 12 || u32(bytes, 4) != kSignature) return bytes;
    while (bytes.size() >= 8) {
        std::uint64_t length = u32(bytes, 0);
        const std::uint32_t type = u32(bytes, 4);
        std::size_t header = 8;
        if (length == 1) {
            if (bytes.size() < 16) return {};
            length = std::uint64_t(u32(bytes, 8)) << 32 | u32(bytes, 12);
            header = 16;
        }
        if (length == 0) length = bytes.size();  // until the end
        if (length < header || length > bytes.size()) return {};
        if (type == kCodestream) return bytes.first(std::size_t(length)).subspan(header);
        bytes = bytes.subspan(std::size_t(length));
    }
    return {};
}

std::optional<CodestreamSize> jpeg_2000_size(Bytes bytes) {
    bytes = inside_of_boxes(bytes);
    // SOC, SIZ, its length, capabilities; 8 numbers, the component count, 3 bytes per component.
    constexpr std::size_t kNumbers = 8, kComponents = 40, kFirst = 42;
    if (bytes.size() < kFirst + 3 || u32(bytes, 0) != 0xff4fff51) return std::nullopt;
    const std::uint64_t right = u32(bytes, kNumbers), bottom = u32(bytes, kNumbers + 4);
    const std::uint64_t left = u32(bytes, kNumbers + 8), top = u32(bytes, kNumbers + 12);
    const int step_x = bytes[kFirst + 1], step_y = bytes[kFirst + 2];
    if (left >= right || top >= bottom || step_x != 1 || step_y != 1) return std::nullopt;
    CodestreamSize size;
    size.columns = right - left;
    size.rows = bottom - top;
    size.components = int(u16(bytes, kComponents));
    size.bits = (bytes[kFirst] & 0x7f) + 1;
    return size;
}

/// Whether a segment of RLE decodes to exactly `count` bytes, with only zeros after them.
bool has_run_bytes(Bytes segment, std::uint64_t count) {
    std::uint64_t made = 0;
    std::size_t at = 0;
    while (made < count && at < segment.size()) {
        const auto n = std::int8_t(segment[at++]);
        if (n == -128) continue;
        const std::size_t taken = n >= 0 ? std::size_t(n) + 1 : 1;
        if (taken > segment.size() - at) return false;
        at += taken;
        made += n >= 0 ? taken : std::size_t(1 - n);
    }
    if (made != count) return false;
    return std::all_of(segment.begin() + std::ptrdiff_t(at), segment.end(),
                       [](std::uint8_t byte) { return byte == 0; });
}

Status check_rle(const DicomSlice& slice, Bytes bytes) {
    constexpr std::size_t kHeaderBytes = 64;
    const auto expected = std::size_t(slice.pixels.bits_allocated / 8);
    const std::size_t found = bytes.size() < kHeaderBytes ? 0 : u32_little(bytes, 0);
    if (found != expected)
        return unreadable(slice.path, "has " + std::to_string(found) +
                                          " segments of run lengths, expected " +
                                          std::to_string(expected));
    const std::uint64_t pixels = std::uint64_t(slice.rows) * std::uint64_t(slice.columns);
    for (std::size_t n = 0; n < found; ++n) {
        const std::size_t start = u32_little(bytes, 4 + 4 * n);
        const std::size_t end = n + 1 < found ? u32_little(bytes, 8 + 4 * n) : bytes.size();
        if (start < kHeaderBytes || start > end || end > bytes.size() ||
            !has_run_bytes(bytes.subspan(start, end - start), pixels))
            return unreadable(slice.path, "has run lengths that don't make " +
                                              std::to_string(slice.columns) + " × " +
                                              std::to_string(slice.rows) + " pixels");
    }
    return Ok{};
}

std::optional<CodestreamSize> size_of_codestream(PixelCodec codec, Bytes bytes) {
    if (codec == PixelCodec::Jpeg) return jpeg_size(bytes, {0xc0, 0xc1, 0xc2, 0xc3});
    if (codec == PixelCodec::JpegLs) return jpeg_size(bytes, {0xf7});
    return jpeg_2000_size(bytes);
}

}  // namespace

Status check_codestream(const DicomSlice& slice, Bytes codestream, int& bits) {
    const DicomPixels& pixels = slice.pixels;
    bits = pixels.bits_allocated;
    if (pixels.syntax.codec == PixelCodec::Rle) return check_rle(slice, codestream);
    const auto size = size_of_codestream(pixels.syntax.codec, codestream);
    if (!size) return unreadable(slice.path, "has compressed pixels that don't say their size");
    if (size->columns != std::uint64_t(slice.columns) || size->rows != std::uint64_t(slice.rows) ||
        size->components != 1 || size->bits < 1 || size->bits > pixels.bits_allocated)
        return unreadable(slice.path,
                          "has compressed pixels for " + std::to_string(size->columns) + " × " +
                              std::to_string(size->rows) + " (" + std::to_string(size->components) +
                              " × " + std::to_string(size->bits) + " bits), expected " +
                              std::to_string(slice.columns) + " × " + std::to_string(slice.rows) +
                              " (1 × up to " + std::to_string(pixels.bits_allocated) + " bits)");
    if (codestream.size() < size->smallest_bytes)
        return unreadable(slice.path, "has " + std::to_string(codestream.size()) +
                                          " bytes of compressed pixels, expected " +
                                          std::to_string(size->smallest_bytes) + " or more");
    bits = size->bits;
    return Ok{};
}

}  // namespace pliant
