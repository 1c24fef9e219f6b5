// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/dicom_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

#include "base/errors.h"
#include "base/input_file.h"
#include "base/memory_budget.h"
#include "formats/dicom_codestream.h"
#include "formats/dicom_minimal.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

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

Status read_part(InputFile& file, FilePart part, std::uint8_t* out) {
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

template <class Stored, class Value, class Rescale>
void add_as(std::span<const std::uint8_t> bytes, Component component, Rescale&& rescale,
            VoxelBuilder& voxels) {
    std::vector<Value> values(bytes.size() / sizeof(Stored));
    for (std::size_t n = 0; n < values.size(); ++n) {
        Stored stored;
        std::memcpy(&stored, &bytes[n * sizeof(Stored)], sizeof stored);
        values[n] = rescale(stored);
    }
    voxels.add(component, values.data(), values.size());
}

template <class Stored>
void add_pixels(const DicomSlice& slice, std::span<const std::uint8_t> bytes, int bits,
                bool is_signed, VoxelBuilder& voxels) {
    const PixelBits<Stored> number(bits, is_signed);
    if (rescales_to_integers(slice, sizeof(Stored))) {
        const auto slope = std::int32_t(slice.slope), intercept = std::int32_t(slice.intercept);
        add_as<Stored, std::int32_t>(
            bytes, Component::Int32,
            [&](Stored stored) { return slope * std::int32_t(number(stored)) + intercept; },
            voxels);
    } else {
        add_as<Stored, double>(
            bytes, Component::Float64,
            [&](Stored stored) { return slice.slope * double(number(stored)) + slice.intercept; },
            voxels);
    }
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
    if (status) add(slice, voxels);
    return status;
}

/// Allocates the pixels, after the check that the file is long enough for them.
void DicomPixelReader::make_room(const DicomSlice& slice) {
    m_bytes.resize(std::size_t(pixels_in(slice)) * std::size_t(slice.pixels.bits_allocated / 8));
}

Status DicomPixelReader::read_plain(const DicomSlice& slice) {
    make_room(slice);
    InputFile file(slice.path);
    const FilePart whole = slice.pixels.parts.front();
    if (Status status = read_part(file, {whole.start, m_bytes.size()}, m_bytes.data()); !status)
        return status;
    if (slice.pixels.swapped_words)
        for (std::size_t n = 0; n + 1 < m_bytes.size(); n += 2)
            std::swap(m_bytes[n], m_bytes[n + 1]);
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
    InputFile file(slice.path);
    std::size_t at = 0;
    for (const FilePart& part : slice.pixels.parts) {
        if (Status status = read_part(file, part, &codestream[at]); !status) return status;
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

void DicomPixelReader::add(const DicomSlice& slice, VoxelBuilder& voxels) {
    if (m_bytes.size() == pixels_in(slice))
        return add_pixels<std::uint8_t>(slice, m_bytes, m_bits, m_is_signed, voxels);
    if (m_bytes.size() == 2 * pixels_in(slice))
        return add_pixels<std::uint16_t>(slice, m_bytes, m_bits, m_is_signed, voxels);
    add_pixels<std::uint32_t>(slice, m_bytes, m_bits, m_is_signed, voxels);
}

}  // namespace pliant
