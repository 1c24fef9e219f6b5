// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "base/memory_budget.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

#include "base/input_file.h"

namespace pliant {
namespace fs = std::filesystem;
namespace {

/// Smaller requests are not checked [bytes].
constexpr std::uint64_t kSmall = 1 << 22;

std::atomic<const MemorySources*> g_other_sources = nullptr;

/// Text of a file of the kernel's; empty if it can't be read, so that its limit is unknown.
std::istringstream kernel_file(const fs::path& file) {
    auto text = InputFile(file).read_rest();
    return std::istringstream(text ? std::move(*text) : std::string());
}

std::optional<std::uint64_t> number_in(const fs::path& file) {
    std::istringstream stream = kernel_file(file);
    std::string word;
    std::uint64_t number = 0;
    if (!(stream >> word)) return std::nullopt;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;  // "max"
    return number;
}

/// Reads the number after a word.
std::optional<std::uint64_t> number_behind(const fs::path& file, std::string_view name) {
    std::istringstream stream = kernel_file(file);
    std::string word;
    std::uint64_t number = 0;
    while (stream >> word)
        if (word == name && stream >> number) return number;
    return std::nullopt;
}

struct GroupFiles {
    const char* limit;
    const char* usage;
    const char* files;  ///< in memory.stat: reclaimable page cache
};

/// Room under the limits of a group and its ancestors.
std::uint64_t room_in(const fs::path& hierarchy, fs::path group, const GroupFiles& files) {
    std::uint64_t room = kUnlimited;
    for (group = group.relative_path();; group = group.parent_path()) {
        const fs::path folder = hierarchy / group;
        const auto limit = number_in(folder / files.limit);
        const auto usage = number_in(folder / files.usage);
        if (limit && usage) {
            const auto can_go = number_behind(folder / "memory.stat", files.files).value_or(0);
            const std::uint64_t used = *usage - std::min(*usage, can_go);
            room = std::min(room, *limit - std::min(*limit, used));
        }
        if (group.empty()) return room;
    }
}

std::uint64_t room_in_groups(const fs::path& root) {
    constexpr GroupFiles kSecond{"memory.max", "memory.current", "inactive_file"};
    constexpr GroupFiles kFirst{"memory.limit_in_bytes", "memory.usage_in_bytes",
                                "total_inactive_file"};
    const fs::path groups = root / "sys/fs/cgroup";
    std::uint64_t room = kUnlimited;
    std::istringstream stream = kernel_file(root / "proc/self/cgroup");
    // Entries are "0::/path" in version 2, "4:memory:/path" or "4:cpu,memory:/path" in version 1.
    // In a container the path may be the host's: it then doesn't exist, but its ancestors do.
    for (std::string line; std::getline(stream, line);) {
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (second == line.npos) continue;
        const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
        const fs::path group = line.substr(second + 1);
        if (controllers == ",,")
            room = std::min({room, room_in(groups, group, kSecond),
                             room_in(groups / "unified", group, kSecond)});
        else if (controllers.find(",memory,") != controllers.npos)
            room = std::min(room, room_in(groups / "memory", group, kFirst));
    }
    return room;
}

std::uint64_t room_in_address_space(const MemorySources& sources) {
    if (sources.address_space_limit == kUnlimited) return kUnlimited;
    const auto pages = number_in(sources.root / "proc/self/statm");
    const std::uint64_t used = pages.value_or(0) * std::uint64_t(sysconf(_SC_PAGESIZE));
    return sources.address_space_limit - std::min(sources.address_space_limit, used);
}

}  // namespace

MemorySources MemorySources::of_this_process() {
    MemorySources sources;
    if (rlimit limit{}; getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
        sources.address_space_limit = limit.rlim_cur;
    return sources;
}

std::uint64_t available_memory(const MemorySources& sources) {
    std::uint64_t room = std::min(room_in_address_space(sources), room_in_groups(sources.root));
    if (const auto kib = number_behind(sources.root / "proc/meminfo", "MemAvailable:"))
        room = std::min(room, *kib * 1024);
    return room;
}

bool has_memory_for(std::uint64_t bytes) {
    if (bytes <= kSmall) return true;
    const MemorySources* const other = g_other_sources;
    return bytes <= available_memory(other ? *other : MemorySources::of_this_process());
}

UseMemorySources::UseMemorySources(const MemorySources& sources) {
    g_other_sources = &sources;
}
UseMemorySources::~UseMemorySources() {
    g_other_sources = nullptr;
}

}  // namespace pliant
