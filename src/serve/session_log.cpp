// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "serve/session_log.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "core/hash.h"
#include "serve/messages.h"

namespace pliant::serve {
namespace {

constexpr std::size_t kChecksumDigits = 16;

std::uint64_t checksum(std::uint64_t chain, std::string_view text) {
    Hash64 hash;
    hash.add_word(chain);
    hash.add(std::span<const char>(text));
    return hash.value();
}

Error unwritable(const std::string& path, const std::string& what) {
    return {ErrorCode::Unwritable, path + ": " + what};
}

}  // namespace

Result<SessionFile> read_session(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    if (!stream)
        return Error{ErrorCode::NotFound, path.string() + ": expected a session, found no file"};
    const std::string bytes{std::istreambuf_iterator<char>(stream),
                            std::istreambuf_iterator<char>()};
    SessionFile file;
    std::size_t at = 0, line_number = 0;
    while (at < bytes.size()) {
        ++line_number;
        const std::size_t end = bytes.find('\n', at);
        const auto fail = [&](const std::string& what) {
            return Error{ErrorCode::Unreadable,
                         path.string() + ": line " + std::to_string(line_number) + ": " + what};
        };
        const bool is_last = end == std::string::npos || end + 1 == bytes.size();
        if (end == std::string::npos) {
            if (line_number == 1) return fail("expected a session of pliant serve");
            break;
        }
        const std::string_view line(bytes.data() + at, end - at);
        const std::string_view text =
            line.size() > kChecksumDigits ? line.substr(kChecksumDigits + 1) : std::string_view();
        const std::uint64_t chain = checksum(file.chain, text);
        if (text.empty() || !line.starts_with(hex_text(chain, kChecksumDigits) + " ")) {
            if (is_last && line_number > 1) break;
            return fail("expected a checksum that fits, found damage");
        }
        if (line_number == 1) {
            auto header = parse_session_header(text);
            if (!header.ok()) return fail(header.error().message);
            file.header = std::move(*header);
        } else {
            auto record = parse_session_record(text);
            if (!record.ok()) return fail(record.error().message);
            file.records.push_back(std::move(*record));
        }
        file.chain = chain;
        at = end + 1;
        file.good_bytes = at;
    }
    if (line_number == 0)
        return Error{ErrorCode::Unreadable,
                     path.string() + ": expected a session of pliant serve, found an empty file"};
    file.cut_off_bytes = bytes.size() - file.good_bytes;
    return file;
}

Result<std::unique_ptr<SessionLog>> SessionLog::create(const std::filesystem::path& path,
                                                       const SessionHeader& header) {
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor < 0)
        return unwritable(path.string(), std::string("expected to make a new file, found: ") +
                                             std::strerror(errno));
    ::flock(descriptor, LOCK_EX | LOCK_NB);
    auto log = std::unique_ptr<SessionLog>(new SessionLog(path, descriptor, 0));
    log->add_line(text_of(header));
    if (const Status s = log->flush(); !s.ok()) return s.error();
    return log;
}

Result<std::unique_ptr<SessionLog>> SessionLog::go_on(const std::filesystem::path& path,
                                                      const SessionFile& file) {
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    const auto fail = [&](const std::string& what) {
        const int error = errno;
        if (descriptor >= 0) ::close(descriptor);
        return unwritable(path.string(), what + std::strerror(error));
    };
    if (descriptor < 0) return fail("expected a file to write to, found: ");
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0)
        return fail("expected that nobody else has this session open: ");
    if (::ftruncate(descriptor, off_t(file.good_bytes)) != 0 ||
        ::lseek(descriptor, 0, SEEK_END) != off_t(file.good_bytes))
        return fail("expected to write at its end, found: ");
    return std::unique_ptr<SessionLog>(new SessionLog(path, descriptor, file.chain));
}

SessionLog::SessionLog(const std::filesystem::path& path, int descriptor, std::uint64_t chain)
    : m_path(path.string()),
      m_descriptor(descriptor),
      m_chain(chain),
      m_syncer([this](const std::stop_token& stop) { keep_syncing(stop); }) {}

SessionLog::~SessionLog() {
    (void)flush();
    m_syncer.request_stop();
    m_syncer.join();
    ::fdatasync(m_descriptor);
    ::close(m_descriptor);
}

void SessionLog::keep_syncing(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
        {
            std::unique_lock lock(m_mutex);
            if (!m_wake.wait(lock, stop, [&] { return m_unsynced; })) return;
            m_unsynced = false;
        }
        ::fdatasync(m_descriptor);
        std::unique_lock lock(m_mutex);
        m_wake.wait_for(lock, stop, std::chrono::seconds(1), [] { return false; });
    }
}

void SessionLog::add(const SessionRecord& record) {
    add_line(text_of(record));
}

void SessionLog::add_line(const std::string& text) {
    m_chain = checksum(m_chain, text);
    m_buffer += hex_text(m_chain, kChecksumDigits) + " " + text + "\n";
}

Status SessionLog::flush() {
    std::string_view left = m_buffer;
    while (!left.empty() && !m_failed) {
        const ssize_t count = ::write(m_descriptor, left.data(), left.size());
        if (count > 0)
            left.remove_prefix(std::size_t(count));
        else if (errno != EINTR)
            m_failed = true;
    }
    if (m_failed)
        return unwritable(m_path,
                          std::string("expected to write to it, found: ") + std::strerror(errno));
    if (m_buffer.empty()) return Ok{};
    m_buffer.clear();
    {
        const std::lock_guard lock(m_mutex);
        m_unsynced = true;
    }
    m_wake.notify_all();
    return Ok{};
}

}  // namespace pliant::serve
