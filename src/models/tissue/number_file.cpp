// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/number_file.h"

#include <pliant/core/files.h>

#include <fstream>

#include "base/errors.h"
#include "base/state_frame.h"

namespace pliant {

Status save_numbers(const std::filesystem::path& path, std::uint64_t kind,
                    std::span<const double> numbers) {
    StateWriter state(kStateOfNumbers);
    state.put_u64(kind);
    state.put_u64(numbers.size());
    for (const double number : numbers) state.put_double(number);
    const Bytes bytes = state.finish();
    StagedFiles files;
    const auto staged = files.stage(path);
    if (!staged.ok()) return staged.error();
    std::ofstream stream(*staged, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    stream.close();
    if (!stream)
        return Error{ErrorCode::Unwritable, path.filename().string() + ": can't be written"};
    return files.commit();
}

Result<std::vector<double>> load_numbers(const std::filesystem::path& path, std::uint64_t kind) {
    const auto bytes = read_small_file(path, std::string::npos, "a saved state");
    if (!bytes) return bytes.error();
    auto state = StateParser::open(path.filename().string(), std::as_bytes(std::span(*bytes)),
                                   kStateOfNumbers);
    if (!state.ok()) return state.error();
    std::uint64_t found = 0, count = 0;
    if (!state->take_u64(found) || !state->take_u64(count)) return state->damaged();
    if (found != kind)
        return unreadable(path.filename(),
                          "expected a state of this tissue, found that of another");
    if (state->left() % 8 != 0 || count != state->left() / 8) return state->damaged();
    std::vector<double> numbers(count);
    for (double& number : numbers)
        if (!state->take_double(number)) return state->damaged();
    return numbers;
}

}  // namespace pliant
