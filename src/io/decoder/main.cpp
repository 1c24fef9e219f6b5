// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// pliant-decode-pixels MEMORY_BYTES SECONDS: started by Pliant for compressed DICOM pixels, with a
// socket as descriptor 3 (formats/pixel_messages.h). It drops all unneeded privileges before it
// reads the first byte. It exits on errors without an answer; the other side treats that as a
// failure.

#include <gdcmGlobal.h>
#include <gdcmTrace.h>
#include <malloc.h>
#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "decoder/decode.h"
#include "decoder/sandbox.h"

namespace pliant::decoder {
namespace {

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
