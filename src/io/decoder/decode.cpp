// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "decoder/decode.h"

#include <gdcmImage.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmPixelFormat.h>

#include <cstddef>
#include <exception>
#include <istream>
#include <new>
#include <streambuf>

namespace pliant::decoder {
namespace {

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
    if (bytes < request.bytes_per_pixel)
        widen(pixels, count, bytes, request.bytes_per_pixel, is_signed);
    return PixelStatus::Decoded;
}

}  // namespace

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

}  // namespace pliant::decoder
