// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// random_operations FIRST COUNT: the random sequences of COUNT seeds from FIRST on, each on all
// instruction sets of this machine that the library was compiled for. Prints a line for each of
// them with the hash of all sequences; a difference ends the run with status 1, the seed and the
// operation. The lines of two machines with the same compiler and C library are the same too.

#include <charconv>
#include <cstdio>
#include <cstring>
#include <optional>

#include "base/hash.h"
#include "support/random_operations.h"

namespace {

std::optional<std::uint64_t> number_of(const char* text) {
    std::uint64_t number = 0;
    const char* end = text + std::strlen(text);
    const auto [stop, error] = std::from_chars(text, end, number);
    if (error != std::errc{} || stop != end) return {};
    return number;
}

}  // namespace

int main(int count, char** arguments) {
    using namespace pliant;
    using namespace pliant::test;
    const auto first = count == 3 ? number_of(arguments[1]) : std::nullopt;
    const auto sequences = count == 3 ? number_of(arguments[2]) : std::nullopt;
    if (!first || !sequences) {
        std::fputs("random_operations: expected FIRST COUNT\n", stderr);
        return 2;
    }
    const auto targets = own_targets();
    std::vector<Hash64> hashes(targets.size());
    std::uint64_t operations = 0;
    for (std::uint64_t seed = *first; seed < *first + *sequences; ++seed) {
        std::vector<OperationHash> expected;
        for (std::size_t n = 0; n < targets.size(); ++n) {
            const OnTarget target(targets[n]);
            const auto found = run_random_operations(seed);
            if (n == 0) expected = found;
            for (std::size_t k = 0; k < found.size(); ++k) {
                hashes[n].add_word(found[k].hash);
                if (found[k] == expected[k]) continue;
                std::printf("seed %llu: %s and %s differ after operation %zu, %s\n",
                            static_cast<unsigned long long>(seed),
                            name_of_target(targets[0]).c_str(), name_of_target(targets[n]).c_str(),
                            k, found[k].name.data());
                return 1;
            }
            if (n == 0) operations += found.size();
        }
    }
    for (std::size_t n = 0; n < targets.size(); ++n)
        std::printf(
            "%-8s %016llx  %llu sequences from seed %llu, %llu operations\n",
            name_of_target(targets[n]).c_str(), static_cast<unsigned long long>(hashes[n].value()),
            static_cast<unsigned long long>(*sequences), static_cast<unsigned long long>(*first),
            static_cast<unsigned long long>(operations));
}
