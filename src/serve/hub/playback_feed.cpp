// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "hub/playback_feed.h"

#include <algorithm>
#include <utility>

#include "base/errors.h"
#include "protocol/limits.h"
#include "session/checkpoint.h"
#include "session/replay.h"

namespace pliant::serve {
namespace {

constexpr double kLongestTick_ms = 1000;  ///< of wall-clock time, after a pause of the process
constexpr double kToolTime_ms = 1000;     ///< a tool is shown so long after its last command
constexpr std::size_t kRewindPiece = 16;  ///< records between two looks for a stop
constexpr auto kNewsPause = std::chrono::milliseconds(250);  ///< while it plays

Vec3f in_floats(Vec3d v) {
    return {float(v.x), float(v.y), float(v.z)};
}

}  // namespace

void PlaybackFeed::load(SessionFile file, const TaskArena& arena) {
    m_file = std::move(file);
    m_arena = &arena;
    m_times = times_of(records());
    m_marks = replay_marks_text(marks_of(records(), m_times));
}

std::span<const SessionRecord> PlaybackFeed::records() const {
    return std::span(m_file.records).subspan(m_file.scene_records);
}

std::uint32_t PlaybackFeed::last_client() const {
    std::uint32_t last = 0;
    for (const SessionRecord& record : m_file.records)
        if (const auto* command = std::get_if<SessionCommand>(&record))
            last = std::max(last, command->client);
    return last;
}

/// Records that are carried out at a time.
std::size_t PlaybackFeed::records_until(double at_ms) const {
    if (at_ms >= m_times.back()) return records().size();
    return std::size_t(std::lower_bound(m_times.begin(), m_times.end() - 1, at_ms) -
                       m_times.begin());
}

bool PlaybackFeed::take(Client& client, const Message& message) {
    const auto* wish = std::get_if<ReplayMessage>(&message.action);
    if (!wish) return false;
    const auto refuse = [&](const char* code, const char* why) {
        m_host.refuse(client, message.id, "replay", code, why);
        return true;
    };
    if (!is_on()) return refuse("nothing", "expected a session that is watched, found a live one");
    if (client.info.view) return refuse("view_only", "expected the role control, found view");
    if (wish->speed) m_speed = *wish->speed;
    if (wish->at_ms) jump(std::min(*wish->at_ms, m_times.back()));
    if (wish->is_playing) {
        if (*wish->is_playing && m_at_ms >= m_times.back()) jump(0);  // from the start again
        m_is_playing = *wish->is_playing && m_failure.empty();
    }
    refresh();  // tells the client that the scene is not that of the time yet
    m_host.accept(client, message.id, "replay");
    return true;
}

void PlaybackFeed::jump(double at_ms) {
    m_at_ms = at_ms;
    m_is_jumping = true;
    m_tools.clear();
}

void PlaybackFeed::act() {
    if (!is_on()) return;
    const double passed_ms = m_acted_at == Clock::time_point{}
                                 ? 0
                                 : std::min(ms_between(m_acted_at, m_host.now()), kLongestTick_ms);
    m_acted_at = m_host.now();
    finish_rewinding();
    if (m_rewinding || !m_failure.empty()) return;
    if (m_is_playing && !m_is_jumping)
        m_at_ms = std::min(m_at_ms + m_speed * passed_ms, m_times.back());
    const std::size_t until = records_until(m_at_ms);
    if (until < m_next) return rewind(until);
    const Clock::time_point begin = Clock::now();
    while (m_next < until && m_failure.empty() && Clock::now() - begin < kMotionTime)
        play_one(records()[m_next++]);
    if (m_next < until && !m_is_jumping) m_at_ms = m_times[m_next];  // a slow machine plays slower
    if (m_next == until) m_is_jumping = false;
    if (m_at_ms >= m_times.back() && !m_is_jumping) m_is_playing = false;
    std::erase_if(m_tools, [&](const auto& tool) {
        return m_at_ms - m_tool_times[tool.first] > kToolTime_ms;
    });
}

void PlaybackFeed::play_one(const SessionRecord& record) {
    const auto* command = std::get_if<SessionCommand>(&record);
    if (command) {
        const auto outcome = attempt(
            [&]() -> Result<Outcome> { return m_host.play(command->client, command->action); });
        if (!outcome.ok()) return fail(outcome.error().message);
        if (outcome->ok() == command->refused)
            return fail("record " + std::to_string(m_file.scene_records + m_next) +
                        ": expected a command that is " +
                        (command->refused ? "refused" : "carried out") +
                        ", found the opposite: " + outcome->message);
        return show_tool(*command);
    }
    const auto* sweeps = std::get_if<SessionSweeps>(&record);
    const auto* state = std::get_if<SessionState>(&record);
    const Status status = sweeps  ? m_host.play_sweeps(*sweeps)
                          : state ? m_host.play_state(*state)
                                  : replay_into(m_host.scene(), {&record, 1}, Compare::Nothing);
    if (!status.ok()) fail(status.error().message);
}

/// A session has no poses of tools, but commands say where they acted.
void PlaybackFeed::show_tool(const SessionCommand& command) {
    ToolPose pose{.client = command.client, .kind = ToolKind::Sphere, .touches = true};
    const auto before = m_tools.find(command.client);
    if (const auto* push = std::get_if<PushCommand>(&command.action)) {
        pose.position_mm = in_floats(push->push.point_mm + push->push.push_mm);
        pose.radius_mm = float(push->push.sphere_radius_mm);
        const double length = norm(push->push.push_mm);
        if (length > 0)
            pose.direction = in_floats((1 / length) * push->push.push_mm);
        else if (before != m_tools.end())
            pose.direction = before->second.direction;
    } else if (const auto* grab = std::get_if<GrabCommand>(&command.action)) {
        pose.position_mm = in_floats(grab->position.point_mm);
        pose.radius_mm = float(grab->position.sphere_radius_mm);
        m_grabbed_mm = grab->position.point_mm;
    } else if (const auto* drag = std::get_if<DragCommand>(&command.action)) {
        if (before == m_tools.end()) return;
        pose = before->second;
        pose.position_mm = in_floats(m_grabbed_mm + drag->offset_mm);
    } else if (const auto* carve = std::get_if<CarveCommand>(&command.action)) {
        pose.position_mm = in_floats(carve->tool.to_mm);
        pose.radius_mm = float(carve->tool.radius_mm);
    } else {
        const bool ends = std::holds_alternative<LetGoCommand>(command.action) ||
                          std::holds_alternative<ReleaseCommand>(command.action) ||
                          std::holds_alternative<ResetCommand>(command.action);
        if (ends) m_tools.erase(command.client);
        return;
    }
    m_tools[command.client] = pose;
    m_tool_times[command.client] = m_at_ms;
}

void PlaybackFeed::rewind(std::size_t to) {
    const auto replay = [this, to](const std::stop_token& stop) -> Result<std::unique_ptr<Scene>> {
        auto scene = open_recorded(m_file.scene, *m_arena);
        for (std::size_t n = 0; scene.ok() && n < to; n += kRewindPiece) {
            if (stop.stop_requested()) return out_of_memory();
            const auto piece = records().subspan(n, std::min(kRewindPiece, to - n));
            const Status s =
                replay_into(**scene, piece, Compare::Nothing, {}, m_file.scene_records + n);
            if (!s.ok()) return s.error();
        }
        return scene;
    };
    m_rewinding =
        std::unique_ptr<Rewinding>(new Rewinding{to, Background<std::unique_ptr<Scene>>(replay)});
}

void PlaybackFeed::finish_rewinding() {
    if (!m_rewinding || !m_rewinding->scene.is_done()) return;
    const auto rewinding = std::move(m_rewinding);
    Result<std::unique_ptr<Scene>>& scene = rewinding->scene.result();
    if (!scene.ok()) return fail(scene.error().message);
    m_next = rewinding->to;
    m_cleaner = std::jthread([old = m_host.exchange(std::move(*scene))] {});
}

void PlaybackFeed::fail(const std::string& message) {
    m_failure = message;
    m_is_playing = m_is_jumping = false;
}

std::string PlaybackFeed::news_text() const {
    return replay_text({.at_ms = m_at_ms,
                        .length_ms = m_times.back(),
                        .speed = m_speed,
                        .is_playing = m_is_playing,
                        .is_seeking = m_is_jumping || m_rewinding != nullptr,
                        .failure = m_failure});
}

/// Tells each client the marks once, and the present time when it changes.
void PlaybackFeed::refresh() {
    if (!is_on()) return;
    const bool is_quiet = m_is_playing && !m_is_jumping && m_host.now() - m_told_at < kNewsPause;
    std::string news = news_text();
    if (!is_quiet && news != m_news) {
        m_news = std::move(news);
        m_told_at = m_host.now();
    }
    for (Client& client : m_host.clients()) {
        if (!client.connection) continue;
        const auto [told, is_new] = m_told.try_emplace(client.info.number);
        if (is_new) m_host.send(client, m_marks);
        if (told->second == m_news) continue;
        m_host.send(client, m_news);
        told->second = m_news;
    }
}

}  // namespace pliant::serve
