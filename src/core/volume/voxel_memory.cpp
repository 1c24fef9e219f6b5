// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The kernel knows the modified pages of a private mapping: /proc/self/pagemap distinguishes pages
// of the file from private ones. So writes need no flag. If the kernel doesn't tell, all pages
// count as modified, and copies are deep.

#include <pliant/volume.h>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <new>

#include "base/descriptor.h"

namespace pliant {
namespace {

/// Smaller arrays are plain memory: a file descriptor and a mapping for each would be wasteful.
constexpr std::size_t kMinMapped = 1 << 20;

std::size_t page_size() {
    static const auto size = std::size_t(::sysconf(_SC_PAGESIZE));
    return size;
}

/// Flag of each page of a private mapping: whether it was modified.
std::vector<bool> look_up_pages(const std::byte* mapping, std::size_t pages) {
    constexpr std::uint64_t kPresent = std::uint64_t(1) << 63, kSwapped = std::uint64_t(1) << 62,
                            kOfFile = std::uint64_t(1) << 61;
    std::vector<bool> changed(pages, true);
    const Descriptor map = open_file("/proc/self/pagemap", O_RDONLY);
    if (map.number() < 0) return changed;
    std::array<std::uint64_t, 1024> entries;
    const std::uint64_t first = reinterpret_cast<std::uintptr_t>(mapping) / page_size();
    for (std::size_t at = 0; at < pages; at += entries.size()) {
        const std::size_t count = std::min(entries.size(), pages - at);
        const std::size_t bytes = count * sizeof entries[0];
        std::size_t found = 0;
        (void)read_at(map.number(), entries.data(), bytes, (first + at) * sizeof entries[0],
                      &found);
        if (found != bytes) return changed;
        for (std::size_t n = 0; n < count; ++n)
            changed[at + n] = (entries[n] & (kPresent | kSwapped)) && !(entries[n] & kOfFile);
    }
    return changed;
}

int new_memory_file(std::size_t size) {
    const int number = ::memfd_create("pliant-voxels", MFD_CLOEXEC);
    if (number >= 0 && ::ftruncate(number, off_t(size)) != 0) {
        ::close(number);
        return -1;
    }
    return number;
}

/// Tests the interpretation of the kernel's page flags once, on three pages.
bool try_page_lookup() {
    const std::size_t page = page_size();
    const Descriptor file(new_memory_file(3 * page));
    void* mapping =
        ::mmap(nullptr, 3 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE, file.number(), 0);
    if (mapping == MAP_FAILED) return false;
    volatile char* bytes = static_cast<char*>(mapping);
    bytes[page] = char(bytes[0] + 1);  // reads one page, writes another, leaves the third untouched
    const bool sound =
        look_up_pages(static_cast<std::byte*>(mapping), 3) == std::vector<bool>{false, true, false};
    ::munmap(mapping, 3 * page);
    return sound;
}

}  // namespace

struct VoxelMemory::File {
    explicit File(int number) : descriptor(number) {}
    Descriptor descriptor;
};

bool VoxelMemory::map(bool shared) noexcept {
    void* mapping = ::mmap(nullptr, m_mapping_size, PROT_READ | PROT_WRITE,
                           shared ? MAP_SHARED : MAP_PRIVATE | MAP_NORESERVE,
                           m_file->descriptor.number(), off_t(m_mapping_offset));
    if (mapping == MAP_FAILED) return false;
    const std::ptrdiff_t lead = m_data - m_mapping;
    if (m_mapping) ::munmap(m_mapping, m_mapping_size);
    m_mapping = static_cast<std::byte*>(mapping);
    m_data = m_mapping + lead;
    m_shared = shared;
    return true;
}

VoxelMemory::VoxelMemory(std::size_t size) : m_size(size) {
    if (size >= kMinMapped) {
        if (const int number = new_memory_file(size); number >= 0) {
            m_file = std::make_shared<const File>(number);
            m_mapping_size = size;
            if (map(true)) return;
            m_file.reset();
            m_mapping_size = 0;
        }
    }
    m_plain = std::make_unique<std::byte[]>(size);
    m_data = m_plain.get();
}

std::optional<VoxelMemory> VoxelMemory::mapped(const std::filesystem::path& path,
                                               std::uint64_t offset, std::size_t size) {
    const int number = open_file(path, O_RDONLY | O_NONBLOCK).release();
    if (number < 0 || size == 0) return std::nullopt;
    VoxelMemory memory;
    memory.m_file = std::make_shared<const File>(number);
    struct stat status {};
    if (::fstat(number, &status) != 0 || !S_ISREG(status.st_mode) || status.st_size < 0)
        return std::nullopt;
    const auto length = std::uint64_t(status.st_size);
    if (offset > length || length - offset < size) return std::nullopt;
    const auto lead = std::size_t(offset % page_size());
    memory.m_size = size;
    memory.m_mapping_size = lead + size;
    memory.m_mapping_offset = offset - lead;
    if (!memory.map(false)) return std::nullopt;
    memory.m_data += lead;
    return memory;
}

VoxelMemory VoxelMemory::viewed(std::span<std::byte> bytes) {
    VoxelMemory memory;
    memory.m_data = bytes.data();
    memory.m_size = bytes.size();
    return memory;
}

VoxelMemory::VoxelMemory(const VoxelMemory& other) {
    if (!other.m_file || other.m_shared) {
        VoxelMemory copy(other.m_size);
        if (other.m_size) std::memcpy(copy.m_data, other.m_data, other.m_size);
        copy.freeze();
        swap(copy);
        return;
    }
    m_file = other.m_file;
    m_size = other.m_size;
    m_mapping_size = other.m_mapping_size;
    m_mapping_offset = other.m_mapping_offset;
    if (!map(false)) {
        m_mapping_size = 0;
        throw std::bad_alloc();
    }
    m_data = m_mapping + (other.m_data - other.m_mapping);
    const std::vector<bool> changed = other.changed_pages();
    const std::size_t page = page_size();
    for (std::size_t n = 0; n < changed.size(); ++n)
        if (changed[n])
            std::memcpy(m_mapping + n * page, other.m_mapping + n * page,
                        std::min(page, m_mapping_size - n * page));
}

VoxelMemory::~VoxelMemory() {
    if (m_mapping) ::munmap(m_mapping, m_mapping_size);
}

void VoxelMemory::swap(VoxelMemory& other) noexcept {
    std::swap(m_file, other.m_file);
    std::swap(m_plain, other.m_plain);
    std::swap(m_data, other.m_data);
    std::swap(m_size, other.m_size);
    std::swap(m_mapping, other.m_mapping);
    std::swap(m_mapping_size, other.m_mapping_size);
    std::swap(m_mapping_offset, other.m_mapping_offset);
    std::swap(m_shared, other.m_shared);
}

void VoxelMemory::freeze() {
    if (m_shared) map(false);  // on failure copies remain deep
}

std::vector<bool> VoxelMemory::changed_pages() const {
    static std::atomic<bool> kernel_says{false};  // retried if the test failed
    if (!kernel_says) kernel_says = try_page_lookup();
    const std::size_t pages = (m_mapping_size + page_size() - 1) / page_size();
    if (!kernel_says) return std::vector<bool>(pages, true);
    return look_up_pages(m_mapping, pages);
}

void VoxelMemory::let_go() const {
    if (!m_file || m_shared) return;
    const std::vector<bool> changed = changed_pages();
    const std::size_t page = page_size();
    for (auto begin = changed.begin(); begin != changed.end();) {
        begin = std::find(begin, changed.end(), false);
        const auto end = std::find(begin, changed.end(), true);
        if (begin != end)
            ::madvise(m_mapping + std::size_t(begin - changed.begin()) * page,
                      std::size_t(end - begin) * page, MADV_DONTNEED);
        begin = end;
    }
}

bool VoxelMemory::for_each_piece(
    const std::function<void(std::span<const std::byte>)>& visit) const {
    if (!m_file || m_shared) {
        for (std::size_t at = 0; at < m_size; at += kPieceBytes)
            visit({m_data + at, std::min(kPieceBytes, m_size - at)});
        return true;
    }
    const std::vector<bool> changed = changed_pages();
    const auto lead = std::size_t(m_data - m_mapping);
    const auto buffer = std::make_unique_for_overwrite<std::byte[]>(kPieceBytes);
    bool whole = true;
    for (std::size_t at = 0; at < m_size; at += kPieceBytes) {
        const std::size_t count = std::min(kPieceBytes, m_size - at);
        const auto first = changed.begin() + std::ptrdiff_t((lead + at) / page_size());
        const auto end =
            changed.begin() + std::ptrdiff_t((lead + at + count - 1) / page_size() + 1);
        if (std::find(first, end, true) != end) {
            visit({m_data + at, count});
            continue;
        }
        std::size_t found = 0;
        (void)read_at(m_file->descriptor.number(), buffer.get(), count,
                      m_mapping_offset + lead + at, &found);
        std::memset(buffer.get() + found, 0, count - found);
        whole = whole && found == count;
        visit({buffer.get(), count});
    }
    return whole;
}

}  // namespace pliant
