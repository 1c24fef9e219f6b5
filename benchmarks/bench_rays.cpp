// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// First hits of a picture's rays, 512 × 512, on one core: beams on the volume. An item is a ray.
// The table's reference is Embree, 16 rays at a time on the mesh of the same surface, if it was
// found at build time; otherwise the scalar version (first_hit, which also computes the normal).
// The timing alternates, by the processor time of the thread. Ours includes the cost of a new
// threshold (the leap map); the mesh's cost is listed separately (mesh_ms, tree_ms), and not part
// of the ratio.
//
// The floor is the time of the vector instructions for the last cells alone: each ray crosses at
// least one cell with the threshold (some 60 operations for its cubic, 60 for three Newton steps),
// and a core does two operations on eight doubles per cycle, at 2.4 GHz or less.

#include <benchmark/benchmark.h>
#include <pliant/render.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <map>
#include <string>

#include "interleaved.h"
#include "iso_mesh.h"
#ifdef PLIANT_WITH_EMBREE
#include "embree_rays.h"
#endif

namespace pliant::bench {
namespace {

constexpr int kPixels = 512;

struct Scene {
    Volume volume;
    Vec3d eye_mm, look;
    double half_width;  // tangent of half the field of view
    double iso_hu;
};

const char* shared_data() {
    const char* folder = std::getenv("PLIANT_SHARED_DATA");
    return folder ? folder : "../shared/data";
}

/// Scene 0: in a phantom's airway; 1: in that of a CT; 2: the CT's skin from outside; 3: its bones.
Result<Scene> make_scene(int which, const TaskArena& arena) {
    if (which == 0) {
        auto phantom = make_phantom({.name = "airway", .size = {160, 160, 160}}, arena);
        if (!phantom) return phantom.error();
        const auto& at = phantom->landmarks.at(0);
        return Scene{std::move(phantom->volume), at.eye_mm, at.look, 0.84, -500};
    }
    auto scan = read_volume(std::string(shared_data()) + "/thorax_ct_256.nrrd");
    if (!scan) return scan.error();
    const Vec3d middle = world_from_voxel(scan->grid, {128, 128, 68});
    if (which == 1) return Scene{std::move(*scan), {-13.5, 116, -411}, {0, 0.7, -0.7}, 0.84, -500};
    const Vec3d outside = middle + Vec3d{0, -500, 0};
    return Scene{std::move(*scan), outside, {0, 1, 0}, 0.466, which == 2 ? -500.0 : 250.0};
}

/// Rays of a pin-hole camera, in blocks of 16 × 16, 8 × 8 and 4 × 4 pixels.
std::vector<Vec3d> camera_rays(const Scene& scene) {
    const Vec3d f = normalized(scene.look);
    const Vec3d side = normalized(cross(f, std::abs(f.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, -1, 0}));
    const Vec3d up = cross(side, f);
    std::vector<Vec3d> rays;
    for (int n = 0; n < kPixels * kPixels; ++n) {
        const int tile = n >> 8, x0 = tile % (kPixels / 16) * 16, y0 = tile / (kPixels / 16) * 16;
        const int x = x0 + (n >> 6 & 1) * 8 + (n >> 4 & 1) * 4 + (n & 3);
        const int y = y0 + (n >> 7 & 1) * 8 + (n >> 5 & 1) * 4 + (n >> 2 & 3);
        const double u = scene.half_width * (2 * (x + 0.5) / kPixels - 1);
        const double v = scene.half_width * (1 - 2 * (y + 0.5) / kPixels);
        rays.push_back(normalized(f + u * side + v * up));
    }
    return rays;
}

template <class Work>
double thread_seconds_of(Work&& work) {
    const auto now = [] {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
    };
    const double start = now();
    work();
    return now() - start;
}

/// Arguments: scene.
void first_hits(benchmark::State& state) {
    const TaskArena arena(1);
    const auto scene = make_scene(int(state.range(0)), arena);
    if (!scene) {
        state.SkipWithError("the scan is not there; PLIANT_SHARED_DATA says where it is");
        return;
    }
    const auto rays = camera_rays(*scene);
    const RayCaster caster(scene->volume, arena);
    std::vector<double> ours(rays.size()), twin(rays.size());
    const auto cast = [&] {
        caster.first_hits(scene->eye_mm, rays, scene->iso_hu, Polarity::Rising, ours);
    };
    const auto cast_twin = [&] {
        for (std::size_t n = 0; n < rays.size(); n += 16) {  // every sixteenth ray: slow
            const auto hit =
                caster.first_hit(scene->eye_mm, rays[n], scene->iso_hu, Polarity::Rising);
            twin[n] = hit ? hit->distance_mm : std::numeric_limits<double>::infinity();
        }
    };
    std::vector<double> ours_s, twin_s, mesh_s;
#ifdef PLIANT_WITH_EMBREE
    IsoMesh mesh;
    state.counters["mesh_ms"] =
        1e3 * thread_seconds_of([&] { mesh = make_iso_mesh(scene->volume, scene->iso_hu); });
    std::unique_ptr<EmbreeRays> embree;
    state.counters["tree_ms"] =
        1e3 * thread_seconds_of(
                  [&] { embree = std::make_unique<EmbreeRays>(mesh, scene->eye_mm, rays); });
    state.counters["triangles"] = double(mesh.triangles.size());
    std::vector<float> on_mesh(rays.size());
#endif
    for (auto _ : state) {
        ours_s.push_back(thread_seconds_of(cast));
        twin_s.push_back(16 * thread_seconds_of(cast_twin));
#ifdef PLIANT_WITH_EMBREE
        mesh_s.push_back(thread_seconds_of([&] { embree->cast(on_mesh); }));
#endif
        state.SetIterationTime(ours_s.back());
    }
    const double count = double(rays.size()), a = median(ours_s), b = median(twin_s);
    const double reference = mesh_s.empty() ? b : median(mesh_s);
    constexpr double kFloorOperations = 120 / 8.0 / 2;  // cycles a ray
    state.counters["items"] = count;
    state.counters["ns/item"] = 1e9 * a / count;
    state.counters["reference_ns/item"] = 1e9 * reference / count;
    state.counters["times_faster"] = reference / a;
    state.counters["floor_ns/item"] = kFloorOperations / 2.4;
    state.counters["Mrays/s"] = 1e-6 * count / a;
    state.counters["times_faster_than_twin"] = b / a;
}

BENCHMARK(first_hits)
    ->ArgName("scene")
    ->Arg(0)
    ->Arg(1)
    ->Arg(2)
    ->Arg(3)
    ->UseManualTime()
    ->Iterations(15)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant::bench
