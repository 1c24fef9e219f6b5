// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/output_file.h>
#include <pliant/own_tissue.h>

#include "base/errors.h"
#include "base/state_frame.h"

namespace pliant {
namespace {

// A tissue's state in a file: the frame of core/state_frame.h with its kind, the count of numbers,
// and the numbers. A session records the frame's checksum.

/// Writes the file atomically. @param kind  of tissue
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
    OutputFile file(*staged, path.filename().string());
    file.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (const Status s = file.close(); !s.ok()) return s;
    return files.commit();
}

/// @returns Unreadable for a file of another kind, or one that is damaged or cut short
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

// Limits of the history; a state of 12,000 nodes takes 0.6 MB.
constexpr std::size_t kMaxSteps = 200, kMaxBytes = 256'000'000;

}  // namespace

void NodeTissue::begin_group(const std::string&) {
    State now;
    state(now);
    m_now.resize(now.size());
    if (m_before.empty()) m_before.emplace_back();
    m_before.front().swap(now);
}

int NodeTissue::end_group() noexcept {
    if (m_before.empty()) return 0;
    const Status compared = attempt([&]() -> Status {
        state(m_now);
        return Ok{};
    });
    if (compared.ok() && m_before.front() == m_now) {
        m_before.clear();
        return 0;
    }
    m_undone.clear();
    m_done.splice(m_done.end(), m_before);
    int forgotten = 0;
    const std::size_t bytes = m_done.back().size() * sizeof(double);
    while (m_done.size() > kMaxSteps || m_done.size() * bytes > kMaxBytes) {
        m_done.pop_front();
        ++forgotten;
    }
    // Without memory for the comparison, a step that may be empty can't be kept.
    if (!compared.ok()) m_done.clear();
    return m_done.empty() ? -1 : forgotten;
}

/// Takes the last of some steps. @param to  steps in the other direction
Status NodeTissue::go_back(std::list<State>& from, std::list<State>& to) noexcept {
    return attempt([&]() -> Status {
        State now;
        state(now);
        if (const Status s = set_state(from.back()); !s.ok()) return s;
        from.back().swap(now);
        to.splice(to.end(), from, std::prev(from.end()));
        return Ok{};
    });
}

Status NodeTissue::undo() noexcept {
    if (m_done.empty()) return Error{ErrorCode::NotFound, "undo: expected a step, found none"};
    return go_back(m_done, m_undone);
}

Status NodeTissue::redo() noexcept {
    if (m_undone.empty()) return Error{ErrorCode::NotFound, "redo: expected a step, found none"};
    return go_back(m_undone, m_done);
}

Status NodeTissue::rest() noexcept {
    return attempt([&]() -> Status {
        State now;
        state(now);
        return set_state(now);
    });
}

Status NodeTissue::save_state(const std::string& path) const noexcept {
    return attempt([&]() -> Status {
        State now;
        state(now);
        return save_numbers(path, file_kind(), now);
    });
}

Status NodeTissue::load_state(const std::string& path) noexcept {
    return attempt([&]() -> Status {
        const auto numbers = load_numbers(path, file_kind());
        if (!numbers.ok()) return numbers.error();
        if (const Status s = set_state(*numbers); !s.ok())
            return is_out_of_memory(s.error())
                       ? s.error()
                       : unreadable(std::filesystem::path(path).filename(), s.error().message);
        m_done.clear();
        m_undone.clear();
        return Ok{};
    });
}

std::uint64_t NodeTissue::hash() const {
    (void)update_deformation();
    return deformation().hash();
}

}  // namespace pliant
