// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/files.h>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "base/descriptor.h"
#include "base/errors.h"
#include "base/input_file.h"
#include "base/staging_folder.h"
#include "base/staging_journal.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

// Outputs other than regular files: standard output, pipes, character devices.

class OutputStream {
  public:
    /// @param is_standard_output  true for every path
    /// @returns nullopt unless path names a descriptor, a pipe or a character device
    static std::optional<OutputStream> of(const std::filesystem::path& path,
                                          bool is_standard_output);

    /// @returns Unwritable for a descriptor that is closed or read-only
    Status check() const;
    /// Copies a file to the stream. Waits up to two seconds for a pipe's reader.
    Status write(const std::filesystem::path& file) const;

  private:
    explicit OutputStream(std::filesystem::path path, int descriptor)
        : m_path(std::move(path)), m_descriptor(descriptor) {}

    std::filesystem::path m_path;
    int m_descriptor;  ///< −1: the path is opened
};

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

namespace fs = std::filesystem;

/// File descriptor named by /dev/stdout, /dev/stderr, /dev/fd/N or /proc/self/fd/N.
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

Error unwritable(const fs::path& target, const std::string& what) {
    return {ErrorCode::Unwritable, target.string() + ": " + what};
}

/// Resolves a chain of symbolic links to the final name, which need not exist, or to a name such as
/// /dev/stdout on the way.
Result<fs::path> followed(const fs::path& target) {
    constexpr int kMaxLinks = 40;
    std::error_code error;
    fs::path path = target;
    for (int n = 0; n < kMaxLinks; ++n) {
        if (n > 0 && descriptor_of(path)) return path;
        const fs::file_type type = fs::symlink_status(path, error).type();
        if (type == fs::file_type::none) break;
        if (type != fs::file_type::symlink) return path;
        const fs::path next = fs::read_symlink(path, error);
        if (error) break;
        path = path.parent_path() / next;
    }
    if (!error) error = std::make_error_code(std::errc::too_many_symbolic_link_levels);
    return unwritable(target, "can't be written (" + error.message() + ")");
}

/// Syncs many files at once, which is faster than one by one.
std::error_code sync_file_system(const fs::path& folder) {
    staging::before_step();
    const Descriptor opened = open_file(folder, O_RDONLY);
    if (!opened.is_open()) return {errno, std::generic_category()};
    int result = -1;
    do result = ::syncfs(opened.number());
    while (result != 0 && errno == EINTR);
    if (result != 0 && errno != ENOSYS) return {errno, std::generic_category()};
    return {};
}

}  // namespace

struct StagedFiles::Impl {
    struct Slot {
        staging::Folder* folder;
        std::string number;  ///< number of the staging folder
        std::string name;    ///< name of the output; empty: the whole folder
        fs::path target;     ///< for messages
        std::optional<OutputStream> stream{};
    };
    std::vector<std::unique_ptr<staging::Folder>> folders;
    std::vector<Slot> slots;

    /// @returns a new folder in the temporary folder beside parent
    Result<fs::path> add(const fs::path& parent, const fs::path& target, const std::string& name) {
        std::error_code error;
        auto known = std::find_if(folders.begin(), folders.end(),
                                  [&](const auto& f) { return f->parent() == parent; });
        if (known == folders.end()) {
            staging::sweep(parent);
            folders.reserve(folders.size() + 1);
            auto made = staging::Folder::create(parent, error);
            if (made) known = folders.insert(folders.end(), std::move(made));
        }
        if (!error) {
            const std::string number = std::to_string((*known)->slot_count());
            slots.push_back({known->get(), number, name, target});
            fs::path slot = (*known)->add_slot(error);
            if (!error) return slot;
            slots.pop_back();
        }
        return unwritable(target, "the folder " + parent.string() + " can't be written (" +
                                      error.message() + ")");
    }

    Result<fs::path> add_stream(OutputStream stream, const fs::path& target) {
        std::error_code error;
        const fs::path temporary = fs::temp_directory_path(error);
        auto slot = add(error ? fs::path("/tmp") : temporary, target, "output");
        if (!slot) return slot;
        slots.back().stream = std::move(stream);
        // Writers detect the file type by its name.
        const fs::path name = target.filename();
        slots.back().name = name == "-" ? "output" : name.string();
        return *slot / slots.back().name;
    }

    Result<std::vector<staging::Moves>> moves() const;
    Status sync(const std::vector<staging::Moves>& all) const;
};

Result<std::vector<staging::Moves>> StagedFiles::Impl::moves() const {
    std::vector<staging::Moves> all;
    std::set<fs::path> taken;
    for (const auto& folder : folders) {
        staging::Moves of{folder.get(), {}};
        // Data files precede the headers that name them.
        for (const bool outputs : {false, true})
            for (const Slot& slot : slots) {
                if (slot.folder != folder.get() || slot.stream) continue;
                const fs::path staged = folder->path() / slot.number;
                const auto names = names_in(staged);
                if (!names)  // without the temporary folder's name
                    return unwritable(slot.target,
                                      names.error().message.substr(staged.string().size() + 2));
                if (!slot.name.empty() &&
                    !std::binary_search(names->begin(), names->end(), slot.name))
                    return unwritable(slot.target, "can't be written");
                for (const std::string& name : *names) {
                    if ((name == slot.name) != outputs) continue;
                    const fs::path to = folder->parent() / name;
                    if (!taken.insert(to).second)
                        return unwritable(to, "expected one output of this name, found two");
                    of.moves.push_back({slot.number, name});
                }
            }
        if (!of.moves.empty()) all.push_back(std::move(of));
    }
    return all;
}

Status StagedFiles::Impl::sync(const std::vector<staging::Moves>& all) const {
    constexpr std::size_t kOneByOne = 32;
    std::size_t count = 0;
    for (const staging::Moves& of : all) count += of.moves.size();
    // New folders contain an unknown number of files.
    const bool one_by_one =
        count <= kOneByOne &&
        std::none_of(slots.begin(), slots.end(), [](const Slot& p) { return p.name.empty(); });
    for (const staging::Moves& of : all) {
        std::error_code error;
        if (!one_by_one) error = sync_file_system(of.folder->path());
        for (const staging::Move& move : of.moves)
            if (one_by_one && !error)
                error = staging::sync_to_disk(of.folder->path() / move.slot / move.name);
        if (error)
            return unwritable(of.folder->parent() / of.moves.front().name,
                              "can't be written (" + error.message() + ")");
    }
    return Ok{};
}

StagedFiles::StagedFiles() = default;
StagedFiles::~StagedFiles() = default;

Result<fs::path> StagedFiles::stage(const fs::path& target) {
    return attempt([&]() -> Result<fs::path> {
        if (staging::is_staged(target)) return target;
        if (!m_impl) m_impl = std::make_unique<Impl>();
        if (auto stream = OutputStream::of(target, target == "-")) {
            if (Status s = stream->check(); !s) return s.error();
            return m_impl->add_stream(std::move(*stream), target);
        }
        std::error_code error;
        if (!target.has_filename()) return unwritable(target, "expected a file name");
        const auto file = followed(target);
        if (!file) return file.error();
        if (auto stream = OutputStream::of(*file, false)) {
            if (Status s = stream->check(); !s) return s.error();
            return m_impl->add_stream(std::move(*stream), target);
        }
        const fs::path parent = file->has_parent_path() ? file->parent_path() : fs::path(".");
        const auto folder = type_of(parent);
        if (!folder) return unwritable(target, "the folder " + folder.error().message);
        if (*folder != fs::file_type::directory)
            return unwritable(target, "the folder " + parent.string() + " does not exist");
        const auto type = fs::status(*file, error).type();
        if (type == fs::file_type::none)  // a name that is too long
            return unwritable(target, "can't be written (" + error.message() + ")");
        if (type == fs::file_type::directory)
            return unwritable(target, "is a folder, expected a file");
        if (type != fs::file_type::not_found && type != fs::file_type::regular)
            return unwritable(target, "is no regular file, expected one to replace");
        auto slot = m_impl->add(parent, target, file->filename().string());
        if (!slot) return slot;
        return *slot / file->filename();
    });
}

Result<fs::path> StagedFiles::stage_folder(const fs::path& target) {
    return attempt([&]() -> Result<fs::path> {
        if (!m_impl) m_impl = std::make_unique<Impl>();
        std::error_code error;
        if (target.empty()) return unwritable(target, "expected a folder");
        const auto type = type_of(target);
        if (!type) return unwritable(target, "can't be made: " + type.error().message);
        if (*type == fs::file_type::directory) return m_impl->add(target, target, {});
        // The nearest existing folder receives the first new one, which contains the others.
        fs::path parent = target.lexically_normal(), made;
        if (!parent.has_filename()) parent = parent.parent_path();
        do {
            made = parent.filename() / made;
            parent = parent.parent_path();
            if (parent.empty()) parent = ".";
            if (fs::symlink_status(parent, error).type() != fs::file_type::not_found) break;
        } while (parent.has_relative_path() && parent != ".");
        const auto above = fs::status(parent, error).type();
        if (above == fs::file_type::none)
            return unwritable(target, "can't be made (" + error.message() + ")");
        const auto own = fs::symlink_status(parent / *made.begin(), error).type();
        if (own == fs::file_type::none)
            return unwritable(target, "can't be made (" + error.message() + ")");
        if (above != fs::file_type::directory || own != fs::file_type::not_found)
            return unwritable(target, "can't be made, expected a folder");
        auto slot = m_impl->add(parent, target, {});
        if (!slot) return slot;
        const fs::path staged = (*slot / made).parent_path();
        fs::create_directories(staged, error);
        if (error) return unwritable(target, "can't be made (" + error.message() + ")");
        return staged;
    });
}

Status StagedFiles::commit() {
    return attempt([&]() -> Status {
        if (!m_impl) return Ok{};
        auto all = m_impl->moves();
        if (!all) return all.error();
        if (Status s = m_impl->sync(*all); !s) return s;
        for (const Impl::Slot& slot : m_impl->slots)
            if (slot.stream)
                if (Status s = slot.stream->write(slot.folder->path() / slot.number / slot.name);
                    !s)
                    return s;
        if (!all->empty())
            if (Status s = staging::commit(*all); !s) return s;
        m_impl.reset();
        return Ok{};
    });
}

std::string about_targets(std::string message) {
    // FOLDER/.pliant-out-Xa81Qe/0/NAME
    constexpr std::size_t kRandom = 6;
    for (std::size_t at = 0; (at = message.find(staging::kPrefix, at)) != message.npos;) {
        std::size_t end = at + staging::kPrefix.size() + kRandom;
        if (end >= message.size() || message[end] != '/') break;
        do ++end;
        while (end < message.size() && std::isdigit(static_cast<unsigned char>(message[end])));
        if (end >= message.size() || message[end] != '/') break;
        message.erase(at, end + 1 - at);
    }
    return message;
}

namespace {

std::atomic<RecoveryListener> g_listener{nullptr};

}  // namespace

RecoveryListener set_recovery_listener(RecoveryListener listener) noexcept {
    return g_listener.exchange(listener);
}
RecoveryListener recovery_listener() noexcept {
    return g_listener;
}

}  // namespace pliant
