// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "base/byte_order.h"
#include "base/errors.h"
#include "base/memory_budget.h"
#include "base/text.h"
#include "formats/dicom_folder.h"
#include "formats/dicom_slice.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

// The image size in a codestream's header. It is checked before decoding, because decoders write as
// many pixels as the codestream has, independent of the size in the DICOM header. This code decodes
// no pixels.
//
//   JPEG       FFD8, segments (marker, length), of which SOFn: bits, rows, columns, components
//   JPEG-LS    likewise, SOF55
//   JPEG 2000  FF4F FF51, SIZ: extent, origin, components; perhaps inside of JP2's boxes
//   RLE        16 numbers (number of segments, their offsets), then a segment for each byte of a
//              pixel, the highest first: n ≥ 0: n+1 bytes follow; n < 0: one byte, 1−n times

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

/// Checks that a codestream has the rows and columns of the slice, one component, at most the
/// allocated bits, and enough bytes for its pixels.
/// @param[out] bits  bits of its pixels; RLE: the allocated bits
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

// A minimal DICOM file for the decoder: the elements that it needs, with values that passed our
// checks, and the codestream in one piece. Everything else of the original is left out.

using namespace dicom_tags;

std::string u16(std::uint32_t value) {
    return {char(value & 0xff), char(value >> 8 & 0xff)};
}
std::string u32(std::uint32_t value) {
    return u16(value & 0xffff) + u16(value >> 16);
}
std::string tag_of(std::uint32_t tag) {
    return u16(tag >> 16) + u16(tag & 0xffff);
}
std::string element(std::uint32_t tag, const char* type, std::string value) {
    if (value.size() % 2) value += std::string_view(type) == "UI" ? '\0' : ' ';
    return tag_of(tag) + type + u16(std::uint32_t(value.size())) + value;
}
std::string number(std::uint32_t tag, int value) {
    return element(tag, "US", u16(std::uint32_t(value)));
}

/// Appends the part in front of the codestream, explicit little endian.
/// @param bits              allocated per pixel; 8, 16 or 32
/// @param codestream_bytes  even
void append_minimal_dicom(const DicomSlice& slice, int bits, std::uint32_t codestream_bytes,
                          std::vector<std::uint8_t>& file) {
    constexpr std::uint32_t kMetaLength = 0x00020000, kMetaClass = 0x00020002,
                            kMetaInstance = 0x00020003, kInstance = 0x00080018;
    const std::string sop_class = "1.2.840.10008.5.1.4.1.1.7", instance = "1.2.3";
    const DicomPixels& pixels = slice.pixels;
    const int stored = std::min(pixels.bits_stored, bits);
    const std::string meta = element(kMetaClass, "UI", sop_class) +
                             element(kMetaInstance, "UI", instance) +
                             element(kTransferSyntax, "UI", std::string(pixels.syntax.uid));
    std::string text(128, '\0');
    text += "DICM" + element(kMetaLength, "UL", u32(std::uint32_t(meta.size()))) + meta;
    text += element(kSopClass, "UI", sop_class) + element(kInstance, "UI", instance);
    text += number(kSamples, 1) + element(kPhotometric, "CS", "MONOCHROME2");
    text += number(kRows, slice.rows) + number(kColumns, slice.columns);
    text += number(kBitsAllocated, bits) + number(kBitsStored, stored);
    text += number(kHighBit, stored - 1) + number(kPixelRepresentation, pixels.is_signed);
    text += tag_of(kPixelData) + "OB" + u16(0) + u32(0xffffffff);
    text += tag_of(kItem) + u32(0) + tag_of(kItem) + u32(codestream_bytes);
    file.insert(file.end(), text.begin(), text.end());
}

/// Appends the part after the codestream.
void append_minimal_end(std::vector<std::uint8_t>& file) {
    const std::string text = tag_of(kSequenceEnd) + u32(0);
    file.insert(file.end(), text.begin(), text.end());
}

/// Memory limit of a decoder: a constant, plus a share per pixel and per encoded byte.
constexpr std::uint64_t kDecoderBytes = std::uint64_t(512) << 20;
constexpr std::uint64_t kDecoderBytesPerPixel = 32, kDecoderBytesPerByte = 6;

std::uint64_t bytes_in(const std::vector<FilePart>& parts) {
    std::uint64_t bytes = 0;
    for (const FilePart& part : parts) bytes += part.bytes;
    return bytes;
}

std::uint64_t pixels_in(const DicomSlice& slice) {
    return std::uint64_t(slice.rows) * std::uint64_t(slice.columns);
}

Status read_part(DicomInput& file, FilePart part, std::uint8_t* out) {
    file.seek(part.start);
    if (file.read(out, std::size_t(part.bytes)) == part.bytes) return Ok{};
    return file.fault("changed while it was read");
}

/// Extracts the stored bits of a pixel as a number.
template <class Stored>
class PixelBits {
  public:
    PixelBits(int bits, bool is_signed)
        : m_shift(int(sizeof(Stored)) * 8 - bits), m_is_signed(is_signed) {}
    std::int64_t operator()(Stored stored) const {
        using Signed = std::make_signed_t<Stored>;
        const auto high = Stored(stored << m_shift);  // shifts out the unused bits
        return m_is_signed ? std::int64_t(Signed(high) >> m_shift)
                           : std::int64_t(Stored(high >> m_shift));
    }

  private:
    int m_shift;
    bool m_is_signed;
};

/// Whether values of slope·stored + intercept are whole numbers that fit in 32 bits.
bool rescales_to_integers(const DicomSlice& slice, std::size_t bytes_per_pixel) {
    const auto small = [](double number, double limit) {
        return number == std::trunc(number) && std::abs(number) <= limit;
    };
    return bytes_per_pixel < 4 && small(slice.slope, 1 << 14) && small(slice.intercept, 1 << 29);
}

/// Number of pixels whose highest used bit is set. @param bits  used ones of a pixel
std::size_t count_top_bits(std::span<const std::uint8_t> bytes, int bytes_per_pixel, int bits) {
    const auto step = std::size_t(bytes_per_pixel), byte = std::size_t(bits - 1) / 8;
    std::size_t count = 0;
    for (std::size_t n = byte; n < bytes.size(); n += step)
        count += std::size_t(bytes[n] >> (bits - 1) % 8 & 1);
    return count;
}

/// The n-th of little-endian numbers.
template <class Stored>
Stored stored_at(std::span<const std::uint8_t> bytes, std::size_t n) {
    Stored stored;
    std::memcpy(&stored, &bytes[n * sizeof(Stored)], sizeof stored);
    return little_endian(stored);
}

}  // namespace

DicomPixelReader::DicomPixelReader(const std::vector<DicomSlice>& slices,
                                   const DecoderChoice& decoder)
    : m_program(decoder.program) {
    m_limits.seconds_per_slice = decoder.seconds_per_slice;
    m_limits.slices = slices.size();
    m_limits.memory_bytes = kDecoderBytes;
    for (const DicomSlice& slice : slices)
        m_limits.memory_bytes = std::max(m_limits.memory_bytes,
                                         kDecoderBytes + kDecoderBytesPerPixel * pixels_in(slice) +
                                             kDecoderBytesPerByte * bytes_in(slice.pixels.parts));
}

Status DicomPixelReader::read(const DicomSlice& slice, VoxelBuilder& voxels) {
    Status status = slice.pixels.compressed() ? read_compressed(slice) : read_plain(slice);
    if (!status) return status;
    add(slice, voxels);
    if (m_all_padding) {
        m_is_padding.resize(pixels_in(slice));
        m_all_padding->insert(m_all_padding->end(), m_is_padding.begin(), m_is_padding.end());
    }
    return status;
}

/// Allocates the pixels, after the check that the file is long enough for them.
void DicomPixelReader::make_room(const DicomSlice& slice) {
    m_bytes.resize(std::size_t(pixels_in(slice)) * std::size_t(slice.pixels.bits_allocated / 8));
}

/// Opens the slice's file, unless it is open because of another frame.
Status DicomPixelReader::open(const DicomSlice& slice) {
    if (m_input && m_input->path() == slice.path) return Ok{};
    m_input.emplace(slice.path);
    const std::uint64_t start = slice.pixels.deflated_from;
    return start ? m_input->inflate_from(start) : Status(Ok{});
}

Status DicomPixelReader::read_plain(const DicomSlice& slice) {
    make_room(slice);
    if (Status status = open(slice); !status) return status;
    const FilePart whole = slice.pixels.parts.front();
    if (Status status = read_part(*m_input, {whole.start, m_bytes.size()}, m_bytes.data()); !status)
        return status;
    if (const std::size_t unit = slice.pixels.swapped_bytes)
        for (std::size_t n = 0; n + unit <= m_bytes.size(); n += unit)
            std::reverse(&m_bytes[n], &m_bytes[n] + unit);
    m_is_signed = slice.pixels.is_signed;
    m_bits = slice.pixels.bits_stored;
    return Ok{};
}

Status DicomPixelReader::start_decoder(const DicomSlice& slice) {
    const auto of_slice = [&](const Error& error) {
        return Error{error.code, slice.path.string() + ": " + error.message};
    };
    if (m_program.empty()) {
        auto found = find_pixel_decoder();
        if (!found)
            return Error{
                found.error().code,
                slice.path.string() + ": its pixels are compressed, and " + found.error().message};
        m_program = *found;
    }
    if (!has_memory_for(m_limits.memory_bytes - kDecoderBytes))
        return of_slice({ErrorCode::LimitExceeded, "not enough memory to decode its pixels"});
    auto decoder = PixelDecoder::start(m_program, m_limits);
    if (!decoder) return of_slice(decoder.error());
    m_decoder = std::move(*decoder);
    return Ok{};
}

Status DicomPixelReader::read_compressed(const DicomSlice& slice) {
    const std::uint64_t size = bytes_in(slice.pixels.parts), padded = size + size % 2;
    if (padded >= 0xffffffff)
        return unsupported(slice.path, "has " + std::to_string(size) +
                                           " bytes of compressed pixels, expected fewer");
    std::vector<std::uint8_t> codestream(std::size_t(padded), 0);
    if (Status status = open(slice); !status) return status;
    std::size_t at = 0;
    for (const FilePart& part : slice.pixels.parts) {
        if (Status status = read_part(*m_input, part, &codestream[at]); !status) return status;
        at += std::size_t(part.bytes);
    }
    int bits = 0;
    if (Status status = check_codestream(slice, codestream, bits); !status) return status;
    // GDCM decodes JPEG-LS with up to 8 bits to bytes.
    const bool narrow = slice.pixels.syntax.codec == PixelCodec::JpegLs && bits <= 8;
    const int allocated = narrow ? 8 : slice.pixels.bits_allocated;
    if (!m_decoder)
        if (Status status = start_decoder(slice); !status) return status;
    PixelRequest request;
    request.columns = std::uint32_t(slice.columns);
    request.rows = std::uint32_t(slice.rows);
    request.bytes_per_pixel = std::uint32_t(slice.pixels.bits_allocated / 8);
    m_message.assign(sizeof request, 0);
    append_minimal_dicom(slice, allocated, std::uint32_t(padded), m_message);
    m_message.insert(m_message.end(), codestream.begin(), codestream.end());
    append_minimal_end(m_message);
    request.dicom_bytes = m_message.size() - sizeof request;
    std::memcpy(m_message.data(), &request, sizeof request);
    make_room(slice);
    const auto is_signed = m_decoder->decode(m_message, m_bytes);
    if (!is_signed)
        return Error{is_signed.error().code,
                     slice.path.string() + ": " + is_signed.error().message};
    m_is_signed = *is_signed;
    m_bits = slice.pixels.bits_allocated;  // the decoder has set the unused bits
    return Ok{};
}

std::vector<std::string> DicomPixelReader::notes() const {
    std::vector<std::string> notes;
    if (m_doubtful)
        notes.push_back("Pixel Representation is missing: pixels are taken as unsigned, " +
                        counted(m_doubtful, "of them has", "of them have") +
                        " the bit that would be the sign");
    if (m_padded)
        notes.push_back(counted(m_padded, "voxel", "voxels") + " of padding became " +
                        short_text(m_padding_value));
    if (!m_kept_padding.empty())
        notes.push_back(
            "the Pixel Padding Value is kept where it lies between other values, "
            "first in " +
            m_kept_padding);
    return notes;
}

/// Marks padding. A padding value between other values of the slice may be an image's, and is kept.
template <class Stored, class Number>
void DicomPixelReader::find_padding(const DicomSlice& slice, const Number& number) {
    m_is_padding.clear();
    const auto& padding = slice.pixels.padding;
    if (!padding) return;
    m_is_padding.resize(m_bytes.size() / sizeof(Stored));
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (std::size_t n = 0; n < m_is_padding.size(); ++n) {
        const auto stored = stored_at<Stored>(m_bytes, n);
        const auto value = double(number(stored));
        bool is_padding = value >= padding->low && value <= padding->high;
        if constexpr (std::is_same_v<Stored, std::uint16_t>)
            is_padding = is_padding || (padding->word && stored == Stored(*padding->word));
        m_is_padding[n] = is_padding;
        if (is_padding) continue;
        if (value < lowest) lowest = value;
        if (value > highest) highest = value;
    }
    if (!(lowest < padding->low && highest > padding->high)) return;
    if (std::find(m_is_padding.begin(), m_is_padding.end(), true) != m_is_padding.end() &&
        m_kept_padding.empty())
        m_kept_padding = slice.name();
    m_is_padding.clear();
}

/// Adds the rescaled values of a slice, and its padding as air.
template <class Stored, class Value, class Rescale>
void DicomPixelReader::add_as(const DicomSlice& slice, Component component, const Rescale& rescale,
                              VoxelBuilder& voxels) {
    std::vector<Value> values(m_bytes.size() / sizeof(Stored));
    for (std::size_t n = 0; n < values.size(); ++n) {
        values[n] = rescale(stored_at<Stored>(m_bytes, n));
    }
    const auto air = Value(slice.padding_value());
    for (std::size_t n = 0; n < m_is_padding.size(); ++n) {
        const bool is_air = values[n] >= air && values[n] <= (air < 0 ? Value(kAirHu) : air);
        if (!m_is_padding[n] || is_air) continue;
        values[n] = air;
        ++m_padded;
        m_padding_value = double(air);
    }
    voxels.add(component, values.data(), values.size());
}

template <class Stored, class Number>
void DicomPixelReader::add_numbers(const DicomSlice& slice, const Number& number,
                                   VoxelBuilder& voxels) {
    find_padding<Stored>(slice, number);
    if constexpr (std::is_floating_point_v<Stored>) {
        constexpr Component kOwn =
            sizeof(Stored) == sizeof(double) ? Component::Float64 : Component::Float32;
        if (slice.slope == 1 && slice.intercept == 0)
            return add_as<Stored, Stored>(slice, kOwn, number, voxels);
    } else if (rescales_to_integers(slice, sizeof(Stored))) {
        const auto slope = std::int32_t(slice.slope), intercept = std::int32_t(slice.intercept);
        return add_as<Stored, std::int32_t>(
            slice, Component::Int32,
            [&](Stored stored) { return slope * std::int32_t(number(stored)) + intercept; },
            voxels);
    }
    add_as<Stored, double>(
        slice, Component::Float64,
        [&](Stored stored) { return slice.slope * double(number(stored)) + slice.intercept; },
        voxels);
}

void DicomPixelReader::add(const DicomSlice& slice, VoxelBuilder& voxels) {
    const auto own = [](auto stored) { return stored; };
    const auto bits = [&]<class Stored>(Stored) {
        add_numbers<Stored>(slice, PixelBits<Stored>(m_bits, m_is_signed), voxels);
    };
    const int bytes_per_pixel = slice.pixels.bits_allocated / 8;
    if (slice.pixels.numbers == PixelNumbers::Float32)
        return add_numbers<float>(slice, own, voxels);
    if (slice.pixels.numbers == PixelNumbers::Float64)
        return add_numbers<double>(slice, own, voxels);
    if (slice.pixels.is_sign_unknown && !m_is_signed)
        m_doubtful += count_top_bits(m_bytes, bytes_per_pixel, m_bits);
    if (bytes_per_pixel == 1) return bits(std::uint8_t());
    if (bytes_per_pixel == 2) return bits(std::uint16_t());
    bits(std::uint32_t());
}

}  // namespace pliant
