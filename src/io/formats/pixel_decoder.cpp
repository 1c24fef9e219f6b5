// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/pixel_decoder.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "base/descriptor.h"
#include "base/errors.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;

/// Lower descriptors may be standard streams that the program closed.
constexpr int kFirstDescriptor = 10;

/// Moves a descriptor to a higher number. @returns false if none is free
bool move_up(Descriptor& descriptor) {
    const int copy = ::fcntl(descriptor.number(), F_DUPFD_CLOEXEC, kFirstDescriptor);
    if (copy < 0) return false;
    descriptor = Descriptor(copy);
    return true;
}

/// Parameters of posix_spawn: streams, socket, no other descriptors, default signal handling.
class SpawnPlan {
  public:
    explicit SpawnPlan(int socket) {
        posix_spawn_file_actions_init(&m_actions);
        posix_spawnattr_init(&m_attributes);
        for (int stream = 0; stream < kDecoderSocket; ++stream)
            note(posix_spawn_file_actions_addopen(&m_actions, stream, "/dev/null", O_RDWR, 0));
        note(posix_spawn_file_actions_adddup2(&m_actions, socket, kDecoderSocket));
#if defined(__GLIBC_PREREQ)
#if __GLIBC_PREREQ(2, 34)  // otherwise the program closes them itself
        note(posix_spawn_file_actions_addclosefrom_np(&m_actions, kDecoderSocket + 1));
#endif
#endif
        sigset_t none, all;
        sigemptyset(&none);
        sigfillset(&all);
        posix_spawnattr_setsigmask(&m_attributes, &none);
        posix_spawnattr_setsigdefault(&m_attributes, &all);
        // A separate process group: Ctrl+C reaches only this process, which ends the decoder.
        note(posix_spawnattr_setflags(
            &m_attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP));
    }
    ~SpawnPlan() {
        posix_spawn_file_actions_destroy(&m_actions);
        posix_spawnattr_destroy(&m_attributes);
    }
    SpawnPlan(const SpawnPlan&) = delete;
    SpawnPlan& operator=(const SpawnPlan&) = delete;

    /// @returns errno, or 0
    int spawn(pid_t& process, const std::string& program, char* const* arguments) const {
        char* const no_environment[] = {nullptr};
        if (m_error) return m_error;
        return posix_spawn(&process, program.c_str(), &m_actions, &m_attributes, arguments,
                           no_environment);
    }

  private:
    void note(int error) {
        if (error && !m_error) m_error = error;
    }
    int m_error = 0;
    posix_spawn_file_actions_t m_actions;
    posix_spawnattr_t m_attributes;
};

Error not_started(int error) {
    if (error == ENOMEM || error == EAGAIN || error == EMFILE || error == ENFILE)
        return {ErrorCode::LimitExceeded, "not enough memory to start the decoder"};
    return {ErrorCode::Unreadable,
            std::string("the decoder can't be started (") + std::strerror(error) + ")"};
}

/// Waits until a socket can be read or written.
/// @returns false when time is up
bool wait_for(int socket, short event, Clock::time_point deadline) {
    for (;;) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
        if (left < 0) return false;
        pollfd waiting{socket, event, 0};
        const int ready = ::poll(&waiting, 1, int(std::min<long long>(left + 1, 60000)));
        if (ready > 0) return true;
        if (ready < 0 && errno != EINTR) return true;  // the next call returns the error
    }
}

enum class Transfer { Done, Late, Ended };

bool must_wait(ssize_t count) {
    return count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
}

Transfer send_all(int socket, std::span<const std::uint8_t> bytes, Clock::time_point deadline) {
    while (!bytes.empty()) {
        if (!wait_for(socket, POLLOUT, deadline)) return Transfer::Late;
        const ssize_t count =
            ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (must_wait(count)) continue;
        if (count <= 0) return Transfer::Ended;
        bytes = bytes.subspan(std::size_t(count));
    }
    return Transfer::Done;
}

Transfer receive_all(int socket, std::span<std::uint8_t> bytes, Clock::time_point deadline) {
    while (!bytes.empty()) {
        if (!wait_for(socket, POLLIN, deadline)) return Transfer::Late;
        const ssize_t count = ::recv(socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (must_wait(count)) continue;
        if (count <= 0) return Transfer::Ended;
        bytes = bytes.subspan(std::size_t(count));
    }
    return Transfer::Done;
}

/// Whether the socket contains, or immediately receives, excess data.
bool has_more(int socket) {
    char one = 0;
    return ::recv(socket, &one, 1, MSG_DONTWAIT | MSG_PEEK) > 0;
}

Error undecodable() {
    return {ErrorCode::Unreadable, "its pixels can't be decoded"};
}

}  // namespace

Result<PixelDecoder> PixelDecoder::start(const fs::path& program, const DecoderLimits& limits) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return not_started(errno);
    Descriptor own(ends[0]), other(ends[1]);
    if (!move_up(other)) return not_started(errno);
    const auto seconds = std::uint64_t(std::ceil(limits.seconds_per_slice)) * (limits.slices + 1);
    std::string words[] = {kDecoderName, std::to_string(limits.memory_bytes),
                           std::to_string(seconds)};
    char* const arguments[] = {words[0].data(), words[1].data(), words[2].data(), nullptr};
    pid_t process = -1;
    if (const int error = SpawnPlan(other.number()).spawn(process, program.string(), arguments))
        return not_started(error);
    return PixelDecoder(process, own.release(), limits.seconds_per_slice);
}

PixelDecoder::PixelDecoder(PixelDecoder&& other) noexcept
    : m_process(std::exchange(other.m_process, -1)),
      m_socket(std::exchange(other.m_socket, -1)),
      m_seconds(other.m_seconds) {}

PixelDecoder& PixelDecoder::operator=(PixelDecoder&& other) noexcept {
    std::swap(m_process, other.m_process);
    std::swap(m_socket, other.m_socket);
    std::swap(m_seconds, other.m_seconds);
    return *this;
}

void PixelDecoder::end() noexcept {
    if (m_socket >= 0) ::close(std::exchange(m_socket, -1));
    if (m_process < 0) return;
    ::kill(m_process, SIGKILL);
    while (::waitpid(m_process, nullptr, 0) < 0 && errno == EINTR) {
    }
    m_process = -1;
}

/// Ends the process after it has closed its socket.
Error PixelDecoder::lost() {
    end();
    return {ErrorCode::Unreadable, "its pixels can't be decoded (the decoder ended)"};
}

Result<bool> PixelDecoder::decode(std::span<const std::uint8_t> message,
                                  std::span<std::uint8_t> pixels) {
    if (m_socket < 0) return undecodable();
    const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                             std::chrono::duration<double>(m_seconds));
    const auto failed = [&](Transfer transfer) -> Error {
        if (transfer == Transfer::Ended) return lost();
        end();
        return {ErrorCode::LimitExceeded, "its pixels take longer than " +
                                              std::to_string(int(std::ceil(m_seconds))) +
                                              " s to decode"};
    };
    if (const Transfer sent = send_all(m_socket, message, deadline); sent != Transfer::Done)
        return failed(sent);
    PixelAnswer answer;
    std::uint8_t bytes[sizeof answer];
    if (const Transfer got = receive_all(m_socket, bytes, deadline); got != Transfer::Done)
        return failed(got);
    std::memcpy(&answer, bytes, sizeof answer);
    if (answer.magic == PixelAnswer::kMagic && answer.status == PixelStatus::OutOfMemory)
        return Error{ErrorCode::LimitExceeded, "not enough memory to decode its pixels"};
    if (answer.magic != PixelAnswer::kMagic || answer.status != PixelStatus::Decoded) {
        const bool honest =
            answer.magic == PixelAnswer::kMagic && answer.status == PixelStatus::Undecodable;
        if (!honest || has_more(m_socket)) end();
        return undecodable();
    }
    if (const Transfer got = receive_all(m_socket, pixels, deadline); got != Transfer::Done)
        return failed(got);
    if (has_more(m_socket)) {
        end();
        return undecodable();
    }
    return answer.is_signed != 0;
}

}  // namespace pliant
