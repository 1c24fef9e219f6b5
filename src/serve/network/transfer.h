// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// State of one transfer, and the shared state of all: for transfers.cpp (downloads) and
// transfers_open.cpp (uploads).

#pragma once

#include "base/descriptor.h"
#include "base/stopwatch.h"
#include "network/hidden_boost.h"

#include <array>
#include <atomic>
#include <boost/asio.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "network/door.h"
#include "network/opening.h"
#include "network/transfers.h"
#include "session/guarded.h"

namespace pliant::serve {

class Transfer;

struct Transfers::Desk {
    Desk(boost::asio::io_context& c, Hub& h, const Tokens& t, TransferSettings s)
        : context(c), hub(h), tokens(t), settings(std::move(s)), pause(c) {}
    ~Desk();

    void drop_upload();
    /// Keeps the upload for this time, for more files or a choice.
    void wait_for_more(std::chrono::seconds most);

    boost::asio::io_context& context;
    Hub& hub;
    const Tokens& tokens;
    TransferSettings settings;
    std::shared_ptr<int> count = std::make_shared<int>(0);  ///< number of transfers
    std::shared_ptr<Transfer> saving;                       ///< null: none
    std::shared_ptr<Transfer> opening;                      ///< the one that sends files or waits
                                                            ///< for its scene
    std::shared_ptr<Upload> upload;                         ///< may wait for its next file
    boost::asio::steady_timer pause;
    std::atomic<bool> is_ending = false;
    boost::asio::io_context disk;
    std::vector<std::jthread> disk_threads;
};

class Transfer : public std::enable_shared_from_this<Transfer> {
  public:
    Transfer(Transfers::Desk& desk, Guest guest);
    ~Transfer();
    Transfer(const Transfer&) = delete;
    Transfer& operator=(const Transfer&) = delete;

    void begin();

  private:
    using Error = boost::system::error_code;

    // Out.
    void save(SaveKind kind);
    void make_file(SaveKind kind, Result<FileWriter> writer);
    void send_header(SaveKind kind, const std::string& failure);
    void send_piece();

    // In.
    void open(std::string_view path);
    void receive();
    void take_piece(std::size_t size, bool is_last);
    void begin_reading();
    void file_is_there();
    void read_scan();
    void read_labels();
    void load_state();
    void state_is_loaded(const std::filesystem::path& file, const Status& loaded);
    void watch_client();
    void hand_over(Result<Opened> opened);
    void let_choose(const std::string& choices);
    void refuse(const pliant::Error& error);
    void finish(bool is_open);
    void give_up(const Refusal& refusal);
    void fail();

    std::string parameter(std::string_view key) const;
    bool is_too_slow() const;
    /// Sends the final answer, and closes.
    void answer(unsigned status, const std::string& line);
    void linger();
    void close();
    /// Runs There on a disk thread, then Here on the network's thread.
    template <class There, class Here>
    void on_disk(There there, Here here);

    Transfers::Desk& m_desk;
    std::shared_ptr<int> m_count;
    boost::beast::tcp_stream m_stream;
    boost::beast::flat_buffer m_buffer;
    std::unique_ptr<BodyParser> m_parser;
    const OwnOrigins& m_own;
    std::string m_target;
    std::array<char, 1 << 18> m_piece;
    std::string m_text;  ///< text being sent
    Descriptor m_file;
    std::uint64_t m_size = 0, m_moved = 0;  ///< size of the file, and transferred part
    std::size_t m_discarded = 0;
    bool m_is_single = false;             ///< the only file of its scan
    bool m_is_labels = false;             ///< a label map instead of a scan
    bool m_is_state = false;              ///< a state of the tissue instead of a scan
    std::atomic<bool> m_is_gone = false;  ///< the client hung up while its scan was read
    Stopwatch m_watch;                    ///< of the transfer
};

template <class There, class Here>
void Transfer::on_disk(There there, Here here) {
    boost::asio::post(m_desk.disk, [self = shared_from_this(), there = std::move(there),
                                    here = std::move(here)]() mutable {
        const bool done = guarded("disk", [&] {
            auto result = std::make_shared<decltype(there())>(there());
            boost::asio::post(self->m_desk.context,
                              [self, result, here]() mutable { here(std::move(*result)); });
        });
        if (!done) boost::asio::post(self->m_desk.context, [self] { self->fail(); });
    });
}

}  // namespace pliant::serve
