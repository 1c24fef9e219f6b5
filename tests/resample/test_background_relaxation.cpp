// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Relaxation in the background. One thread owns the tissue, relaxes it in slices and publishes the
// result; another one reads the published data, and stops the first. Under the thread sanitizer
// this also tests that they share no other data.
// Covers: resample/live_deformation.cpp.

#include <gtest/gtest.h>
#include <pliant/chainmail.h>
#include <pliant/resample.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <set>
#include <stop_token>
#include <thread>

#include "resample/lattices.h"

namespace pliant::test {
namespace {

struct Snapshot {
    Volume volume;
    std::uint64_t hash;  ///< expected by the owner
};

/// Copies of the deformed scan. Each stays unchanged while a reader uses it.
class Snapshots {
  public:
    void publish(Snapshot snapshot) {
        auto next = std::make_shared<const Snapshot>(std::move(snapshot));
        const std::lock_guard lock(m_mutex);
        m_latest = std::move(next);
        ++m_count;
        m_is_new.notify_all();
    }
    /// Waits for a copy newer than the given count, and updates the count.
    std::shared_ptr<const Snapshot> newer_than(int& count) {
        std::unique_lock lock(m_mutex);
        m_is_new.wait(lock, [&] { return m_count > count; });
        count = m_count;
        return m_latest;
    }

  private:
    std::mutex m_mutex;
    std::condition_variable m_is_new;
    std::shared_ptr<const Snapshot> m_latest;
    int m_count = 0;
};

Volume scan() {
    return make_volume({40, 40, 40}, {1, 1, 1},
                       [](Vec3d p) { return std::int16_t(std::lround(smooth_value(p))); });
}

/// The owner: a push, then slices until the tissue settles, repeated until a stop.
/// @returns number of slices
int own_and_relax(ChainMail& tissue, RelaxOptions slice, Snapshots& snapshots) {
    LiveDeformation live = LiveDeformation::create(tissue).value();
    int slices = 0;
    for (bool at_rest = true; !slice.stop.stop_requested(); ++slices) {
        if (at_rest) {
            EXPECT_TRUE(tissue.push({.point_mm = {20, 20, 20}, .push_mm = {3, 1, -2}}).ok());
        }
        const auto report = tissue.relax(slice);
        EXPECT_TRUE(report.ok());
        at_rest = report->settled;
        (void)live.update();
        snapshots.publish({live.volume(), hash_volume(deform_volume(tissue).value().volume)});
    }
    return slices;
}

TEST(BackgroundRelaxation, AReaderSeesWholeSnapshotsAndStopsTheOwner) {
    const Volume volume = scan();
    const TaskArena arena(2);
    ChainMail tissue = std::move(ChainMail::create(volume, {}, arena)).value();
    Snapshots snapshots;
    std::stop_source stop;
    int slices = 0;
    std::jthread owner([&] {
        slices = own_and_relax(
            tissue, {.max_sweeps = 1, .stop = stop.get_token(), .over_relaxation = 1}, snapshots);
    });
    // The owner continues while these are read.
    std::set<std::uint64_t> seen;
    std::vector<std::shared_ptr<const Snapshot>> kept;
    for (int count = 0; seen.size() < 6;) {
        kept.push_back(snapshots.newer_than(count));
        EXPECT_EQ(hash_volume(kept.back()->volume), kept.back()->hash);
        seen.insert(kept.back()->hash);
    }
    stop.request_stop();
    owner.join();
    EXPECT_GE(slices, 6);
    for (const auto& snapshot : kept) EXPECT_EQ(hash_volume(snapshot->volume), snapshot->hash);
    EXPECT_LE(tissue.state().max_violation_mm, 1e-9);
    EXPECT_EQ(tissue.state().folded_cells, 0);
}

}  // namespace
}  // namespace pliant::test
