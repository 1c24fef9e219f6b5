// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The values of a scan: one array, contiguous, as large as a scan is, and cheap to copy.
//
//   scan.nrrd ──┬── the original: pages of the file, read when they are touched
//               └── a deformed copy: the same pages, and its own where it was written to
//
// A large array stands on a file, which is the scan's own or lies in memory and has no name. The
// array maps it privately, so that writing changes this array alone, page by page; a copy is one
// more private mapping, and only pages that were written to are copied. Below 1 MiB, and where the
// system has no such files, an array is plain memory.

#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

/// The bytes below a VoxelArray. Copies may be made while others read; like those of any
/// container, not while somebody writes. Where memory is short, std::bad_alloc is thrown.
class VoxelMemory {
  public:
    VoxelMemory() = default;
    /// Zeros. Copies of it are deep until it is frozen.
    explicit VoxelMemory(std::size_t size);
    /// Bytes offset…offset + size of a file. It must keep its length: touching pages beyond the end
    /// of a file that was cut short afterwards ends the process. Whether what others write into it
    /// later shows in the array is up to the system; a file that is replaced under its name is
    /// safe.
    /// @returns nothing where the file can't be mapped, or ends before
    static std::optional<VoxelMemory> mapped(const std::filesystem::path& file,
                                             std::uint64_t offset, std::size_t size);
    VoxelMemory(const VoxelMemory& other);
    VoxelMemory(VoxelMemory&& other) noexcept { swap(other); }
    VoxelMemory& operator=(const VoxelMemory& other) {
        VoxelMemory copy(other);
        swap(copy);
        return *this;
    }
    VoxelMemory& operator=(VoxelMemory&& other) noexcept {
        VoxelMemory taken(std::move(other));
        swap(taken);
        return *this;
    }
    ~VoxelMemory();
    void swap(VoxelMemory& other) noexcept;

    std::byte* data() { return m_data; }
    const std::byte* data() const { return m_data; }
    std::size_t size() const { return m_size; }

    /// What is there now becomes the common ground of all copies, which are cheap from here on.
    /// Pointers from before are void.
    void freeze();

    /// Hands out all bytes in order, in pieces of kPieceBytes (the last may be shorter). Pages that
    /// nobody wrote to are read from the file, and need no place in this process's memory.
    /// @returns false if the file has been cut short; missing bytes are zero
    bool for_each_piece(const std::function<void(std::span<const std::byte>)>& visit) const;
    static constexpr std::size_t kPieceBytes = 1 << 18;

    /// Pages that nobody wrote to leave this process's memory, and come back when they are touched:
    /// for those who have read all of a large array and won't for a while.
    /// @pre nobody writes to the array meanwhile: what he writes could be lost
    void let_go() const;

  private:
    struct File;
    bool map(bool shared) noexcept;
    std::vector<bool> changed_pages() const;

    std::shared_ptr<const File> m_file;  ///< null: m_plain is in use
    std::unique_ptr<std::byte[]> m_plain;
    std::byte* m_data = nullptr;
    std::size_t m_size = 0;
    std::byte* m_mapping = nullptr;  ///< whole pages, with m_data in the first of them
    std::size_t m_mapping_size = 0;
    std::uint64_t m_mapping_offset = 0;  ///< of the mapping in the file
    bool m_shared = false;               ///< not frozen yet: writing changes the file
};

/// Like std::vector, but of fixed size, and cheap to copy.
template <class T>
class VoxelArray {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    using value_type = T;

    VoxelArray() = default;
    VoxelArray(const std::vector<T>& values)
        : VoxelArray(std::span<const T>(values.data(), values.size())) {}
    VoxelArray(std::initializer_list<T> values)
        : VoxelArray(std::span<const T>(values.begin(), values.size())) {}
    explicit VoxelArray(std::span<const T> values) : VoxelArray(values.size()) {
        T* out = data();
        for (const T& value : values) *out++ = value;
        freeze();
    }
    /// Zeros, to be filled; then freeze() makes copies cheap.
    explicit VoxelArray(std::size_t size) : m_memory(size * sizeof(T)) {}
    /// Numbers in a file, in the byte order of this machine; see VoxelMemory::mapped.
    /// @param offset  of the first of them [bytes]
    static std::optional<VoxelArray> mapped(const std::filesystem::path& file, std::uint64_t offset,
                                            std::size_t size) {
        if (offset % sizeof(T) != 0) return std::nullopt;
        auto memory = VoxelMemory::mapped(file, offset, size * sizeof(T));
        if (!memory) return std::nullopt;
        VoxelArray array;
        array.m_memory = std::move(*memory);
        return array;
    }

    T* data() { return reinterpret_cast<T*>(m_memory.data()); }
    const T* data() const { return reinterpret_cast<const T*>(m_memory.data()); }
    std::size_t size() const { return m_memory.size() / sizeof(T); }
    bool empty() const { return size() == 0; }
    T& operator[](std::size_t n) { return data()[n]; }
    const T& operator[](std::size_t n) const { return data()[n]; }
    T* begin() { return data(); }
    T* end() { return data() + size(); }
    const T* begin() const { return data(); }
    const T* end() const { return data() + size(); }

    void freeze() { m_memory.freeze(); }

    /// visit(std::span<const T>) for all values in order, piece by piece: for those who need each
    /// value once. What nobody wrote to doesn't become resident by it.
    /// @returns false if the file below has been cut short; missing values are zero
    template <class Visit>
    bool for_each_piece(Visit&& visit) const {
        return m_memory.for_each_piece([&](std::span<const std::byte> bytes) {
            visit(std::span<const T>(reinterpret_cast<const T*>(bytes.data()),
                                     bytes.size() / sizeof(T)));
        });
    }

    /// See VoxelMemory::let_go.
    void let_go() const { m_memory.let_go(); }

    friend bool operator==(const VoxelArray& a, const VoxelArray& b) {
        if (a.size() != b.size()) return false;
        for (std::size_t n = 0; n < a.size(); ++n)
            if (!(a[n] == b[n])) return false;
        return true;
    }

  private:
    VoxelMemory m_memory;
};

}  // namespace pliant
#pragma GCC visibility pop
