// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The values of a scan: one contiguous array that is cheap to copy.
//
//   scan.nrrd ──┬── the original: pages of the file, read on demand
//               └── a deformed copy: the same pages, and private ones where it was written to
//
// A large array is backed by a file: the scan's, or an anonymous file in memory. The array maps it
// privately, so a write changes only this array, page by page. A copy is one more private mapping,
// and only written pages are copied. Below 1 MiB, or on systems without such files, an array is
// plain memory.

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

/// Storage of a VoxelArray. Copies may be made during concurrent reads, but not during writes, as
/// for every container. Throws std::bad_alloc if memory is short.
class VoxelMemory {
  public:
    VoxelMemory() = default;
    /// Zeros. Copies are deep until freeze().
    explicit VoxelMemory(std::size_t size);
    /// Maps bytes offset…offset + size of a file. The file must keep its length: touching pages
    /// beyond the end of a truncated file ends the process. Whether later writes to the file show
    /// in the array depends on the system. Replacing the file under its name is safe.
    /// @returns nullopt if the file can't be mapped or is too short
    static std::optional<VoxelMemory> mapped(const std::filesystem::path& file,
                                             std::uint64_t offset, std::size_t size);
    /// Views memory of the host program, which must outlive it. Copies are copies of that memory.
    static VoxelMemory viewed(std::span<std::byte> bytes);
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

    /// Makes the current contents the shared base of all copies, which are cheap afterwards.
    /// Invalidates pointers.
    void freeze();

    /// Visits all bytes in order, in pieces of kPieceBytes (the last may be shorter). Unmodified
    /// pages are read from the file and don't become resident.
    /// @returns false if the file was truncated; missing bytes are zero
    bool for_each_piece(const std::function<void(std::span<const std::byte>)>& visit) const;
    static constexpr std::size_t kPieceBytes = 1 << 18;

    /// Releases unmodified pages from this process's memory; they are reloaded on access. Useful
    /// after a complete pass over a large array.
    /// @pre no concurrent writes to the array: they could be lost
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
    bool m_shared = false;               ///< not frozen yet: writes change the file
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
    /// Zeros. After filling, freeze() makes copies cheap.
    explicit VoxelArray(std::size_t size) : m_memory(size * sizeof(T)) {}
    /// Maps numbers in a file, in the byte order of this machine; see VoxelMemory::mapped.
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

    /// Views values of the host program without a copy; they must outlive the array. Writes to the
    /// array are writes to them. Copies of the array are copies of the values.
    static VoxelArray viewed(std::span<T> values) {
        VoxelArray array;
        array.m_memory = VoxelMemory::viewed(std::as_writable_bytes(values));
        return array;
    }
    /// Likewise. @pre the array, though not its copies, is only read
    static VoxelArray viewed(std::span<const T> values) {
        return viewed(std::span<T>(const_cast<T*>(values.data()), values.size()));
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

    /// Calls visit(std::span<const T>) for all values in order, piece by piece, for single passes.
    /// Unmodified pages don't become resident.
    /// @returns false if the file was truncated; missing values are zero
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
