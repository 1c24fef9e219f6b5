// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/output_stream.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <string_view>
#include <system_error>

#include "base/descriptor.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

Error not_written(const fs::path& path, const std::string& why) {
    return {ErrorCode::Unwritable, path.string() + ": can't be written (" + why + ")"};
}
Error not_written(const fs::path& path, int number) {
    return not_written(path, std::generic_category().message(number));
}

/// Opens a stream. A pipe without a reader can't be opened for writing, so this is retried.
Descriptor open_stream(const fs::path& path) {
    constexpr int kTries = 40, kPause_ms = 50;
    for (int n = 0;; ++n) {
        Descriptor opened = open_file(path, O_WRONLY | O_NONBLOCK | O_NOCTTY);
        if (opened.is_open() || errno != ENXIO || n == kTries) return opened;
        ::poll(nullptr, 0, kPause_ms);
    }
}

}  // namespace

std::optional<int> descriptor_of(const fs::path& path) {
    std::string_view text = path.native();
    if (text == "/dev/stdin") return STDIN_FILENO;
    if (text == "/dev/stdout") return STDOUT_FILENO;
    if (text == "/dev/stderr") return STDERR_FILENO;
    for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
        if (!text.starts_with(folder)) continue;
        text.remove_prefix(folder.size());
        int number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error == std::errc{} && end == text.data() + text.size() && number >= 0) return number;
        return std::nullopt;
    }
    return std::nullopt;
}

std::optional<OutputStream> OutputStream::of(const fs::path& path, bool is_standard_output) {
    if (is_standard_output) return OutputStream(path, STDOUT_FILENO);
    if (const auto descriptor = descriptor_of(path)) return OutputStream(path, *descriptor);
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (fs::is_character_file(status) || fs::is_fifo(status)) return OutputStream(path, -1);
    return std::nullopt;
}

Status OutputStream::check() const {
    if (m_descriptor < 0) return Ok{};
    const int flags = ::fcntl(m_descriptor, F_GETFL);
    if (flags < 0) return not_written(m_path, errno);
    if ((flags & O_ACCMODE) == O_RDONLY) return not_written(m_path, EBADF);
    return Ok{};
}

Status OutputStream::write(const fs::path& file) const {
    const Descriptor from = open_file(file, O_RDONLY);
    if (!from.is_open()) return not_written(m_path, errno);
    Descriptor own;
    if (m_descriptor < 0) own = open_stream(m_path);
    if (m_descriptor < 0 && !own.is_open())
        return errno == ENXIO ? not_written(m_path, "no process reads it")
                              : not_written(m_path, errno);
    const int to = m_descriptor < 0 ? own.number() : m_descriptor;
    if (to == STDOUT_FILENO) std::fflush(stdout);  // flush earlier text first
    std::array<char, 1 << 16> piece;
    for (;;) {
        const ssize_t count = ::read(from.number(), piece.data(), piece.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return not_written(m_path, errno);
        if (count == 0) return Ok{};
        if (const int failed = write_all(to, piece.data(), std::size_t(count)))
            return not_written(m_path, failed);
    }
}

}  // namespace pliant
