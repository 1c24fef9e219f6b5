// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Uploads, and the scenes made of them.

#include <sys/socket.h>

#include <algorithm>
#include <cctype>

#include "base/text.h"
#include "network/opening.h"
#include "network/transfer.h"

namespace pliant::serve {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;

constexpr std::size_t kMaxUploadId = 64;
/// Time to choose a series.
constexpr auto kChoiceTime = 3 * kUploadPause;

bool is_upload_id(std::string_view id) {
    return !id.empty() && id.size() <= kMaxUploadId &&
           std::all_of(id.begin(), id.end(), [](unsigned char c) { return std::isalnum(c); });
}

}  // namespace

void Transfers::Desk::drop_upload() {
    pause.cancel();
    // Removing large files takes time.
    if (upload) asio::post(disk, [gone = std::exchange(upload, nullptr)] { (void)gone; });
}

void Transfers::Desk::wait_for_more(std::chrono::seconds most) {
    pause.expires_after(most);
    pause.async_wait([this](boost::system::error_code error) {
        if (!error && !opening) drop_upload();
    });
}

void Transfer::open(std::string_view path) {
    m_is_labels = path == "/open/labels";
    m_is_state = path == "/open/state";
    m_is_single = path == "/open" || m_is_labels || m_is_state;
    const bool is_done = path == "/open/done", gives_up = path == "/open/drop";
    if (!m_is_single && !is_done && !gives_up && path != "/open/part")
        return answer(404,
                      "expected /open, /open/labels, /open/state, /open/part, /open/done or "
                      "/open/drop");
    const std::string id = parameter("upload");
    if (!(m_is_single && id.empty()) && !is_upload_id(id))
        return answer(400, "upload: expected 1…64 letters and digits");
    if (m_desk.opening || (m_desk.upload && m_desk.upload->id() != id))
        return answer(503, "open: expected one scan at a time, found another");
    if ((is_done || gives_up) && !m_desk.upload)
        return answer(404, "upload: expected one that has begun, found none");
    if (gives_up) {
        m_desk.drop_upload();
        return answer(200, "dropped");
    }
    m_desk.opening = shared_from_this();
    m_desk.pause.cancel();
    if (!m_desk.upload) m_desk.upload = std::make_shared<Upload>(m_desk.settings.uploads, id);
    if (is_done) return read_scan();
    std::optional<std::uint64_t> size;
    if (const auto length = m_parser->content_length()) size = *length;
    on_disk([upload = m_desk.upload, name = parameter("name"),
             size] { return upload->begin_file(name, size); },
            [this](const MayRefuse& refusal) { refusal ? give_up(*refusal) : begin_reading(); });
}

void Transfer::begin_reading() {
    if (m_parser->get()[http::field::expect] != "100-continue") return receive();
    m_text = "HTTP/1.1 100 Continue\r\n\r\n";
    m_stream.expires_after(kHttpTime);
    asio::async_write(m_stream, asio::buffer(m_text),
                      [self = shared_from_this()](Error error, std::size_t) {
                          error ? self->give_up({0, ""}) : self->receive();
                      });
}

void Transfer::receive() {
    if (m_parser->is_done()) return take_piece(0, true);
    if (is_too_slow())
        return give_up({408, "open: expected at least 64 KiB per second, found less"});
    auto& body = m_parser->get().body();
    body.data = m_piece.data();
    body.size = m_piece.size();
    m_stream.expires_after(kHttpTime);
    http::async_read(m_stream, m_buffer, *m_parser,
                     [self = shared_from_this()](Error error, std::size_t) {
                         if (error && error != http::error::need_buffer)
                             return self->give_up({0, ""});  // cut off
                         const auto left = self->m_parser->get().body().size;
                         self->take_piece(self->m_piece.size() - left, self->m_parser->is_done());
                     });
}

void Transfer::take_piece(std::size_t size, bool is_last) {
    m_moved += size;
    on_disk(
        [this, upload = m_desk.upload, size, is_last] {
            auto refusal = upload->add({m_piece.data(), size});
            return refusal || !is_last ? refusal : upload->end_file();
        },
        [this, is_last](const MayRefuse& refusal) {
            if (refusal) return give_up(*refusal);
            is_last ? file_is_there() : receive();
        });
}

void Transfer::file_is_there() {
    if (m_is_labels) return read_labels();
    if (m_is_state) return load_state();
    if (m_is_single) return read_scan();
    m_desk.opening.reset();
    m_desk.wait_for_more(kUploadPause);
    answer(200, "taken");
}

/// Detects a hang-up of the client, to cancel the reading of its scan.
void Transfer::watch_client() {
    m_stream.socket().async_wait(boost::asio::ip::tcp::socket::wait_read,
                                 [weak = weak_from_this()](Error error) {
                                     const auto self = weak.lock();
                                     if (error || !self) return;
                                     char byte = 0;
                                     const int socket = self->m_stream.socket().native_handle();
                                     if (::recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0)
                                         self->m_is_gone = true;
                                 });
}

void Transfer::read_scan() {
    watch_client();
    on_disk(
        [this, upload = m_desk.upload, series = parameter("series"),
         frame = parameter("frame")]() -> Result<Opened> {
            if (!m_is_single)
                if (const auto refusal = upload->rename(parameter("name")))
                    return pliant::Error{ErrorCode::Unwritable, refusal->line};
            ScanWish wish{.series = series};
            if (!frame.empty()) wish.frame = whole_number_from(frame);
            if (!frame.empty() && !wish.frame)
                return pliant::Error{ErrorCode::InvalidArgument,
                                     "frame: expected a whole number, found " + shown(frame)};
            const TransferSettings& settings = m_desk.settings;
            return open_upload(*upload, wish, {settings.own_tissue, settings.model}, settings.arena,
                               [this] { return m_is_gone || m_desk.is_ending; });
        },
        [this](Result<Opened> opened) { hand_over(std::move(opened)); });
}

void Transfer::read_labels() {
    watch_client();
    using Labels = Result<std::shared_ptr<const LabelMap>>;
    on_disk(
        [this, upload = m_desk.upload, grid = m_desk.hub.grid()]() -> Labels {
            return open_labels(*upload, grid, [this] { return m_is_gone || m_desk.is_ending; });
        },
        [this](Labels labels) {
            if (!labels.ok()) return refuse(labels.error());
            m_desk.drop_upload();
            auto done = [weak = weak_from_this(), context = &m_desk.context](bool fits) {
                asio::post(*context, [weak, fits] {
                    if (const auto self = weak.lock()) self->finish(fits);
                });
            };
            m_desk.hub.post({0, Event::Labelling{std::move(*labels), std::move(done)}});
        });
}

void Transfer::load_state() {
    on_disk([upload = m_desk.upload] { return keep_state(*upload); },
            [this](const Result<UploadedState>& kept) {
                if (!kept.ok()) return refuse(kept.error());
                auto done = [weak = weak_from_this(), context = &m_desk.context,
                             file = kept->file](const Status& loaded) {
                    asio::post(*context, [weak, file, loaded] {
                        if (const auto self = weak.lock()) self->state_is_loaded(file, loaded);
                    });
                };
                m_desk.hub.post({0, Event::Restoring{kept->file, kept->recorded, std::move(done)}});
            });
}

void Transfer::state_is_loaded(const std::filesystem::path& file, const Status& loaded) {
    if (!loaded.ok()) {
        m_desk.upload->discard();
        return refuse(
            {loaded.error().code, plain_message(loaded.error().message, *m_desk.upload, file)});
    }
    m_desk.drop_upload();
    m_desk.opening.reset();
    answer(200, "loaded");
}

void Transfer::refuse(const pliant::Error& error) {
    const ErrorCode code = error.code;
    const unsigned status = code == ErrorCode::LimitExceeded ? 413
                            : code == ErrorCode::Unwritable  ? 507
                                                             : 400;
    give_up({status, error.message});
}

void Transfer::finish(bool is_open) {
    m_desk.opening.reset();
    is_open ? answer(200, "opened")
            : answer(400, "labels: another scan was opened meanwhile; expected its labels");
}

void Transfer::hand_over(Result<Opened> opened) {
    if (!opened.ok()) return refuse(opened.error());
    if (const auto* series = std::get_if<std::vector<DicomSeries>>(&*opened))
        return let_choose(series_text(*series));
    if (const auto* count = std::get_if<ImageCount>(&*opened)) {
        // Without an ID the files can't be named again.
        if (!m_desk.upload->id().empty()) return let_choose(frames_text(count->images));
        return give_up({400, *m_desk.upload->names().begin() + ": holds " +
                                 std::to_string(count->images) +
                                 " images, choose one with the parameter frame, 0…" +
                                 std::to_string(count->images - 1)});
    }
    // The scan stays open; its files are removed unless they are kept.
    m_desk.drop_upload();
    auto done = [weak = weak_from_this(), context = &m_desk.context,
                 disk = &m_desk.disk](std::unique_ptr<Scene> old) {
        asio::post(*disk,
                   [gone = std::shared_ptr<Scene>(std::move(old))]() mutable { gone.reset(); });
        asio::post(*context, [weak] {
            if (const auto self = weak.lock()) self->finish(true);
        });
    };
    m_desk.hub.post({0, Event::Opening{std::move(std::get<NewScene>(*opened)), std::move(done)}});
}

/// Keeps the files until the client has chosen. @param choices  JSON
void Transfer::let_choose(const std::string& choices) {
    m_desk.opening.reset();
    m_desk.wait_for_more(kChoiceTime);
    answer(300, choices);
}

/// Discards the upload. @param refusal  without a status: the connection is closed without an
/// answer
void Transfer::give_up(const Refusal& refusal) {
    m_desk.drop_upload();
    m_desk.opening.reset();
    refusal.status ? answer(refusal.status, refusal.line) : close();
}

/// Ends a transfer after a failure on the disk thread, usually for lack of memory.
void Transfer::fail() {
    const char* const line = "expected memory and room for the file, found too little";
    if (m_desk.opening.get() == this) return give_up({507, line});
    m_desk.saving.reset();
    answer(507, line);
}

}  // namespace pliant::serve
