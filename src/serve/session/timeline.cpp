// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/timeline.h"

#include <algorithm>

namespace pliant::serve {
namespace {

/// A command that continues the previous one of its client, such as a push of the same stroke.
bool goes_on(const SessionCommand& command, const SessionCommand* before) {
    if (!before || before->client != command.client) return false;
    if (std::holds_alternative<DragCommand>(command.action) ||
        std::holds_alternative<LetGoCommand>(command.action))
        return true;
    const auto* push = std::get_if<PushCommand>(&command.action);
    const auto* last = std::get_if<PushCommand>(&before->action);
    if (push && last) return push->stroke != 0 && push->stroke == last->stroke;
    return command.action.index() == before->action.index() &&
           (std::holds_alternative<IsoCommand>(command.action) ||
            std::holds_alternative<DriveCommand>(command.action) ||
            std::holds_alternative<EyeCommand>(command.action));
}

}  // namespace

std::vector<double> times_of(std::span<const SessionRecord> records) {
    std::vector<double> times;
    times.reserve(records.size() + 1);
    const bool is_timed = std::any_of(records.begin(), records.end(), [](const auto& record) {
        return std::holds_alternative<SessionWait>(record);
    });
    double now = 0;
    for (std::size_t begin = 0; begin < records.size();) {
        if (!is_timed) {
            times.push_back(now);
            now += kUntimed_ms;
            ++begin;
            continue;
        }
        std::size_t end = begin;
        while (end < records.size() && !std::holds_alternative<SessionWait>(records[end])) ++end;
        const double wait =
            end < records.size() ? double(std::get_if<SessionWait>(&records[end])->ms) : kSpread_ms;
        const double spread = std::min(wait, kSpread_ms);
        for (std::size_t n = begin; n < end; ++n)
            times.push_back(now + spread * double(n - begin) / double(end - begin));
        now += wait;
        if (end < records.size()) times.push_back(now);  // of the wait itself
        begin = end + 1;
    }
    times.push_back(now);
    return times;
}

std::vector<TimelineMark> marks_of(std::span<const SessionRecord> records,
                                   std::span<const double> times) {
    std::vector<TimelineMark> marks;
    const SessionCommand* before = nullptr;
    for (std::size_t n = 0; n < records.size(); ++n) {
        const auto* command = std::get_if<SessionCommand>(&records[n]);
        if (!command || command->refused) continue;
        const bool is_seen = !std::holds_alternative<EyeCommand>(command->action) &&
                             !std::holds_alternative<ReleaseCommand>(command->action) &&
                             !std::holds_alternative<LetGoCommand>(command->action);
        if (is_seen && !goes_on(*command, before))
            marks.push_back({times[n], command->client, std::string(name_of(command->action))});
        before = command;
    }
    return marks;
}

}  // namespace pliant::serve
