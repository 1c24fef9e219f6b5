// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The library inside of a program that has everything of its own, as an engine does:
//
//   threads and jobs   all loops of the library run as jobs of the host (TaskArena, HostJobs)
//   voxels             the scan is the host's memory, viewed without a copy (VoxelArray::viewed)
//   target             the deformed scan is written to the host's buffer, for its texture
//   frame loop         a push, an update, and the boxes to upload
//
//   host_loop            runs 30 frames
//   host_loop --check    and exits with 1 if the host's buffer differs from a run with the
//                        library's own threads and memory, or if no job ran on a host's thread

#include <pliant/resample.h>
#include <pliant/tissues.h>

#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace {

using namespace pliant;

constexpr int kSize = 64;

int fail(const std::string& message) {
    std::fprintf(stderr, "host_loop: %s\n", message.c_str());
    return 1;
}

/// A minimal job system: threads that take numbered jobs until none is left.
class Engine {
  public:
    explicit Engine(int threads) {
        for (int n = 0; n < threads; ++n) m_threads.emplace_back([this] { work(); });
    }
    ~Engine() {
        {
            const std::lock_guard lock(m_mutex);
            m_ends = true;
        }
        m_wake.notify_all();
        for (std::thread& thread : m_threads) thread.join();
    }
    int thread_count() const { return int(m_threads.size()); }
    std::int64_t jobs() const { return m_jobs; }

    void run(std::int64_t count, const std::function<void(std::int64_t)>& job) {
        std::unique_lock lock(m_mutex);
        m_job = &job;
        m_next = 0;
        m_count = m_left = count;
        m_wake.notify_all();
        m_done.wait(lock, [&] { return m_left == 0; });
        m_job = nullptr;
    }

  private:
    void work() {
        std::unique_lock lock(m_mutex);
        for (;;) {
            m_wake.wait(lock, [&] { return m_ends || (m_job && m_next < m_count); });
            if (m_ends) return;
            const std::int64_t n = m_next++;
            const auto& job = *m_job;
            lock.unlock();
            job(n);
            ++m_jobs;
            lock.lock();
            if (--m_left == 0) m_done.notify_one();
        }
    }

    std::mutex m_mutex;
    std::condition_variable m_wake, m_done;
    const std::function<void(std::int64_t)>* m_job = nullptr;
    std::int64_t m_next = 0, m_count = 0, m_left = 0;
    std::atomic<std::int64_t> m_jobs{0};
    bool m_ends = false;
    std::vector<std::thread> m_threads;
};

/// The host's voxels: a tube of air in tissue.
std::vector<std::int16_t> make_voxels() {
    std::vector<std::int16_t> values;
    for (int n = 0; n < kSize * kSize * kSize; ++n) {
        const int x = n % kSize - kSize / 2, y = n / kSize % kSize - kSize / 2;
        values.push_back(std::int16_t(x * x + y * y < 100 ? kAirHu : 30 + n % 20));
    }
    return values;
}

/// Pushes the wall for 30 frames. @returns hash of the deformed scan; 0 on failure
std::uint64_t run_frames(Tissue& tissue, LiveDeformation& live, std::int64_t& uploaded) {
    Vec3d tool{32, 40, 32};
    for (int frame = 0; frame < 30; ++frame) {
        const Vec3d motion{0.02 * frame, 0.15, 0};
        const auto pushed =
            tissue.push(1, {.point_mm = tool, .push_mm = motion, .sphere_radius_mm = 4});
        if (!pushed) return 0;
        tool = tool + pushed->step_fraction * motion;
        const auto update = live.update();
        if (!update) return 0;
        for (const Box3i& box : update->boxes) {  // here the host uploads them to its texture
            const Vec3i n = box.end - box.begin;
            uploaded += std::int64_t(n.x) * n.y * n.z;
        }
    }
    return hash_volume(live.volume());
}

}  // namespace

int main(int argc, char** argv) {
    const bool checks = argc > 1 && std::string_view(argv[1]) == "--check";
    Engine engine(3);
    const TaskArena arena(
        HostJobs{.thread_count = engine.thread_count(),
                 .run = [&](std::int64_t count, const auto& job) { engine.run(count, job); }});

    const std::vector<std::int16_t> voxels = make_voxels();
    Volume scan;
    scan.grid.size = {kSize, kSize, kSize};
    scan.voxels = VoxelArray<std::int16_t>::viewed(voxels);
    std::vector<std::int16_t> texture(voxels.size());
    Volume target;
    target.grid = scan.grid;
    target.voxels = VoxelArray<std::int16_t>::viewed(std::span(texture));

    auto tissue = make_chainmail(scan, {}, arena);
    if (!tissue) return fail(tissue.error().message);
    auto live = LiveDeformation::create(**tissue, std::move(target));
    if (!live) return fail(live.error().message);
    std::int64_t uploaded = 0;
    const std::uint64_t hash = run_frames(**tissue, *live, uploaded);
    std::printf("30 frames: %lld jobs on the host's threads, %lld voxels to upload\n",
                static_cast<long long>(engine.jobs()), static_cast<long long>(uploaded));
    if (!checks) return 0;

    // The same with the library's threads, and copies.
    const TaskArena own_arena(2);
    Volume copy;
    copy.grid = scan.grid;
    copy.voxels = VoxelArray<std::int16_t>(voxels);
    auto own_tissue = make_chainmail(copy, {}, own_arena);
    if (!own_tissue) return fail(own_tissue.error().message);
    auto own_live = LiveDeformation::create(**own_tissue);
    if (!own_live) return fail(own_live.error().message);
    std::int64_t own_uploaded = 0;
    const std::uint64_t own_hash = run_frames(**own_tissue, *own_live, own_uploaded);
    if (hash == 0 || hash != own_hash) return fail("expected the same voxels in both runs");
    const auto& expected = std::get<VoxelArray<std::int16_t>>(own_live->volume().voxels);
    if (!std::equal(texture.begin(), texture.end(), expected.begin()))
        return fail("expected the deformed scan in the host's buffer");
    if (texture == voxels || voxels != make_voxels())
        return fail("expected a changed texture, and an unchanged scan");
    if (engine.jobs() == 0) return fail("expected jobs on the host's threads");
    return 0;
}
