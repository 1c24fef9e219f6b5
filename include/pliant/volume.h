// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A scan: voxel values on a grid, with the key/value pairs of its file.
//
// Values are stored in 16 bits if all are whole numbers in −32768…32767, and as float otherwise.
// Values of a CT are Hounsfield units; scan_values.h tells which scans are CT.

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

// The map between voxels and the world.
//
//   world [mm, LPS] = origin_mm + direction · diag(spacing_mm) · ijk
//
// Voxel centres lie at whole ijk. The direction matrix may be oblique or left-handed; its columns
// are perpendicular unit vectors. "Lattice" vectors are in millimetres along the grid's own axes.

/// Half-open box of voxels: begin ≤ ijk < end on every axis.
struct Box3i {
    Vec3i begin{0, 0, 0};
    Vec3i end{0, 0, 0};

    friend constexpr bool operator==(const Box3i&, const Box3i&) = default;
};

constexpr bool is_empty(const Box3i& b) {
    return b.begin.x >= b.end.x || b.begin.y >= b.end.y || b.begin.z >= b.end.z;
}
constexpr bool contains(const Box3i& b, Vec3i p) {
    return p.x >= b.begin.x && p.x < b.end.x && p.y >= b.begin.y && p.y < b.end.y &&
           p.z >= b.begin.z && p.z < b.end.z;
}

struct Grid {
    Vec3i size{0, 0, 0};           ///< voxels along i, j, k
    Vec3d spacing_mm{1, 1, 1};     ///< between voxel centres
    Vec3d origin_mm{0, 0, 0};      ///< centre of voxel (0,0,0), LPS
    Mat3d direction = kIdentity3;  ///< columns: the i, j, k axes in LPS

    friend constexpr bool operator==(const Grid&, const Grid&) = default;
};

constexpr std::size_t voxel_count(const Grid& g) {
    return std::size_t(g.size.x) * std::size_t(g.size.y) * std::size_t(g.size.z);
}
/// Index of voxel ijk in an array with i fastest. @pre ijk inside the grid
constexpr std::size_t voxel_index(const Grid& g, Vec3i p) {
    return std::size_t(p.x) +
           std::size_t(g.size.x) * (std::size_t(p.y) + std::size_t(g.size.y) * std::size_t(p.z));
}
constexpr Box3i voxel_box(const Grid& g) {
    return {{0, 0, 0}, g.size};
}

/// Vector along the grid's axes [mm] → world vector [mm, LPS].
constexpr Vec3d world_from_lattice_vector(const Grid& g, Vec3d v_mm) {
    return g.direction * v_mm;
}
/// World vector [mm, LPS] → vector along the grid's axes [mm].
constexpr Vec3d lattice_from_world_vector(const Grid& g, Vec3d v_mm) {
    return inverse(g.direction) * v_mm;
}
/// Continuous voxel index → world point [mm, LPS].
constexpr Vec3d world_from_voxel(const Grid& g, Vec3d ijk) {
    const Vec3d s = g.spacing_mm;
    return g.origin_mm + g.direction * Vec3d{s.x * ijk.x, s.y * ijk.y, s.z * ijk.z};
}
/// World point [mm, LPS] → continuous voxel index.
constexpr Vec3d voxel_from_world(const Grid& g, Vec3d x_mm) {
    const Vec3d v = lattice_from_world_vector(g, x_mm - g.origin_mm);
    return {v.x / g.spacing_mm.x, v.y / g.spacing_mm.y, v.z / g.spacing_mm.z};
}

/// Box along the axes of the world.
struct WorldBox {
    Vec3d low_mm, high_mm;
};
/// Smallest box that contains all voxel centres [mm, LPS].
constexpr WorldBox centre_bounds(const Grid& g) {
    WorldBox box{g.origin_mm, g.origin_mm};
    for (int a = 0; a < 3; ++a) {
        const Vec3d axis =
            (g.spacing_mm[a] * (g.size[a] - 1)) * g.direction.columns[std::size_t(a)];
        for (int row = 0; row < 3; ++row)
            (axis[row] < 0 ? box.low_mm : box.high_mm)[row] += axis[row];
    }
    return box;
}

// The values of a scan: one contiguous array that is cheap to copy.
//
//   scan.nrrd ──┬── the original: pages of the file, read on demand
//               └── a deformed copy: the same pages, and private ones where it was written to
//
// A large array is backed by a file: the scan's, or an anonymous file in memory. The array maps it
// privately, so a write changes only this array, page by page. A copy is one more private mapping,
// and only written pages are copied. Below 1 MiB, or on systems without such files, an array is
// plain memory.

/// Storage of a VoxelArray. Copies may be made during concurrent reads, but not during writes, as
/// for every container. Throws std::bad_alloc if memory is short.
/// Thread safety: concurrent reads.
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
/// Thread safety: concurrent reads.
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

/// Value of air [HU]: a volume's background unless it is set.
inline constexpr int kAirHu = -1000;

using KeyValues = std::vector<std::pair<std::string, std::string>>;

struct Volume {
    Grid grid;
    /// One value per voxel, i fastest: voxel_count(grid) of them.
    std::variant<VoxelArray<std::int16_t>, VoxelArray<float>> voxels;
    KeyValues key_values;  ///< as in the file, in its order
    /// Value beyond the grid and in gaps of the deformed tissue: air of CT, or another scan's
    /// lowest value (scan_values.h).
    float background = kAirHu;

    bool is_16_bit() const { return voxels.index() == 0; }
    /// Value of voxel ijk. @pre ijk inside the grid
    float at(Vec3i ijk) const {
        const std::size_t n = voxel_index(grid, ijk);
        return is_16_bit() ? float((*std::get_if<0>(&voxels))[n]) : (*std::get_if<1>(&voxels))[n];
    }
};

/// Checks a volume that a program has filled in, in constant time: the size of each axis (1…65536),
/// spacing (10⁻⁶…10⁴ mm), origin (within 10⁸ mm), direction (perpendicular unit columns, to within
/// 0.001), and the number of voxels. Every function of the library that takes a volume and can fail
/// calls it. Functions that return a picture treat an invalid volume as air.
///
/// Voxel values are not checked. A NaN counts as air in material lookups, propagates through
/// interpolation, and is never a wall to a ray.
/// @param name  of the volume, for the message
/// @returns InvalidArgument with the field, the expected and the found value
Status check_volume(const Volume& volume, const std::string& name = "volume");
/// Checks a grid alone.
Status check_grid(const Grid& grid, const std::string& name = "volume");

/// A scan of one slice has no cells between its voxels, so that nothing of it can be deformed. This
/// doubles each axis with one voxel: two equal slices, half a spacing beside the original one.
/// @returns a copy of a volume with more voxels along each axis; LimitExceeded if memory is short
Result<Volume> with_doubled_slices(const Volume& volume) noexcept;
/// Takes the first slice along each axis that with_doubled_slices has doubled.
/// @param grid  of the volume before
Result<Volume> with_single_slices(const Volume& doubled, const Grid& grid) noexcept;

/// Trilinear interpolation at a continuous voxel index; voxels outside of the grid have the
/// background's value.
float sample_linear(const Volume& volume, Vec3d ijk);

/// Progress of long work, 0…1. Called on the calling thread.
using Progress = std::function<void(double fraction)>;

/// A reader's remarks on the volume.
struct ReadNotes {
    std::string format;              ///< "NRRD", "NIfTI", "MetaImage", "VTI", "VTK", "DICOM"
    std::string stored_type;         ///< "int16", "uint8", "float32", …
    std::vector<std::string> notes;  ///< changes and assumptions, one line each
    // Only DICOM tells these.
    std::string modality{};      ///< "CT", "MR", "US", …; empty: not told
    std::string rescale_type{};  ///< "HU", "US" (unspecified), …; empty: not told
    bool is_rescaled = false;    ///< stored numbers were scaled or shifted
    double window = 0;           ///< first Window Width of the middle slice; 0: not told
    double level = 0;            ///< its Window Center
};

/// Whether a vector field maps the rest shape to the deformed one, or back.
enum class FieldKind {
    Modeling,    ///< forward displacement at rest voxel centres
    Resampling,  ///< inverse: output point → input point, on the output grid
};

/// One vector [mm, LPS] per voxel of a grid, i fastest.
struct VectorField {
    Grid grid;
    FieldKind kind = FieldKind::Modeling;
    std::vector<Vec3f> vectors_mm;
};

/// Checks the grid as check_volume, and the number of vectors.
Status check_field(const VectorField& field, const std::string& name = "field");

/// Fills slice k of a field, i fastest. Called once for each slice, in order.
/// @param[out] vectors_mm  grid.size.x · grid.size.y vectors [mm, LPS], zero before
using FieldSlices = std::function<void(int k, std::span<Vec3f> vectors_mm)>;

// Test scans from analytic shapes, in Hounsfield units, identical on every machine.

/// A recommended push and view of a phantom [mm, LPS].
struct PhantomLandmark {
    std::string name;     ///< "carina", "septum", …
    Vec3d push_point_mm;  ///< on the tissue's surface
    Vec3d push_mm;        ///< a push with a clear effect
    Vec3d eye_mm;         ///< in the lumen, with the pushed point in view
    Vec3d look;           ///< unit vector from the eye
};

struct PhantomSettings {
    std::string name;           ///< one of phantom_names()
    Vec3i size{128, 128, 128};  ///< voxels
    /// [mm]; zero: the phantom's extent divided by the size
    Vec3d spacing_mm{0, 0, 0};
    Mat3d direction = kIdentity3;  ///< axes of the grid in LPS; the shapes don't rotate
};
SettingRows<PhantomSettings> phantom_rows() noexcept;

struct Phantom {
    Volume volume;                           ///< centred on the world's origin
    std::vector<PhantomLandmark> landmarks;  ///< may be empty; also in the volume's key_values
};

std::span<const std::string_view> phantom_names();

/// Makes a phantom. The shapes are fixed in the world; size, spacing and direction define the
/// sampling. Edges are anti-aliased: over one voxel in cube and layers, over two, as in a scanner,
/// in the others.
/// @returns InvalidArgument with the valid names, or the field that is out of range
Result<Phantom> make_phantom(const PhantomSettings& settings, const TaskArena& arena,
                             const Progress& progress = {});

}  // namespace pliant
#pragma GCC visibility pop
