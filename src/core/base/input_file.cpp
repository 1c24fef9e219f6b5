// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/input_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>

#include "base/errors.h"
#include "base/memory_budget.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kBufferBytes = std::size_t(1) << 14;

std::string because(const char* what, int error) {
    return std::string(what) + " (" + std::generic_category().message(error) + ")";
}

}  // namespace

InputFile::InputFile(fs::path path) : m_path(std::move(path)) {
    m_file = open_file(m_path, O_RDONLY | O_NONBLOCK | O_NOCTTY);
    struct stat status {};
    if (!m_file.is_open())
        fail("can't be opened", errno);
    else if (::fstat(m_file.number(), &status) != 0)
        fail("can't be read", errno);
    else if (!S_ISREG(status.st_mode))
        m_fault = "is no regular file";
    else
        m_size = std::uint64_t(status.st_size);
}

Status InputFile::status() const {
    return m_fault.empty() ? Status(Ok{}) : Status(unreadable(m_path, m_fault));
}

Error InputFile::fault(const std::string& message) const {
    return unreadable(m_path, m_fault.empty() ? message : m_fault);
}

void InputFile::fail(const char* what, int error) {
    m_fault = because(what, error);
}

void InputFile::seek(std::uint64_t at) {
    // Behind the end of every file, but no invalid argument of the system.
    constexpr auto kMaxOffset = std::uint64_t(1) << 62;
    at = std::min(at, kMaxOffset);
    if (at >= m_begin && at - m_begin <= m_count) {
        m_next = std::size_t(at - m_begin);
        return;
    }
    m_begin = at;
    m_next = m_count = 0;
}

bool InputFile::fill() {
    m_begin += m_count;
    m_next = m_count = 0;
    if (!m_fault.empty()) return false;
    // Small files need a small buffer; those of /proc have no size.
    if (m_buffer.empty())
        m_buffer.resize(m_size == 0 ? kBufferBytes
                                    : std::size_t(std::min<std::uint64_t>(m_size, kBufferBytes)));
    if (const int error =
            read_at(m_file.number(), m_buffer.data(), m_buffer.size(), m_begin, &m_count)) {
        m_count = 0;
        fail("can't be read", error);
    }
    return m_count > 0;
}

std::size_t InputFile::read(void* out, std::size_t count) {
    auto* const bytes = static_cast<char*>(out);
    std::size_t done = 0;
    while (done < count) {
        if (m_next == m_count) {
            if (count - done >= kBufferBytes && m_fault.empty()) {
                std::size_t more = 0;
                const int error = read_at(m_file.number(), bytes + done, count - done, at(), &more);
                if (error) fail("can't be read", error);
                seek(at() + more);
                return done + more;
            }
            if (!fill()) break;
        }
        const std::size_t some = std::min(count - done, m_count - m_next);
        std::memcpy(bytes + done, m_buffer.data() + m_next, some);
        m_next += some;
        done += some;
    }
    return done;
}

Result<std::string> InputFile::read_rest(std::size_t max_bytes, std::string_view expected) {
    const auto too_large = [&] {
        return unreadable(m_path, "expected " + std::string(expected) + " of up to " +
                                      std::to_string(max_bytes >> 20) + " MiB, found more");
    };
    const std::uint64_t left = m_size - std::min(m_size, at());
    if (left > max_bytes) return too_large();
    // The bytes, and about as much again for their meaning.
    if (!has_memory_for(2 * left))
        return Error{ErrorCode::LimitExceeded, m_path.string() + ": not enough memory to read it"};
    std::string text(std::size_t(left), '\0');
    text.resize(read(text.data(), text.size()));
    // A file of /proc, or one that has grown.
    for (int c = get(); c != kEnd; c = get()) {
        if (text.size() == max_bytes) return too_large();
        text += char(c);
    }
    if (Status s = status(); !s) return s.error();
    return text;
}

Result<std::vector<std::string>> names_in(const fs::path& folder) {
    const auto fail = [&](int error) {
        return unreadable(folder, because("can't be listed", error));
    };
    struct Close {
        void operator()(DIR* listing) const { ::closedir(listing); }
    };
    const std::unique_ptr<DIR, Close> listing(::opendir(folder.c_str()));
    if (!listing) return fail(errno);
    std::vector<std::string> names;
    for (errno = 0; const dirent* entry = ::readdir(listing.get()); errno = 0)
        if (const std::string_view name = entry->d_name; name != "." && name != "..")
            names.emplace_back(name);
    if (errno != 0) return fail(errno);
    std::sort(names.begin(), names.end());
    return names;
}

Result<fs::file_type> type_of(const fs::path& path) {
    std::error_code error;
    const fs::file_type type = fs::status(path, error).type();
    if (type == fs::file_type::none)
        return unreadable(path, because("can't be read", error.value()));
    return type;
}

}  // namespace pliant
