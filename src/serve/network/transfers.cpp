// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Admission of transfers, and downloads.

#include "network/transfers.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <limits>
#include <new>
#include <sstream>

#include "network/http_answer.h"
#include "network/transfer.h"

namespace pliant::serve {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
namespace fs = std::filesystem;
using tcp = asio::ip::tcp;

constexpr int kMaxTransfers = 32;  ///< most of them are refused
constexpr std::size_t kMaxDiscarded = std::size_t(64) << 20;

/// Writes the file under a temporary name, and unlinks it once it is open.
/// @returns the error; empty: none
std::string make_nameless(SaveKind kind, const FileWriter& write, Descriptor& file) {
    std::error_code error;
    std::string folder = (fs::temp_directory_path(error) / "pliant-save-XXXXXX").string();
    if (error || !::mkdtemp(folder.data())) return "expected a folder for temporary files";
    const fs::path path = fs::path(folder) / name_of(kind);
    std::string failure;
    try {
        if (const Status s = write(path); !s.ok()) failure = s.error().message;
    } catch (const std::bad_alloc&) {
        failure = std::string(name_of(kind)) + ": not enough memory to make it";
    }
    if (failure.empty()) file = open_file(path, O_RDONLY);
    if (failure.empty() && !file.is_open())
        failure = std::string(name_of(kind)) + ": can't be read";
    fs::remove_all(folder, error);
    if (error) fs::remove_all(folder, error);  // again: it has the scan, and nobody else removes it
    if (const auto at = failure.find(folder + "/"); at != std::string::npos)
        failure.erase(at, folder.size() + 1);
    return failure;
}

}  // namespace

Transfers::Transfers(asio::io_context& context, Hub& hub, const Tokens& tokens,
                     TransferSettings settings)
    : m_desk(std::make_unique<Desk>(context, hub, tokens, std::move(settings))) {
    // One for downloads, one for uploads.
    for (int n = 0; n < 2; ++n)
        m_desk->disk_threads.emplace_back([desk = m_desk.get()] {
            // Interactive work has priority.
            constexpr int kNice = 5;
            (void)::setpriority(PRIO_PROCESS, 0, kNice);  // of this thread, on Linux
            const auto work = asio::make_work_guard(desk->disk);
            while (!guarded("disk", [&] { desk->disk.run(); })) continue;
        });
}

// Also if the constructor throws: the system may refuse the second thread.
Transfers::Desk::~Desk() {
    is_ending = true;
    disk.stop();
    disk_threads.clear();
}

Transfers::~Transfers() = default;

bool Transfers::takes(std::string_view path) {
    return path.starts_with("/save/") || path == "/open" || path.starts_with("/open/");
}

void Transfers::begin(Guest guest) {
    if (*m_desk->count >= kMaxTransfers) return;
    std::make_shared<Transfer>(*m_desk, std::move(guest))->begin();
}

Transfer::Transfer(Transfers::Desk& desk, Guest guest)
    : m_desk(desk),
      m_count(desk.count),
      m_stream(std::move(guest.stream)),
      m_buffer(std::move(guest.buffer)),
      m_parser(std::move(guest.parser)),
      m_own(guest.own),
      m_target(m_parser->get().target()) {
    ++*m_count;
    m_parser->body_limit(std::numeric_limits<std::uint64_t>::max());  // Upload has limits
}

Transfer::~Transfer() {
    --*m_count;
}

void Transfer::begin() {
    const std::string_view path = path_of(m_target);
    const std::string token = parameter("token");
    const bool may_control = is_same_secret(token, m_desk.tokens.control);
    if (!may_control && !is_same_secret(token, m_desk.tokens.view)) {
        m_discarded = kMaxDiscarded;  // close quickly
        return answer(403, "token: expected that of the link");
    }
    const auto method = m_parser->get().method();
    if (path.starts_with("/save/")) {
        if (method != http::verb::get) return answer(405, "expected GET");
        const auto kind = save_kind_of(path.substr(6));
        return kind ? save(*kind) : answer(404, "there is no such file");
    }
    if (method != http::verb::post) return answer(405, "expected POST");
    if (!m_desk.settings.may_open)
        return answer(403, "open: expected a live scene, found a session that is watched");
    if (!may_control)
        return answer(403, "open: expected the link of those who may change the scene");
    open(path);
}

std::string Transfer::parameter(std::string_view key) const {
    return decoded(query_value(m_target, key)).value_or("");
}

bool Transfer::is_too_slow() const {
    const std::chrono::duration<double> grace = kTransferGrace;
    return m_watch.s() > grace.count() + double(m_moved) / kTransferBytesPerSecond;
}

// Out.

void Transfer::save(SaveKind kind) {
    if (m_desk.saving) return answer(503, "save: expected one at a time, found another");
    m_desk.saving = shared_from_this();
    auto ready = [weak = weak_from_this(), context = &m_desk.context,
                  kind](Result<FileWriter> writer) {
        asio::post(*context, [weak, kind, writer = std::move(writer)]() mutable {
            if (const auto self = weak.lock()) self->make_file(kind, std::move(writer));
        });
    };
    m_desk.hub.post({0, Event::Saving{kind, std::move(ready)}});
}

void Transfer::make_file(SaveKind kind, Result<FileWriter> writer) {
    if (!writer.ok()) {
        m_desk.saving.reset();
        return answer(507, writer.error().message);
    }
    on_disk(
        [this, kind, write = std::move(*writer)] {
            const std::string failure = make_nameless(kind, write, m_file);
            m_watch = Stopwatch();
            return failure;
        },
        [this, kind](const std::string& failure) { send_header(kind, failure); });
}

void Transfer::send_header(SaveKind kind, const std::string& failure) {
    struct stat status {};
    if (!failure.empty() || ::fstat(m_file.number(), &status) != 0) {
        m_desk.saving.reset();
        return answer(507, failure.empty() ? "save: can't be read" : failure);
    }
    m_size = std::uint64_t(status.st_size);
    http::response<http::empty_body> response(http::status::ok, 11);
    set_common_fields(response, m_own);
    response.set(http::field::content_type, "application/octet-stream");
    response.set(http::field::content_disposition,
                 "attachment; filename=\"" + std::string(name_of(kind)) + "\"");
    response.keep_alive(false);
    response.content_length(m_size);
    std::ostringstream text;
    text << response;
    m_text = text.str();
    m_stream.expires_after(kStallTime);
    asio::async_write(m_stream, asio::buffer(m_text),
                      [self = shared_from_this()](Error error, std::size_t) {
                          error ? self->close() : self->send_piece();
                      });
}

void Transfer::send_piece() {
    if (m_moved == m_size || is_too_slow()) return close();
    on_disk(
        [this] {
            std::size_t count = 0;
            (void)read_at(m_file.number(), m_piece.data(), m_piece.size(), m_moved, &count);
            return count;
        },
        [this](std::size_t count) {
            if (count == 0) return close();  // the client notices the missing bytes
            m_stream.expires_after(kStallTime);
            asio::async_write(m_stream, asio::buffer(m_piece.data(), count),
                              [self = shared_from_this()](Error error, std::size_t written) {
                                  self->m_moved += written;
                                  error ? self->close() : self->send_piece();
                              });
        });
}

// The end.

void Transfer::answer(unsigned status, const std::string& line) {
    http::response<http::string_body> response(http::int_to_status(status), 11);
    set_common_fields(response, m_own);
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    response.body() = line + "\n";
    response.keep_alive(false);
    response.prepare_payload();
    std::ostringstream text;
    text << response;
    m_text = text.str();
    m_stream.expires_after(kHttpTime);
    asio::async_write(m_stream, asio::buffer(m_text),
                      [self = shared_from_this()](Error error, std::size_t) {
                          if (error || self->m_parser->is_done()) return self->close();
                          // After a close, a client that still sends would miss the answer.
                          Error ignored;
                          self->m_stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
                          self->linger();
                      });
}

void Transfer::linger() {
    if (m_discarded >= kMaxDiscarded || is_too_slow()) return close();
    m_stream.expires_after(kCloseTime);
    m_stream.async_read_some(asio::buffer(m_piece),
                             [self = shared_from_this()](Error error, std::size_t count) {
                                 self->m_discarded += count;
                                 error ? self->close() : self->linger();
                             });
}

void Transfer::close() {
    Error ignored;
    m_stream.socket().shutdown(tcp::socket::shutdown_both, ignored);
    m_stream.socket().close(ignored);
    const auto self = shared_from_this();
    if (m_desk.saving == self) m_desk.saving.reset();
}

}  // namespace pliant::serve
