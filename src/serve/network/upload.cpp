// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "network/upload.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>
#include <vector>

#include "base/input_file.h"

namespace pliant::serve {
namespace fs = std::filesystem;
namespace {

/// Bytes between two checks of the free disk space.
constexpr std::uint64_t kLookBytes = std::uint64_t(16) << 20;

std::string mebibytes(std::uint64_t bytes) {
    return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB";
}

Refusal cant_write(const std::string& name) {
    return {507, name + ": can't be written: " + std::strerror(errno)};
}

/// Bytes of the files below a folder. An upload may be removed meanwhile.
Result<std::uint64_t> bytes_below(const fs::path& folder) {
    const auto names = names_in(folder);
    if (!names) return names.error();
    std::uint64_t sum = 0;
    for (const std::string& name : *names) {
        const fs::path path = folder / name;
        Result<std::uint64_t> bytes = 0;
        const auto type = type_of(path);
        if (!type) return type.error();
        if (*type == fs::file_type::directory) bytes = bytes_below(path);
        if (*type == fs::file_type::regular) {
            const InputFile file(path);
            if (const Status s = file.status(); !s) bytes = s.error();
            if (bytes) bytes = file.size();
        }
        if (bytes)
            sum += *bytes;
        else if (const auto left = type_of(path); !left || *left != fs::file_type::not_found)
            return bytes.error();
    }
    return sum;
}

/// Locks a folder. @returns a closed descriptor if that isn't possible
Descriptor lock_folder(const fs::path& folder) {
    Descriptor lock = open_file(folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW);
    return try_lock(lock.number()) ? std::move(lock) : Descriptor();
}

}  // namespace

void sweep_uploads(const fs::path& folder) noexcept try {
    // A folder without a lock may be new: it is created before it is locked.
    constexpr auto kYoung = std::chrono::seconds(60);
    const auto names = names_in(folder);
    for (const std::string& name : names ? *names : std::vector<std::string>()) {
        std::error_code error;
        const fs::path upload = folder / name;
        if (!name.starts_with("pliant-upload-") ||
            fs::symlink_status(upload, error).type() != fs::file_type::directory)
            continue;
        const auto age = fs::file_time_type::clock::now() - fs::last_write_time(upload, error);
        if (error || age <= kYoung) continue;
        const Descriptor lock = lock_folder(upload);
        if (lock.is_open()) fs::remove_all(upload, error);
    }
} catch (const std::exception&) {  // out of memory: retry next time
}

std::string base_name(std::string_view name) {
    const auto slash = name.find_last_of("/\\");
    if (slash != std::string_view::npos) name.remove_prefix(slash + 1);
    std::string text;
    for (const char c : name)
        if (std::uint8_t(c) >= 0x20 && c != 0x7f) text += c;
    if (text.size() > kMaxFileName) text.erase(0, text.size() - kMaxFileName);
    // Cut at a character boundary (UTF-8).
    while (!text.empty() && (std::uint8_t(text[0]) & 0xc0) == 0x80) text.erase(0, 1);
    return text.find_first_not_of('.') == std::string::npos ? "" : text;
}

Upload::Upload(UploadSettings settings, std::string id)
    : m_settings(std::move(settings)), m_id(std::move(id)) {}

Upload::~Upload() {
    (void)m_file.close();
    std::error_code ignored;
    if (!m_root.empty() && !m_is_kept) fs::remove_all(m_root, ignored);
}

MayRefuse Upload::make_root() {
    if (!m_root.empty()) return {};
    std::error_code error;
    fs::path folder = m_settings.folder;
    if (folder.empty())
        folder = fs::temp_directory_path(error);
    else
        fs::create_directories(folder, error);
    const auto kept = m_settings.keeps ? bytes_below(folder) : Result<std::uint64_t>(0);
    if (!kept) return Refusal{507, folder.filename().string() + ": can't be listed"};
    if (*kept > kMaxKeptBytes)
        return Refusal{507, folder.filename().string() + ": expected up to " +
                                mebibytes(kMaxKeptBytes) +
                                " of scans beside a session, found more"};
    sweep_uploads(folder);
    std::string root = (folder / "pliant-upload-XXXXXX").string();
    if (error || !::mkdtemp(root.data())) return cant_write("upload");
    m_root = root;
    m_lock = lock_folder(m_root);
    fs::create_directory(scan_folder(), error);
    if (error) return cant_write("upload");
    return {};
}

MayRefuse Upload::check_room(std::uint64_t bytes) const {
    if (bytes > m_settings.max_bytes || m_bytes > m_settings.max_bytes - bytes)
        return Refusal{413, "expected a scan of up to " + mebibytes(m_settings.max_bytes) +
                                ", found " + mebibytes(m_bytes + bytes) + " or more"};
    std::error_code error;
    const auto space = fs::space(m_root, error);
    if (!error && (space.available < kSpareDiskBytes || space.available - kSpareDiskBytes < bytes))
        return Refusal{507, "expected room on the server's disk for " + mebibytes(bytes) +
                                " more, found too little"};
    return {};
}

MayRefuse Upload::begin_file(const std::string& name, std::optional<std::uint64_t> size) {
    const std::string own = base_name(name);
    if (own.empty()) return Refusal{400, "name: expected that of a file, found none"};
    if (m_names.size() >= std::size_t(kMaxUploadFiles))
        return Refusal{413, "expected up to " + std::to_string(kMaxUploadFiles) +
                                " files of one scan, found more"};
    if (size && *size > m_settings.max_bytes) return check_room(*size);  // creates no folder for it
    if (auto refusal = make_root()) return refusal;
    if (auto refusal = check_room(size.value_or(0))) return refusal;
    if (!m_names.insert(own).second)
        return Refusal{400, own + ": expected files of different names, found two"};
    m_file = open_file(scan_folder() / own, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, 0600);
    if (!m_file.is_open()) return cant_write(own);
    return {};
}

MayRefuse Upload::add(std::span<const char> bytes) {
    m_unchecked += bytes.size();
    if (m_unchecked > kLookBytes || m_bytes + bytes.size() > m_settings.max_bytes) {
        if (auto refusal = check_room(bytes.size())) return refusal;
        m_unchecked = 0;
    }
    m_bytes += bytes.size();
    if (write_all(m_file.number(), bytes.data(), bytes.size())) return cant_write("upload");
    return {};
}

MayRefuse Upload::end_file() {
    // A session's scan must survive a power failure.
    const bool synced = !m_settings.keeps || sync_data(m_file.number()) == 0;
    if (m_file.close() != 0 || !synced) return cant_write("upload");
    return {};
}

MayRefuse Upload::rename(const std::string& name) {
    const std::string own = base_name(name);
    if (own.empty() || own == m_name) return {};
    std::error_code error;
    fs::rename(scan_folder(), m_root / own, error);
    if (error) return Refusal{507, own + ": can't be written: " + error.message()};
    m_name = own;
    return {};
}

Result<fs::path> Upload::keep() {
    if (!m_settings.keeps) return scan_folder();
    std::error_code error;
    for (int n = 1; n < 100'000; ++n) {
        const fs::path folder = m_settings.folder / std::to_string(n);
        // Creating the folder claims the number; rename() may replace an empty folder.
        if (!fs::create_directory(folder, error)) continue;
        fs::rename(m_root, folder, error);
        if (error) break;
        m_root = folder;
        m_is_kept = true;
        return scan_folder();
    }
    return Error{ErrorCode::Unwritable, "upload: can't be kept beside the session"};
}

}  // namespace pliant::serve
