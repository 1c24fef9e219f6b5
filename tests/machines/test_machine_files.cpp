// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files of this machine and of others are read as they were written. PLIANT_MACHINE_FILES names a
// folder in which each machine leaves its files, in a folder of its own; without it, this machine's
// are made for the test alone. `./dev machines` gives the same folder to all of them.
// Covers: writers/write_volume.cpp, meshes/write_surface.cpp, session/session_log.cpp.

#include <gtest/gtest.h>
#include <pliant/data/session.h>
#include <pliant/mesh_files.h>
#include <pliant/models/scene_files.h>
#include <pliant/resample.h>
#include <pliant/scan_files.h>
#include <pliant/tissues.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <filesystem>

#include "hub/random_session.h"
#include "support/made.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace pliant::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScans[] = {"a.nrrd", "a.nhdr",   "a.mha", "a.mhd",
                                  "a.nii",  "a.nii.gz", "a.vti"};
constexpr const char* kFields[] = {"u.nrrd", "u.nhdr", "u.nii", "u.nii.gz"};
constexpr const char* kSurfaces[] = {"s.stl", "s.ply", "s.obj", "s.vtp", "s.vtu"};

template <class T>
Volume scan_of(std::uint64_t seed) {
    Random random(seed);
    Volume scan;
    scan.grid = {.size = {13, 11, 9}, .spacing_mm = {0.75, 1.5, 1.25}, .origin_mm = {-7, 20, 1.5}};
    std::vector<T> voxels;
    for (int n = 0; n < 13 * 11 * 9; ++n) voxels.push_back(T(random.real(-1000, 900)));
    scan.voxels = std::move(voxels);
    return scan;
}

VectorField field() {
    Random random(3);
    VectorField field;
    field.grid = scan_of<float>(1).grid;
    for (int n = 0; n < 13 * 11 * 9; ++n) {
        const Vec3d v = random.vector(5);
        field.vectors_mm.push_back({float(v.x), float(v.y), float(v.z)});
    }
    return field;
}

/// Nodes that single precision holds, so that all formats keep them.
TetMesh tetrahedra() {
    TetMesh mesh = five_tet_block({3, 2, 2}, 1.5);
    for (Vec3d& node : mesh.nodes_mm) node = node + Vec3d{0.125, -3, 7.5};
    return mesh;
}

class MachineFiles : public testing::Test {
  protected:
    MachineFiles() {
        const char* const shared = std::getenv("PLIANT_MACHINE_FILES");
        m_all = shared ? fs::path(shared) : m_own.path();
        utsname machine{};
        ::uname(&machine);
        m_here = m_all / machine.machine;
        fs::create_directories(m_here);
    }
    /// Calls read with the folder of each machine.
    void for_each_machine(const std::function<void(const fs::path&)>& read) {
        int count = 0;
        for (const auto& entry : fs::directory_iterator(m_all)) {
            SCOPED_TRACE(entry.path().string());
            read(entry.path());
            ++count;
        }
        EXPECT_GT(count, 0);
        RecordProperty("machines", count);
    }
    std::vector<std::unique_ptr<Tissue>> pushed_tissues(bool pushed);

    TaskArena m_arena{2};
    const Volume m_scan = scan_of<std::int16_t>(1);
    TemporaryFolder m_own;
    fs::path m_all, m_here;
};

template <class T>
void write_scans(const fs::path& folder, const std::string& name) {
    for (const Encoding encoding : {Encoding::Raw, Encoding::Gzip})
        for (const char* file : kScans) {
            const auto path = folder / (name + (encoding == Encoding::Raw ? "raw_" : "") + file);
            ASSERT_TRUE(write_volume(path, scan_of<T>(1), encoding).ok()) << path;
        }
}

template <class T>
void read_scans(const fs::path& folder, const std::string& name) {
    const Volume expected = scan_of<T>(1);
    for (const char* kind : {"", "raw_"})
        for (const char* file : kScans) {
            const auto read = read_volume(folder / (name + kind + file));
            ASSERT_TRUE(read.ok()) << read.error().message;
            EXPECT_EQ(read->is_16_bit(), sizeof(T) == 2) << file;
            EXPECT_EQ(read->grid, expected.grid) << file;
            EXPECT_EQ(hash_volume(*read), hash_volume(expected)) << file;
        }
}

TEST_F(MachineFiles, ScansAreTheSame) {
    write_scans<std::int16_t>(m_here, "short_");
    write_scans<float>(m_here, "float_");
    for_each_machine([](const fs::path& folder) {
        read_scans<std::int16_t>(folder, "short_");
        read_scans<float>(folder, "float_");
    });
}

TEST_F(MachineFiles, FieldsAreTheSame) {
    const VectorField expected = field();
    for (const char* file : kFields) {
        const Status written = write_vector_field(m_here / file, expected);
        ASSERT_TRUE(written.ok()) << written.error().message;
    }
    for_each_machine([&](const fs::path& folder) {
        for (const char* file : kFields) {
            const auto read = read_vector_field(folder / file);
            ASSERT_TRUE(read.ok()) << read.error().message;
            EXPECT_EQ(read->grid, expected.grid) << file;
            EXPECT_EQ(read->vectors_mm, expected.vectors_mm) << file;
        }
    });
}

TEST_F(MachineFiles, MeshesAreTheSame) {
    const TetMesh mesh = tetrahedra();
    const TriangleMesh surface = boundary_triangles(mesh);
    for (const char* file : kSurfaces)
        ASSERT_TRUE(write_surface(m_here / file, surface).ok()) << file;
    ASSERT_TRUE(write_vtu(m_here / "t.vtu", mesh).ok());
    for_each_machine([&](const fs::path& folder) {
        for (const char* file : kSurfaces) {
            const auto read = read_surface(folder / file);
            ASSERT_TRUE(read.ok()) << read.error().message;
            const auto own = read_surface(m_here / file);
            ASSERT_TRUE(own.ok()) << own.error().message;
            EXPECT_EQ(read->nodes_mm, own->nodes_mm) << file;
            EXPECT_EQ(read->cells, own->cells) << file;
            EXPECT_EQ(read->cells.size(), surface.cells.size()) << file;
        }
        const auto read = read_tetrahedra(folder / "t.vtu");
        ASSERT_TRUE(read.ok()) << read.error().message;
        EXPECT_EQ(read->nodes_mm, mesh.nodes_mm);
        EXPECT_EQ(read->cells, mesh.cells);
    });
}

/// One of each model that has a state's file, pushed or at rest.
std::vector<std::unique_ptr<Tissue>> MachineFiles::pushed_tissues(bool pushed) {
    std::vector<std::unique_ptr<Tissue>> tissues;
    tissues.push_back(
        made(make_chainmail(m_scan, {.offset = 0.4, .bone_threshold_hu = 5000}, m_arena)));
    tissues.push_back(made(make_elastic(m_scan, {.held_above_hu = 5000}, m_arena)));
    tissues.push_back(made(make_springs(m_scan, {.cell_mm = 3, .fixed_hu = 5000}, m_arena)));
    for (const auto& tissue : tissues) {
        const Vec3d middle = world_from_voxel(m_scan.grid, {6, 5, 4});
        if (!pushed) continue;
        EXPECT_TRUE(tissue->push(1, {middle, {0.6, -0.4, 0.5}, 2}).ok());
        (void)tissue->cut({{middle, middle + Vec3d{4, 0, 0}}, {0, 3, 3}});
        (void)tissue->carve({middle, middle, 1});
        tissue->release(1);
        EXPECT_TRUE(tissue->rest().ok());
    }
    return tissues;
}

TEST_F(MachineFiles, StatesAreTheSame) {
    const auto name = [](std::size_t n) { return "state" + std::to_string(n) + ".plst"; };
    const auto pushed = pushed_tissues(true);
    for (std::size_t n = 0; n < pushed.size(); ++n) {
        const Status saved = pushed[n]->save_state(m_here / name(n));
        ASSERT_TRUE(saved.ok()) << saved.error().message;
    }
    for_each_machine([&](const fs::path& folder) {
        const auto loaded = pushed_tissues(false);
        for (std::size_t n = 0; n < loaded.size(); ++n) {
            const Status status = loaded[n]->load_state(folder / name(n));
            ASSERT_TRUE(status.ok()) << status.error().message;
            EXPECT_NE(loaded[n]->hash(), pushed_tissues(false)[n]->hash()) << n;
            EXPECT_EQ(loaded[n]->hash(), pushed[n]->hash()) << n;
            // ChainMail's is packed by LZ4, which finds other matches on big-endian machines.
            if (n > 0) {
                EXPECT_EQ(bytes_of(folder / name(n)), bytes_of(m_here / name(n))) << n;
            }
        }
    });
}

TEST_F(MachineFiles, SessionsReplay) {
    Random random(5);
    {
        auto scene = serve::open_scene(m_arena);
        const auto records = serve::play(*scene, random, 21);
        fs::remove(m_here / "session");
        auto log =
            serve::SessionLog::create(m_here / "session", {serve::kCube, scene->scan_hash()});
        ASSERT_TRUE(log.ok()) << log.error().message;
        for (const auto& record : records) (*log)->add(record);
        ASSERT_TRUE((*log)->flush().ok());
    }
    std::uint64_t volume = 0;
    for_each_machine([&](const fs::path& folder) {
        const auto report = replay_session(folder / "session", m_arena);
        ASSERT_TRUE(report.ok()) << report.error().message;
        EXPECT_GT(report->marks, 2);
        if (volume) {
            EXPECT_EQ(report->volume_hash, volume);
        }
        volume = report->volume_hash;
    });
}

}  // namespace
}  // namespace pliant::test
