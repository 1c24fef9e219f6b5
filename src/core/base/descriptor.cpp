// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/descriptor.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace pliant {
namespace {

constexpr std::size_t kMaxAtOnce = std::size_t(1) << 30;

}  // namespace

int Descriptor::close() noexcept {
    if (m_number < 0) return 0;
    return ::close(release()) == 0 ? 0 : errno;
}

Descriptor open_file(const std::filesystem::path& path, int flags, unsigned mode) noexcept {
    return Descriptor(::open(path.c_str(), flags | O_CLOEXEC, mode));
}

int write_all(int descriptor, const void* bytes, std::size_t count, std::size_t* written) noexcept {
    const auto* at = static_cast<const char*>(bytes);
    std::size_t done = 0;
    int error = 0;
    while (done < count && !error) {
        const ssize_t n = ::write(descriptor, at + done, std::min(count - done, kMaxAtOnce));
        if (n > 0) {
            done += std::size_t(n);
        } else if (n == 0) {
            error = EIO;
        } else if (errno == EAGAIN) {
            pollfd ready{descriptor, POLLOUT, 0};
            ::poll(&ready, 1, -1);
        } else if (errno != EINTR) {
            error = errno;
        }
    }
    if (written) *written = done;
    return error;
}

int read_at(int descriptor, void* out, std::size_t count, std::uint64_t offset,
            std::size_t* read) noexcept {
    int error = 0;
    for (*read = 0; *read < count && !error;) {
        const ssize_t n = ::pread(descriptor, static_cast<char*>(out) + *read,
                                  std::min(count - *read, kMaxAtOnce), off_t(offset + *read));
        if (n == 0) break;
        if (n > 0)
            *read += std::size_t(n);
        else if (errno != EINTR)
            error = errno;
    }
    return error;
}

bool try_lock(int descriptor) noexcept {
    return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
}

int sync_data(int descriptor) noexcept {
    return ::fdatasync(descriptor) == 0 ? 0 : errno;
}

}  // namespace pliant
