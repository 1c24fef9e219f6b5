// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue's state of numbers (tissue/node_tissue.cpp), some of which are replaced by others; with
// the right checksum, so that the fuzzer gets past it.

#pragma once

#include <fstream>
#include <iterator>

#include <pliant/own_tissue.h>
#include "base/hash.h"
#include "fuzz/fuzz.h"

namespace pliant::fuzz {

inline std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// @param edits  ten bytes each: index of the number, and its eight bytes; excess bytes are ignored
inline std::string with_numbers(std::string state, std::string_view edits) {
    constexpr std::size_t kBefore = 24 + 16, kEdit = 10;  // the frame, kind and count
    const std::size_t count = (state.size() - kBefore) / 8 - 1;
    for (; edits.size() >= kEdit; edits.remove_prefix(kEdit)) {
        const std::size_t number = std::uint8_t(edits[0]) | std::size_t(std::uint8_t(edits[1]))
                                                                << 8;
        edits.copy(state.data() + kBefore + 8 * (number % count), 8, 2);
    }
    Hash64 hash;
    const auto word_at = [&](std::size_t at) {
        std::uint64_t word = 0;
        for (std::size_t k = 0; k < 8; ++k)
            word |= std::uint64_t(std::uint8_t(state[at + k])) << 8 * k;
        return word;
    };
    for (std::size_t at = 0; at + 8 < state.size(); at += 8) hash.add_word(word_at(at));
    for (std::size_t k = 0; k < 8; ++k)
        state[state.size() - 8 + k] = char(hash.value() >> 8 * k & 0xff);
    return state;
}

/// Loads it; it is refused in one line, or is the same when saved and loaded again, and goes on.
/// @param good  a state of this tissue
inline void try_state(Tissue& tissue, const std::string& good, std::string_view edits) {
    const std::uint64_t before = tissue.hash();
    const Status status = tissue.load_state(write_anew("a.state", with_numbers(good, edits)));
    if (!status.ok()) {
        expect(tissue.hash() == before, "nothing changed by what is refused");
        return expect_one_line(status.error().message);
    }
    const std::uint64_t hash = tissue.hash();
    const auto file = folder() / "b.state";
    expect(tissue.save_state(file).ok(), "a state that can be saved");
    const Status again = tissue.load_state(file);
    expect(again.ok(), "its own state can be loaded", again.ok() ? "" : again.error().message);
    expect(tissue.hash() == hash, "the same state again");
    for (int n = 0; n < 3; ++n) (void)tissue.sweep();
    expect(tissue.save_state(file).ok(), "a state that can be saved after some steps");
    const Status later = tissue.load_state(file);
    expect(later.ok(), "where it came to can be loaded", later.ok() ? "" : later.error().message);
}

}  // namespace pliant::fuzz
