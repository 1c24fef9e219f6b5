// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/memory_budget.h"
#include "support/temporary_folder.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace pliant {
namespace {

constexpr std::uint64_t kMb = 1 << 20;

/// A machine with 1 GiB, as its kernel would describe it.
class MemoryBudget : public testing::Test {
  protected:
    void SetUp() override {
        m_folder.write(
            "proc/meminfo",
            "MemTotal:        9999999 kB\nMemFree:  1 kB\nMemAvailable:    1048576 kB\n");
    }
    std::uint64_t available() const { return available_memory({m_folder.path(), m_limit}); }

    test::TemporaryFolder m_folder;
    std::uint64_t m_limit = kUnlimited;
};

TEST_F(MemoryBudget, IsWhatTheMachineHas) {
    EXPECT_EQ(available(), 1024 * kMb);
}

TEST_F(MemoryBudget, IsAGroupsShareInContainers) {
    // The path is the host's, and isn't there: the container's own group is at the top.
    m_folder.write("proc/self/cgroup", "0::/docker/4711\n");
    m_folder.write("sys/fs/cgroup/memory.max", "536870912\n");
    m_folder.write("sys/fs/cgroup/memory.current", "104857600\n");
    EXPECT_EQ(available(), 412 * kMb);
    m_folder.write("sys/fs/cgroup/memory.stat", "anon 1\nfile 2\ninactive_file 52428800\n");
    EXPECT_EQ(available(), 462 * kMb);
}

TEST_F(MemoryBudget, IsTheLeastOfAllGroupsAbove) {
    m_folder.write("proc/self/cgroup", "0::/a/b\n");
    m_folder.write("sys/fs/cgroup/a/b/memory.max", "max\n");
    m_folder.write("sys/fs/cgroup/a/b/memory.current", "1048576\n");
    m_folder.write("sys/fs/cgroup/a/memory.max", "10485760\n");
    m_folder.write("sys/fs/cgroup/a/memory.current", "2097152\n");
    EXPECT_EQ(available(), 8 * kMb);
    m_folder.write("sys/fs/cgroup/a/memory.current", "99999999999\n");  // beyond its limit
    EXPECT_EQ(available(), 0u);
}

TEST_F(MemoryBudget, KnowsTheFirstVersionOfGroups) {
    m_folder.write("proc/self/cgroup", "5:cpu,cpuacct:/x\n4:memory:/x\n1:name=systemd:/x\n");
    m_folder.write("sys/fs/cgroup/memory/x/memory.limit_in_bytes", "20971520\n");
    m_folder.write("sys/fs/cgroup/memory/x/memory.usage_in_bytes", "4194304\n");
    m_folder.write("sys/fs/cgroup/memory/x/memory.stat", "total_inactive_file 1048576\n");
    m_folder.write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
    m_folder.write("sys/fs/cgroup/memory/memory.usage_in_bytes", "4194304\n");
    EXPECT_EQ(available(), 17 * kMb);
}

TEST_F(MemoryBudget, IsTheRestOfTheAddressSpace) {
    m_limit = 100 * kMb;
    m_folder.write("proc/self/statm",
                   std::to_string(30 * kMb / std::uint64_t(getpagesize())) + " 5\n");
    EXPECT_EQ(available(), 70 * kMb);
    m_limit = 20 * kMb;
    EXPECT_EQ(available(), 0u);
}

TEST_F(MemoryBudget, IsUnlimitedWhereNothingSaysSo) {
    const test::TemporaryFolder empty;
    EXPECT_EQ(available_memory({empty.path(), kUnlimited}), kUnlimited);
}

TEST(MemoryOfThisProcess, RefusesWhatNoMachineHas) {
    EXPECT_TRUE(has_memory_for(0));
    EXPECT_TRUE(has_memory_for(1 << 20));
    EXPECT_FALSE(has_memory_for(std::uint64_t(1) << 60));
}

}  // namespace
}  // namespace pliant
