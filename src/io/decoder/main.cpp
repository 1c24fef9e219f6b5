// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// pliant-decode-pixels MEMORY_BYTES SECONDS: started by Pliant for compressed DICOM pixels, with a
// socket as descriptor 3 (formats/pixel_messages.h). It drops all unneeded privileges before it
// reads the first byte. It exits on errors without an answer; the other side treats that as a
// failure.

#include <gdcmGlobal.h>
#include <gdcmImage.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmPixelFormat.h>
#include <gdcmTrace.h>
#include <malloc.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <istream>
#include <new>
#include <span>
#include <streambuf>
#include <vector>

#include "base/byte_order.h"
#include "decoder/sandbox.h"
#include "formats/pixel_messages.h"

namespace pliant::decoder {
namespace {

// Decodes a DICOM file in memory by GDCM.

/// Stream buffer over bytes in memory.
class Memory : public std::streambuf {
  public:
    explicit Memory(std::span<char> bytes) {
        setg(bytes.data(), bytes.data(), bytes.data() + bytes.size());
    }

  protected:
    pos_type seekoff(off_type by, std::ios_base::seekdir from, std::ios_base::openmode) override {
        const off_type size = egptr() - eback();
        const off_type base = from == std::ios_base::beg   ? 0
                              : from == std::ios_base::cur ? gptr() - eback()
                                                           : size;
        if (by < -base || by > size - base) return pos_type(off_type(-1));
        setg(eback(), eback() + base + by, egptr());
        return pos_type(base + by);
    }
    pos_type seekpos(pos_type to, std::ios_base::openmode mode) override {
        return seekoff(off_type(to), std::ios_base::beg, mode);
    }
};

/// Widens pixels in place, from the last to the first.
/// @param is_signed  sign-extends
void widen(std::vector<char>& pixels, std::size_t count, std::size_t from, std::size_t to,
           bool is_signed) {
    pixels.resize(count * to);
    for (std::size_t n = count; n-- > 0;) {
        char* const wide = &pixels[n * to];
        const char* const narrow = &pixels[n * from];
        const bool negative = is_signed && (narrow[from - 1] & 0x80);
        for (std::size_t b = to; b-- > 0;)
            wide[b] = b < from ? narrow[b] : negative ? char(-1) : char(0);
    }
}

PixelStatus decode_or_throw(const PixelRequest& request, std::span<char> dicom,
                            std::vector<char>& pixels, bool& is_signed) {
    Memory memory(dicom);
    std::istream stream(&memory);
    gdcm::ImageReader reader;
    reader.SetStream(stream);
    if (!reader.Read()) return PixelStatus::Undecodable;
    const gdcm::Image& image = reader.GetImage();
    const std::size_t count = std::size_t(request.columns) * request.rows;
    if (image.GetNumberOfDimensions() != 2 || image.GetDimension(0) != request.columns ||
        image.GetDimension(1) != request.rows)
        return PixelStatus::Undecodable;
    // Converting to uncompressed makes GDCM set the unused bits, to zero or to the sign.
    gdcm::ImageChangeTransferSyntax change;
    change.SetInput(image);
    change.SetTransferSyntax(gdcm::TransferSyntax::ImplicitVRLittleEndian);
    if (!change.Change()) return PixelStatus::Undecodable;
    const gdcm::Image& plain = change.GetOutput();
    const std::size_t length = plain.GetBufferLength();
    if (length > count * request.bytes_per_pixel) return PixelStatus::Undecodable;
    pixels.resize(length);
    if (!plain.GetBuffer(pixels.data())) return PixelStatus::Undecodable;
    const gdcm::PixelFormat& format = plain.GetPixelFormat();
    const std::size_t bytes = format.GetPixelSize();
    if (bytes == 0 || bytes > request.bytes_per_pixel || length != count * bytes ||
        format.GetSamplesPerPixel() != 1 || format.GetBitsAllocated() != 8 * bytes)
        return PixelStatus::Undecodable;
    is_signed = format.GetPixelRepresentation() != 0;
    // GDCM's are in the machine's byte order.
    for (std::size_t n = 0; kIsBigEndian && n < length; n += bytes)
        std::reverse(&pixels[n], &pixels[n] + bytes);
    if (bytes < request.bytes_per_pixel)
        widen(pixels, count, bytes, request.bytes_per_pixel, is_signed);
    return PixelStatus::Decoded;
}

/// @param[out] pixels  columns·rows numbers of bytes_per_pixel, little endian
/// @param[out] is_signed  whether these are signed
PixelStatus decode(const PixelRequest& request, std::span<char> dicom, std::vector<char>& pixels,
                   bool& is_signed) {
    try {
        return decode_or_throw(request, dicom, pixels, is_signed);
    } catch (const std::bad_alloc&) {
        return PixelStatus::OutOfMemory;
    } catch (const std::exception&) {
        return PixelStatus::Undecodable;
    }
}

bool read_all(char* out, std::size_t count) {
    while (count > 0) {
        const ssize_t got = ::read(kDecoderSocket, out, count);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        out += got;
        count -= std::size_t(got);
    }
    return true;
}

bool write_all(const char* bytes, std::size_t count) {
    while (count > 0) {
        const ssize_t put = ::write(kDecoderSocket, bytes, count);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return false;
        bytes += put;
        count -= std::size_t(put);
    }
    return true;
}

bool write_answer(PixelStatus status, bool is_signed, const std::vector<char>& pixels) {
    PixelAnswer answer;
    answer.status = status;
    answer.is_signed = is_signed;
    char bytes[sizeof answer];
    std::memcpy(bytes, &answer, sizeof answer);
    return write_all(bytes, sizeof bytes) &&
           (status != PixelStatus::Decoded || write_all(pixels.data(), pixels.size()));
}

/// @returns whether another request may follow
bool serve_one() {
    PixelRequest request;
    char bytes[sizeof request];
    if (!read_all(bytes, sizeof bytes)) return false;
    std::memcpy(&request, bytes, sizeof bytes);
    if (request.magic != PixelRequest::kMagic) return false;
    std::vector<char> dicom, pixels;
    try {
        dicom.resize(std::size_t(request.dicom_bytes));
    } catch (const std::exception&) {
        write_answer(PixelStatus::OutOfMemory, false, {});
        return false;
    }
    if (!read_all(dicom.data(), dicom.size())) return false;
    bool is_signed = false;
    const PixelStatus status = decode(request, dicom, pixels, is_signed);
    return write_answer(status, is_signed, pixels);
}

}  // namespace
}  // namespace pliant::decoder

int main(int count, char** arguments) {
    using namespace pliant;
    if (count != 3) {
        std::fprintf(stderr, "%s: is started by Pliant, to decode pixels of DICOM files\n",
                     kDecoderName);
        return 2;
    }
    const std::uint64_t memory_bytes = std::strtoull(arguments[1], nullptr, 10);
    const std::uint64_t seconds = std::strtoull(arguments[2], nullptr, 10);
    // Decoding threads need small stacks, and share their heaps.
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, std::size_t(1) << 20);
    pthread_setattr_default_np(&attributes);
    ::mallopt(M_ARENA_MAX, 2);
    // Initialises GDCM before the sandbox closes.
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    gdcm::Global::GetInstance();
    decoder::close_descriptors_from(kDecoderSocket + 1);
    decoder::set_limits(memory_bytes, seconds);
    decoder::forbid_system_calls(kDecoderSocket);
    while (decoder::serve_one()) {
    }
    return 0;
}
