// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/staging_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <pliant/core/files.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>
#include <mutex>
#include <utility>

namespace pliant::staging {
namespace fs = std::filesystem;
namespace {

/// A folder that end_process removes. end_process can't allocate, so the path is stored here.
struct Slot {
    enum : int { Free, Taken, Ready };
    std::atomic<int> state{Free};
    char path[PATH_MAX];
};
constexpr int kSlotCount = 64;  // the next run removes further folders
Slot g_slots[kSlotCount];
std::mutex g_slots_mutex;  ///< guards all accesses except those of end_process, which must not wait

int take_slot(const fs::path& path) {
    const std::string& text = path.native();
    if (text.size() >= sizeof Slot::path) return -1;
    const std::lock_guard guard(g_slots_mutex);
    for (int s = 0; s < kSlotCount; ++s) {
        int free = Slot::Free;
        if (!g_slots[s].state.compare_exchange_strong(free, Slot::Taken)) continue;
        std::memcpy(g_slots[s].path, text.c_str(), text.size() + 1);
        g_slots[s].state = Slot::Ready;
        return s;
    }
    return -1;
}

/// Number of running commits, or kEnding.
std::atomic<int> g_commits{0};
constexpr int kEnding = -1;
/// Exit status requested by a signal during a commit; −1: none.
std::atomic<int> g_wanted_status{-1};

[[noreturn]] void wait_for_the_end() noexcept {
    for (;;) ::pause();
}

struct Entry {  // of getdents64: the kernel's layout
    std::uint64_t inode;
    std::int64_t offset;
    unsigned short length;
    unsigned char type;
    char name[1];
};

/// Empties a folder without readdir, which allocates and so is forbidden in signal handlers.
void empty_folder(int folder, int depth) noexcept {
    alignas(Entry) char buffer[2048];
    for (bool removed = true; removed;) {
        removed = false;
        if (::lseek(folder, 0, SEEK_SET) != 0) return;
        for (;;) {
            const long bytes = ::syscall(SYS_getdents64, folder, buffer, sizeof buffer);
            if (bytes <= 0) break;
            for (long at = 0; at < bytes;) {
                const auto* entry = reinterpret_cast<const Entry*>(buffer + at);
                at += entry->length;
                const char* name = entry->name;
                if (std::strcmp(name, ".") == 0 || std::strcmp(name, "..") == 0) continue;
                before_step();
                if (::unlinkat(folder, name, 0) == 0) {
                    removed = true;
                    continue;
                }
                if ((errno != EISDIR && errno != EPERM) || depth == 0) continue;
                const int inner = ::openat(
                    folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
                if (inner < 0) continue;
                empty_folder(inner, depth - 1);
                ::close(inner);
                before_step();
                removed |= ::unlinkat(folder, name, AT_REMOVEDIR) == 0;
            }
        }
    }
}

}  // namespace

void remove_tree(const char* folder) noexcept {
    constexpr int kDeepest = 40;
    const int opened = ::open(folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
    if (opened < 0) return;
    // Another thread may still be writing; its new files are removed in the next round.
    constexpr int kTurns = 100;
    for (int turn = 0; turn < kTurns; ++turn) {
        empty_folder(opened, kDeepest);
        before_step();
        if (::rmdir(folder) == 0 || errno != ENOTEMPTY) break;
    }
    ::close(opened);
}

std::error_code sync_to_disk(const fs::path& path) noexcept {
    before_step();
    const Descriptor file = open_file(path, O_RDONLY | O_NONBLOCK);
    if (!file.is_open()) return {errno, std::generic_category()};
    int result = -1;
    do result = ::fsync(file.number());
    while (result != 0 && errno == EINTR);
    if (result == 0 || errno == EINVAL || errno == ENOTSUP || errno == EROFS) return {};
    return {errno, std::generic_category()};
}

std::optional<Descriptor> open_and_lock(const fs::path& folder, bool waits, Lock& lock) {
    Descriptor opened = open_file(folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_NONBLOCK);
    struct stat status {};
    const bool is_absent =
        !opened.is_open() && (errno == ENOENT || errno == ENOTDIR || errno == ELOOP);
    lock = is_absent ? Lock::Gone : Lock::Unknown;
    if (!opened.is_open() || ::fstat(opened.number(), &status) != 0) return std::nullopt;
    // A journal in another user's folder would rename files with this user's rights.
    lock = Lock::Gone;
    if (status.st_uid != ::geteuid() || (status.st_mode & 0077) != 0) return std::nullopt;
    int result = -1;
    do result = ::flock(opened.number(), LOCK_EX | (waits ? 0 : LOCK_NB));
    while (result != 0 && errno == EINTR);
    lock = result == 0 ? Lock::Taken : errno == EWOULDBLOCK ? Lock::Busy : Lock::Impossible;
    if (lock != Lock::Taken) return opened;
    lock = Lock::Unknown;
    if (::fstat(opened.number(), &status) != 0) return std::nullopt;
    lock = status.st_nlink == 0 ? Lock::Gone : Lock::Taken;  // removed in the meantime
    if (lock == Lock::Gone) return std::nullopt;
    return opened;
}

std::unique_ptr<Folder> Folder::create(const fs::path& parent, std::error_code& error) {
    constexpr int kTries = 20;
    for (int n = 0; n < kTries; ++n) {
        std::string name =
            (parent == "." ? fs::path() : parent) / (std::string(kPrefix) + "XXXXXX");
        // A signal ends the process only after the folder has its slot.
        const Commit registered;
        before_step();
        if (!::mkdtemp(name.data())) {
            error.assign(errno, std::generic_category());
            return nullptr;
        }
        before_step();
        Lock lock{};
        auto opened = open_and_lock(name, false, lock);
        // Another process removed it as a leftover before it was locked: retry.
        if (!opened || lock == Lock::Busy) continue;
        return std::unique_ptr<Folder>(new Folder(parent, name, std::move(*opened)));
    }
    error.assign(EAGAIN, std::generic_category());
    return nullptr;
}

Folder::Folder(fs::path parent, fs::path path, Descriptor lock)
    : m_parent(std::move(parent)),
      m_path(std::move(path)),
      m_lock(std::move(lock)),
      m_slot(take_slot(m_path)) {}

Folder::~Folder() {
    if (m_is_kept) return;
    remove_tree(m_path.c_str());
    keep();
}

void Folder::keep() noexcept {
    const std::lock_guard guard(g_slots_mutex);
    if (m_slot >= 0) g_slots[std::exchange(m_slot, -1)].state = Slot::Free;
    m_is_kept = true;
}

fs::path Folder::add_slot(std::error_code& error) {
    fs::path slot = m_path / std::to_string(m_slot_count);
    before_step();
    if (::mkdir(slot.c_str(), 0700) != 0) error.assign(errno, std::generic_category());
    ++m_slot_count;
    return slot;
}

bool is_staged(const fs::path& path) {
    const std::lock_guard guard(g_slots_mutex);
    for (const Slot& slot : g_slots)
        if (slot.state == Slot::Ready) {
            const std::string_view folder = slot.path;
            const std::string& text = path.native();
            if (text.size() > folder.size() && text.compare(0, folder.size(), folder) == 0 &&
                text[folder.size()] == '/')
                return true;
        }
    return false;
}

Commit::Commit() {
    for (int under_way = g_commits;;) {
        if (under_way == kEnding) wait_for_the_end();
        if (g_commits.compare_exchange_weak(under_way, under_way + 1)) return;
    }
}

Commit::~Commit() {
    g_commits.fetch_sub(1);
    if (const int status = g_wanted_status; status >= 0) end_process(status);
}

}  // namespace pliant::staging

namespace pliant {

void end_process(int status) noexcept {
    using namespace staging;
    sigset_t all, before;
    sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, &before);
    g_wanted_status = status;
    int none = 0;
    if (!g_commits.compare_exchange_strong(none, kEnding)) {
        if (none == kEnding) wait_for_the_end();
        ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
        return;
    }
    for (const Slot& slot : g_slots)
        if (slot.state == Slot::Ready) remove_tree(slot.path);
    ::_exit(status);
}

}  // namespace pliant
