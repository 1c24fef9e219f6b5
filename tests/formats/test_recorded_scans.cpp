// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scans are read to the same bits as when they were recorded: grid, voxels, keys and notes. The
// table was made with ITK 5.2 as the reader; where it was changed since, recorded_hashes.inc says
// why. To record a new scan, make it in recorded_….cpp and copy the row that the test prints.
// Covers: formats/*_header.cpp, formats/read_volume.cpp.

#include "formats/recorded_files.h"
#include "support/temporary_folder.h"

#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <span>

#include "base/hash.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

struct Row {
    const char* name;
    std::uint64_t hash;  ///< 0: refused
};
const Row kRows[] = {
#include "formats/recorded_hashes.inc"
};

void add_text(Hash64& hash, const std::string& text) {
    hash.add(std::span<const char>(text));
}

void add_grid(Hash64& hash, const Grid& grid) {
    for (int a = 0; a < 3; ++a) hash.add_word(std::uint32_t(grid.size[a]));
    std::vector<double> numbers;
    for (const Vec3d v : {grid.spacing_mm, grid.origin_mm, grid.direction.columns[0],
                          grid.direction.columns[1], grid.direction.columns[2]})
        for (int a = 0; a < 3; ++a) numbers.push_back(v[a] + 0.0);  // no negative zeros
    hash.add(std::span<const double>(numbers));
}

std::uint64_t hash_scan(const fs::path& path) {
    ReadNotes notes;
    const auto volume = read_volume(path, {}, &notes);
    if (!volume) return 0;
    Hash64 hash;
    add_grid(hash, volume->grid);
    hash.add_word(volume->voxels.index());
    std::visit(
        [&]<class T>(const VoxelArray<T>& voxels) {
            hash.add(std::span<const T>(voxels.data(), voxels.size()));
        },
        volume->voxels);
    for (const auto& [key, value] : volume->key_values) {
        add_text(hash, key);
        add_text(hash, value);
    }
    add_text(hash, notes.format);
    add_text(hash, notes.stored_type);
    for (const std::string& note : notes.notes)
        // Two notes are younger than the table.
        if (!note.starts_with("axes lean by") && !note.starts_with("the data are longer"))
            add_text(hash, note);
    return hash.value();
}

std::uint64_t hash_field(const fs::path& path) {
    const auto field = read_vector_field(path);
    if (!field) return 0;
    Hash64 hash;
    add_grid(hash, field->grid);
    hash.add_word(std::uint64_t(field->kind));
    hash.add(std::span<const Vec3f>(field->vectors_mm));
    return hash.value();
}

std::string row_of(std::string name) {
    name = name.substr(0, name.find(" / "));
    for (char& c : name)
        if (c < ' ' || c > '~' || c == '"' || c == '\\') c = '~';
    return name;
}

/// Scans of one row share a hash, so that a thousand random ones take one.
class Recorded : public testing::Test {
  protected:
    void read(const test::MadeScans& scans) {
        for (const test::MadeScan& scan : scans) {
            const test::TemporaryFolder folder;
            for (const auto& [name, bytes] : scan.files) folder.write(name, bytes);
            const fs::path path = folder / scan.files[0].first;
            add(scan.name, scan.is_field ? hash_field(path) : hash_scan(path));
        }
    }
    void add(const std::string& name, std::uint64_t hash) {
        const std::string row = row_of(name);
        const auto [at, is_new] = m_found.emplace(row, hash);
        if (is_new)
            m_order.push_back(row);
        else
            at->second = at->second * 0x9e3779b97f4a7c15ULL + hash;
    }
    void TearDown() override {
        std::map<std::string, std::uint64_t> expected;
        for (const Row& row : kRows) expected.emplace(row.name, row.hash);
        for (const std::string& name : m_order) {
            const auto row = expected.find(name);
            const std::uint64_t found = m_found.at(name);
            if (row != expected.end() && row->second == found) continue;
            ADD_FAILURE() << "    {\"" << name << "\", 0x" << std::hex << found << "},"
                          << (row == expected.end() ? " is new"
                              : found == 0          ? " is refused now"
                              : row->second == 0    ? " was refused"
                                                    : " was read to other bits");
        }
    }
    std::map<std::string, std::uint64_t> m_found;
    std::vector<std::string> m_order;
};

TEST_F(Recorded, Nrrd) {
    read(test::nrrd_scans());
    read(test::nrrd_key_scans());
}
TEST_F(Recorded, MetaImage) {
    read(test::meta_scans());
}
TEST_F(Recorded, Nifti) {
    read(test::nifti_scans());
}
TEST_F(Recorded, PlacesOfNifti) {
    read(test::nifti_orientations());
}

TEST_F(Recorded, SharedScans) {
    const fs::path data = PLIANT_SHARED_DATA;
    if (!fs::is_directory(data)) GTEST_SKIP() << data << " is missing";
    for (const char* name :
         {"thorax_ct_256.nrrd", "thorax_ct_airways_crop.nrrd", "thorax_ct_airways_crop-label.nrrd",
          "abdomen_ct_3mm.nii.gz", "abdomen_ct_3mm-label.nii.gz", "aorta_cta_1p5mm.nii.gz",
          "aorta_cta_1p5mm-label.nii.gz", "head_ct_tiny_64.nrrd", "mr_head_mni152_2mm.nii.gz"})
        add(std::string("shared ") + name, hash_scan(data / name));
}

}  // namespace
}  // namespace pliant
