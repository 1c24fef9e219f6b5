// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/session_log.h"

#include <fcntl.h>
#include <pliant/core/output_file.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "base/errors.h"
#include "base/input_file.h"
#include "protocol/messages.h"
#include "session/session_line.h"

namespace pliant::serve {
namespace {

/// Limit of a nameless file; many hours of work.
constexpr std::uint64_t kMaxNamelessBytes = std::uint64_t(256) << 20;
/// Limit of the records in memory while the disk is full; many minutes of work.
constexpr std::size_t kMaxUnwrittenBytes = std::size_t(8) << 20;

Error unwritable(const std::string& path, const std::string& what) {
    return {ErrorCode::Unwritable, path + ": " + what};
}

/// Resolves a file's relative name to the session's folder.
std::string beside(const std::filesystem::path& session, std::string file) {
    if (file.empty() || std::filesystem::path(file).is_absolute()) return file;
    std::error_code error;
    return (std::filesystem::absolute(session, error).parent_path() / file)
        .lexically_normal()
        .string();
}

SessionHeader beside(const std::filesystem::path& session, SessionHeader header) {
    header.source.file = beside(session, std::move(header.source.file));
    return header;
}

/// Removes the server's folder from an uploaded scan's name.
SessionHeader without_folder(SessionHeader header) {
    header.source.file = std::filesystem::path(header.source.file).filename().string();
    return header;
}

SessionHeader portable(const SessionFile& file) {
    const bool was_opened = file.scene_records > 0;
    return was_opened ? without_folder(file.scene) : file.scene;
}

Result<SessionFile> read_lines(const std::filesystem::path& path) {
    const auto read = read_small_file(path, std::string::npos, "a session");
    if (!read) return read.error();
    const std::string& bytes = *read;
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
        const std::uint64_t chain = line_checksum(file.chain, text);
        if (text.empty() || !line.starts_with(hex_text(chain, kChecksumDigits) + " ")) {
            if (is_last && line_number > 1) break;
            return fail("expected a checksum that fits, found damage");
        }
        bool is_new_scene = line_number == 1;
        if (line_number == 1) {
            auto header = parse_session_header(text);
            if (!header.ok()) return fail(header.error().message);
            file.header = file.scene = beside(path, std::move(*header));
        } else {
            auto record = parse_session_record(text);
            if (!record.ok()) return fail(record.error().message);
            if (auto* open = std::get_if<SessionOpen>(&*record)) {
                open->scan = file.scene = beside(path, std::move(open->scan));
                is_new_scene = true;
            } else if (auto* state = std::get_if<SessionState>(&*record)) {
                state->file = beside(path, std::move(state->file));
            }
            file.records.push_back(std::move(*record));
        }
        file.chain = chain;
        at = end + 1;
        file.good_bytes = at;
        if (is_new_scene) {
            file.scene_begin = at;
            file.scene_records = file.records.size();
        }
    }
    if (line_number == 0)
        return Error{ErrorCode::Unreadable,
                     path.string() + ": expected a session of pliant serve, found an empty file"};
    file.cut_off_bytes = bytes.size() - file.good_bytes;
    return file;
}

Result<std::string> portable(std::string_view text) {
    if (text.find("\"do\":\"state\"") == std::string_view::npos) return std::string(text);
    auto record = parse_session_record(text);
    if (!record.ok()) return record.error();
    auto* state = std::get_if<SessionState>(&*record);
    if (!state || std::filesystem::path(state->file).is_absolute()) return std::string(text);
    state->file = std::filesystem::path(state->file).filename().string();
    return text_of(*record);
}

}  // namespace

void SessionFile::use_tissue(const std::shared_ptr<const MakeTissue>& own_tissue) {
    header.source.own_tissue = scene.source.own_tissue = own_tissue;
    for (SessionRecord& record : records)
        if (auto* open = std::get_if<SessionOpen>(&record))
            open->scan.source.own_tissue = own_tissue;
}

Result<SessionFile> read_session(const std::filesystem::path& path) noexcept {
    auto read = attempt([&] { return read_lines(path); });
    if (!read.ok() && is_out_of_memory(read.error()))
        return attempt([&]() -> Result<SessionFile> {
            return Error{ErrorCode::LimitExceeded, path.string() + ": out of memory"};
        });
    return read;
}

Result<bool> session_has_begun(const std::filesystem::path& path) {
    const auto type = type_of(path);
    if (!type) return type.error();
    if (*type != std::filesystem::file_type::regular)
        return *type != std::filesystem::file_type::not_found;
    const InputFile file(path);
    if (const Status s = file.status(); !s) return s.error();
    return file.size() > 0;
}

Result<std::unique_ptr<SessionLog>> SessionLog::create(const std::filesystem::path& path,
                                                       const SessionHeader& header) {
    Descriptor file = open_file(path, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK, 0600);
    struct stat status {};
    const auto fail = [&](int error) {
        return unwritable(path.string(), std::string("expected to make a new file, found: ") +
                                             std::strerror(error));
    };
    if (!file.is_open() || (!try_lock(file.number()) && errno == EWOULDBLOCK) ||
        ::fstat(file.number(), &status) != 0)
        return fail(errno);
    if (!S_ISREG(status.st_mode) || status.st_size > 0 || status.st_uid != ::geteuid())
        return fail(EEXIST);
    auto log = std::unique_ptr<SessionLog>(new SessionLog(path, std::move(file), {}));
    const Status begun = log->begin(header);
    if (begun.ok()) return log;
    log->m_buffer.clear();
    [[maybe_unused]] const int emptied = ::ftruncate(log->m_file.number(), 0);
    return begun.error();
}

Result<std::unique_ptr<SessionLog>> SessionLog::create_nameless(const SessionHeader& header) {
    std::error_code error;
    const auto folder = std::filesystem::temp_directory_path(error);
    std::string name = (folder / "pliant-session-XXXXXX").string();
    Descriptor file(error ? -1 : ::mkostemp(name.data(), O_CLOEXEC));
    if (!file.is_open())
        return unwritable(folder.string(), std::string("expected to make a new file, found: ") +
                                               std::strerror(errno));
    ::unlink(name.c_str());
    auto log = std::unique_ptr<SessionLog>(new SessionLog("session", std::move(file), {}));
    log->m_most_bytes = kMaxNamelessBytes;
    if (const Status s = log->begin(header); !s.ok()) return s.error();
    return log;
}

Result<std::unique_ptr<SessionLog>> SessionLog::go_on(const std::filesystem::path& path,
                                                      const SessionFile& read) {
    Descriptor file = open_file(path, O_RDWR);
    const auto fail = [&](const std::string& what) {
        return unwritable(path.string(), what + std::strerror(errno));
    };
    if (!file.is_open()) return fail("expected a file to write to, found: ");
    if (!try_lock(file.number()))
        return fail("expected a session that no other process has open: ");
    if (::ftruncate(file.number(), off_t(read.good_bytes)) != 0 ||
        ::lseek(file.number(), 0, SEEK_END) != off_t(read.good_bytes))
        return fail("expected to write at its end, found: ");
    return std::unique_ptr<SessionLog>(new SessionLog(path, std::move(file), read));
}

SessionLog::SessionLog(const std::filesystem::path& path, Descriptor file, const SessionFile& read)
    : m_path(path.string()),
      m_file(std::move(file)),
      m_chain(read.chain),
      m_written(read.good_bytes),
      m_scene(portable(read)),
      m_scene_begin(read.scene_begin),
      m_syncer([this](const std::stop_token& stop) { keep_syncing(stop); }) {}

SessionLog::~SessionLog() {
    (void)flush();
    m_syncer.request_stop();
    m_syncer.join();
    (void)sync_data(m_file.number());
}

void SessionLog::keep_syncing(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
        {
            std::unique_lock lock(m_mutex);
            if (!m_wake.wait(lock, stop, [&] { return m_unsynced; })) return;
            m_unsynced = false;
        }
        sync();
        std::unique_lock lock(m_mutex);
        m_wake.wait_for(lock, stop, std::chrono::seconds(1), [] { return false; });
    }
}

Status SessionLog::begin(const SessionHeader& header) {
    add_line(text_of(header));
    m_scene = header;
    m_scene_begin = m_buffer.size();
    return flush();
}

void SessionLog::add(const SessionRecord& record) {
    const auto* open = std::get_if<SessionOpen>(&record);
    SessionHeader scene;
    if (open) scene = without_folder(open->scan);
    add_line(text_of(record));
    if (!open) return;
    m_scene = std::move(scene);
    m_scene_begin = m_written + m_buffer.size();
}

void SessionLog::add_line(const std::string& text) {
    std::uint64_t chain = m_chain;
    m_buffer += session_line(chain, text);
    m_chain = chain;
}

Result<SessionPart> SessionLog::part() {
    if (const Status s = flush(); !s.ok()) return s.error();
    Descriptor copy(::fcntl(m_file.number(), F_DUPFD_CLOEXEC, 0));
    if (!copy.is_open())
        return unwritable(m_path,
                          std::string("expected to read it, found: ") + std::strerror(errno));
    return SessionPart{m_scene, std::make_shared<const Descriptor>(std::move(copy)), m_scene_begin,
                       m_written};
}

bool SessionLog::is_full() const {
    return m_buffer.size() > kMaxUnwrittenBytes;
}

void SessionLog::sync() {
    m_sync_error = sync_data(m_file.number());
}

Status SessionLog::flush() {
    if (!m_ended && m_most_bytes && m_written + m_buffer.size() > m_most_bytes) m_ended = true;
    if (m_ended) {
        m_buffer.clear();
        return unwritable(m_path,
                          std::string("expected to write to it, found: ") + std::strerror(EFBIG));
    }
    const std::uint64_t before = m_written;
    int error = write_buffer();
    if (!error) error = m_sync_error;
    if (m_written > before || m_sync_error) {
        const std::lock_guard lock(m_mutex);
        m_unsynced = true;
        m_wake.notify_all();
    }
    if (!error) return Ok{};
    return unwritable(m_path,
                      std::string("expected to write to it, found: ") + std::strerror(error));
}

/// Writes the buffer. Written bytes leave the buffer, so that a line interrupted by a full disk is
/// completed later. @returns errno; 0: all is in the file
int SessionLog::write_buffer() {
    std::size_t done = 0;
    const int error = write_all(m_file.number(), m_buffer.data(), m_buffer.size(), &done);
    m_buffer.erase(0, done);
    m_written += done;
    return error;
}

Status SessionLog::check_path() const {
    if (is_nameless()) return Ok{};
    struct stat open_one {};
    struct stat named {};
    if (::fstat(m_file.number(), &open_one) != 0 ||
        (::stat(m_path.c_str(), &named) == 0 && named.st_ino == open_one.st_ino &&
         named.st_dev == open_one.st_dev))
        return Ok{};
    return unwritable(m_path, "expected the session's file there, found it moved or deleted");
}

// One scene's part of a session as a separate session: the same lines with new checksums. Uploaded
// states are named without the server's folder.

Status write_session(const std::filesystem::path& path, const SessionPart& part,
                     const SessionMark& mark) {
    OutputFile out(path, path.filename().string());
    std::uint64_t chain = 0;
    out.write(session_line(chain, text_of(part.scene)));
    std::string rest;  // of a line that continues in the next piece
    std::array<char, 1 << 16> piece;
    for (std::uint64_t at = part.begin; at < part.end;) {
        const auto wanted = std::size_t(std::min<std::uint64_t>(piece.size(), part.end - at));
        std::size_t count = 0;
        const int error = read_at(part.file->number(), piece.data(), wanted, at, &count);
        if (error || count == 0)
            return Error{ErrorCode::Unreadable,
                         "session: expected the recorded bytes, found " +
                             (error ? std::generic_category().message(error) : "the file's end")};
        at += count;
        rest.append(piece.data(), count);
        std::size_t begin = 0;
        for (std::size_t end = 0; (end = rest.find('\n', begin)) != std::string::npos;
             begin = end + 1) {
            const std::string_view line(rest.data() + begin, end - begin);
            const auto text = portable(line.substr(std::min(kChecksumDigits + 1, line.size())));
            if (!text.ok()) return text.error();
            out.write(session_line(chain, *text));
        }
        rest.erase(0, begin);
    }
    out.write(session_line(chain, text_of(SessionRecord(mark))));
    return out.close();
}

}  // namespace pliant::serve
