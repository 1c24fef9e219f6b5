// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Hashes of a thousand random sequences of operations, recorded on x86-64: every machine has the
// same (docs/developers/robustness.md, Other machines).
// Covers: base/byte_order.h, base/hash.h.

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "base/hash.h"
#include "support/random_operations.h"

namespace pliant::test {
namespace {

constexpr int kSequences = 1000, kPerHash = 100;

/// Hashes of a hundred sequences each, on x86-64.
constexpr std::array<std::uint64_t, kSequences / kPerHash> kRecorded = {
    0xaeca328ce03d7457, 0x86be136f467686be, 0x5db2f73a2f689ade, 0xa930f9828ab46d5c,
    0x9fbba009afa1f4ba, 0x394df9dc44383271, 0x4bb30127ff004e8e, 0x3f2f61b89643f4b4,
    0x3b89a54aee790070, 0xac4b25d8385d197f};

TEST(Sequences, HaveTheRecordedHashes) {
#if defined(__x86_64__)
    if (!__builtin_cpu_supports("fma"))
        GTEST_SKIP() << "the C library's sin, exp and pow have other bits without FMA";
#endif
    Hash64 total;
    for (int first = 0; first < kSequences; first += kPerHash) {
        Hash64 hash;
        for (int n = first; n < first + kPerHash; ++n)
            for (const OperationHash& done : run_random_operations(std::uint64_t(n)))
                hash.add_word(done.hash);
        std::printf("sequences %3d to %3d: %016llx\n", first, first + kPerHash - 1,
                    static_cast<unsigned long long>(hash.value()));
        std::fflush(stdout);
        EXPECT_EQ(hash.value(), kRecorded[std::size_t(first / kPerHash)]);
        total.add_word(hash.value());
    }
    std::printf("all sequences:        %016llx\n", static_cast<unsigned long long>(total.value()));
}

}  // namespace
}  // namespace pliant::test
