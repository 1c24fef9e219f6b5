// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A saved state. Its length and checksum are corrected first, so that the fuzzer gets past them. A
// loaded state is valid: it is saved identically, and every link is within its limits.

#include <pliant/chainmail.h>
#include <pliant/volume.h>

#include "base/hash.h"
#include "fuzz/fuzz.h"
#include "material/settings.h"

using namespace pliant;

namespace {

void put_u64(std::string& bytes, std::size_t at, std::uint64_t value) {
    for (std::size_t k = 0; k < 8; ++k) bytes[at + k] = char(value >> 8 * k & 0xff);
}

std::string put_right(std::string bytes) {
    constexpr std::size_t kLengthAt = 16, kShortest = 32;
    if (bytes.size() < kShortest) return bytes;
    put_u64(bytes, kLengthAt, bytes.size());
    Hash64 hash;
    const std::size_t length = bytes.size() - 8;
    for (std::size_t at = 0; at < length; at += 8) {
        std::uint64_t word = 0;
        for (std::size_t k = 0; k < 8 && at + k < length; ++k)
            word |= std::uint64_t(std::uint8_t(bytes[at + k])) << 8 * k;
        hash.add_word(word);
    }
    put_u64(bytes, length, hash.value());
    return bytes;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const TaskArena arena(1);
    static const auto phantom = make_phantom({.name = "cube", .size = {16, 16, 16}}, arena);
    const std::string_view given = fuzz::text_of(data, size);
    ChainMailSettings settings;
    settings.max_elements = 1 << 16;
    auto tissue = ChainMail::create(phantom->volume, settings, arena);
    fuzz::expect(tissue.ok(), "a lattice");
    for (const std::string& bytes : {std::string(given), put_right(std::string(given))}) {
        const Status status = tissue->load_state(fuzz::write_anew("a.plst", bytes));
        if (!status.ok()) {
            fuzz::expect_one_line(status.error().message);
            continue;
        }
        const std::uint64_t hash = tissue->hash();
        const auto file = fuzz::folder() / "b.plst";
        fuzz::expect(tissue->save_state(file).ok(), "a state that can be saved");
        const Status again = tissue->load_state(file);
        fuzz::expect(again.ok(), "its own state can be loaded",
                     again.ok() ? "" : again.error().message);
        fuzz::expect(tissue->hash() == hash, "the same state again");
    }
    return 0;
}
