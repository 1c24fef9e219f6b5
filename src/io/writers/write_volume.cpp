// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Choice of the writer for a path. Files are staged, so that they appear atomically.

#include "base/text.h"
#include "writers/stream_writers.h"

#include <pliant/core/files.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <algorithm>
#include <new>
#include <span>
#include <string>
#include <vector>

namespace pliant {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kEndings[] = {".nrrd", ".nhdr",   ".mha", ".mhd",
                                         ".nii",  ".nii.gz", ".vti"};

/// The ending of a name that write_volume accepts; empty: none.
std::string_view ending_of(const fs::path& path) {
    const std::string name = lower_case(path.filename().string());
    for (const std::string_view ending : kEndings)
        if (name.ends_with(ending)) return ending;
    return {};
}

/// "expected a name that ends in .a, .b or .c"
Error wrong_ending(const fs::path& path, std::span<const std::string_view> endings) {
    std::string list;
    for (std::size_t n = 0; n < endings.size(); ++n)
        list += std::string(n == 0                    ? ""
                            : n + 1 == endings.size() ? " or "
                                                      : ", ") +
                std::string(endings[n]);
    return {ErrorCode::Unwritable, path.string() + ": expected a name that ends in " + list};
}

/// Passes numbers to a writer. @throws std::bad_alloc  if the caller gives up
template <class Writer>
class Pieces {
  public:
    Pieces(Writer& writer, const std::function<bool()>& give_up)
        : m_writer(writer), m_give_up(give_up) {}
    template <class T>
    void add(std::span<const T> numbers) {
        if (m_give_up && m_give_up()) throw std::bad_alloc();
        m_writer.add(std::as_bytes(numbers));
    }

  private:
    Writer& m_writer;
    const std::function<bool()>& m_give_up;
};

/// @param add_numbers  adds all numbers to the pieces; false on failure
template <class Writer, class AddNumbers>
Status write_staged(const fs::path& path, const NrrdLayout& layout, Encoding encoding,
                    const std::function<bool()>& give_up, const AddNumbers& add_numbers) {
    try {
        StagedFiles files;
        const auto staged = files.stage(path);
        if (!staged) return staged.error();
        Writer writer(*staged, layout, encoding);
        if (!add_numbers(Pieces(writer, give_up)))
            return Error{ErrorCode::Unreadable,
                         path.string() +
                             ": can't be written: the file that the scan is mapped "
                             "from was cut short"};
        if (Status status = writer.finish(); !status)
            return Error{status.error().code,
                         path.string() + status.error().message.substr(staged->string().size())};
        return files.commit();
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::LimitExceeded, path.string() + ": not enough memory to write it"};
    }
}

template <class Writer>
Status write_voxels(const fs::path& path, const Volume& volume, Encoding encoding,
                    const std::function<bool()>& give_up) {
    const Component component = volume.is_16_bit() ? Component::Int16 : Component::Float32;
    return write_staged<Writer>(
        path, {volume.grid, component, 1, volume.key_values}, encoding, give_up, [&](auto pieces) {
            const auto add = [&](auto piece) { pieces.add(piece); };
            return std::visit([&](const auto& voxels) { return voxels.for_each_piece(add); },
                              volume.voxels);
        });
}

}  // namespace

std::span<const std::string_view> volume_endings() noexcept {
    return kEndings;
}

Status write_volume(const fs::path& path, const Volume& volume, Encoding encoding,
                    const std::function<bool()>& give_up) {
    const std::string_view ending = ending_of(path);
    if (ending.empty()) return wrong_ending(path, kEndings);
    if (ending == ".vti") return write_vti(path, volume);
    if (Status s = check_volume(volume, path.string()); !s) return s;
    if (ending == ".mha" || ending == ".mhd")
        return write_voxels<MetaWriter>(path, volume, encoding, give_up);
    if (ending == ".nrrd" || ending == ".nhdr")
        return write_voxels<NrrdWriter>(path, volume, encoding, give_up);
    if (Status s = check_nifti_size(path, volume.grid); !s) return s;
    return write_voxels<NiftiWriter>(path, volume, encoding, give_up);
}

Status write_vector_field(const fs::path& path, const Grid& grid, FieldKind kind,
                          const FieldSlices& fill_slice, Encoding encoding,
                          const std::function<bool()>& give_up) {
    constexpr std::string_view kFieldEndings[] = {".nrrd", ".nhdr"};
    const std::string_view ending = ending_of(path);
    if (ending != ".nrrd" && ending != ".nhdr") return wrong_ending(path, kFieldEndings);
    if (Status s = check_grid(grid, path.string()); !s) return s;
    const KeyValues key_values = {
        {"displacement field type", kind == FieldKind::Modeling ? "modeling" : "resampling"}};
    return write_staged<NrrdWriter>(
        path, {grid, Component::Float32, 3, key_values}, encoding, give_up, [&](auto pieces) {
            std::vector<Vec3f> slice(std::size_t(grid.size.x) * std::size_t(grid.size.y));
            for (int k = 0; k < grid.size.z; ++k) {
                std::fill(slice.begin(), slice.end(), Vec3f{0, 0, 0});
                fill_slice(k, slice);
                pieces.add(std::span<const Vec3f>(slice));
            }
            return true;
        });
}

namespace {

/// One component after the other.
Status write_nifti_field(const fs::path& path, const VectorField& field, Encoding encoding,
                         const std::function<bool()>& give_up) {
    if (Status s = check_nifti_size(path, field.grid); !s) return s;
    const KeyValues none;
    const NrrdLayout layout{field.grid, Component::Float32, 3, none};
    return write_staged<NiftiWriter>(path, layout, encoding, give_up, [&](auto pieces) {
        std::vector<float> piece(std::min<std::size_t>(field.vectors_mm.size(), 1 << 16));
        for (int a = 0; a < 3; ++a)
            for (std::size_t done = 0; done < field.vectors_mm.size();) {
                const std::size_t count = std::min(piece.size(), field.vectors_mm.size() - done);
                for (std::size_t n = 0; n < count; ++n) piece[n] = field.vectors_mm[done + n][a];
                pieces.add(std::span<const float>(piece.data(), count));
                done += count;
            }
        return true;
    });
}

}  // namespace

Status write_vector_field(const fs::path& path, const VectorField& field, Encoding encoding,
                          const std::function<bool()>& give_up) {
    if (Status s = check_field(field, path.string()); !s) return s;
    if (const std::string_view ending = ending_of(path); ending == ".nii" || ending == ".nii.gz")
        return write_nifti_field(path, field, encoding, give_up);
    const std::size_t count = std::size_t(field.grid.size.x) * std::size_t(field.grid.size.y);
    const auto copy_slice = [&](int k, std::span<Vec3f> vectors_mm) {
        std::copy_n(field.vectors_mm.data() + std::size_t(k) * count, count, vectors_mm.data());
    };
    return write_vector_field(path, field.grid, field.kind, copy_slice, encoding, give_up);
}

}  // namespace pliant
