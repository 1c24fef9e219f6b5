// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "session/checkpoint.h"

#include <algorithm>
#include <optional>
#include <span>

#include "base/errors.h"
#include "base/input_file.h"
#include "protocol/messages.h"
#include "session/replay.h"

namespace pliant::serve {
namespace {

constexpr int kChecksumBytes = 8;

Status restore(Scene& scene, const SessionCheckpoint& point, const std::filesystem::path& state) {
    const auto damaged = [](const std::string& what) -> Status {
        return Error{ErrorCode::Unreadable, what};
    };
    const auto checksum = checksum_of(state);
    if (!checksum) return checksum.error();
    if (*checksum != point.file)
        return damaged("expected the state " + hex_text(point.file, 16) + ", found " +
                       hex_text(*checksum, 16));
    if (const Status s = scene.restore(state, point.memo); !s.ok()) return s;
    if (scene.tissue().hash() != point.mark.tissue)
        return damaged("expected the tissue " + hex_text(point.mark.tissue, 16) + ", found " +
                       hex_text(scene.tissue().hash(), 16));
    return Ok{};
}

}  // namespace

Result<std::uint64_t> checksum_of(const std::filesystem::path& state) {
    InputFile file(state);
    file.seek(file.size() - std::min<std::uint64_t>(file.size(), kChecksumBytes));
    std::uint64_t checksum = 0;
    for (int k = 0; k < kChecksumBytes; ++k) {
        const int byte = file.get();
        if (byte == InputFile::kEnd) return file.fault("ends early, expected a saved state");
        checksum |= std::uint64_t(byte) << 8 * k;
    }
    return checksum;
}

std::filesystem::path checkpoint_path(const std::filesystem::path& session, int number) {
    std::filesystem::path path = session;
    path += number % 2 ? ".checkpoint1" : ".checkpoint2";
    return path;
}

Result<SessionCheckpoint> save_checkpoint(Scene& scene, const std::filesystem::path& session,
                                          int number, Status& saved) {
    // The rest of the scene must be recorded even if the checkpoint fails.
    return attempt([&]() -> Result<SessionCheckpoint> {
        const auto state = checkpoint_path(session, number);
        const std::uint64_t volume = hash_volume(scene.deformed());
        const Result<SceneMemo> memo = scene.rest();
        if (!memo.ok()) return memo.error();
        SessionCheckpoint point{.number = number, .file = 0, .mark = {}, .memo = *memo};
        point.mark = {volume, scene.tissue().hash()};
        saved = attempt([&]() -> Status {
            if (const Status s = scene.tissue().save_state(state); !s.ok()) return s;
            const auto checksum = checksum_of(state);
            if (!checksum.ok()) return checksum.error();
            point.file = *checksum;
            return Ok{};
        });
        return point;
    });
}

Result<std::unique_ptr<Scene>> open_recorded(const SessionHeader& header, const TaskArena& arena) {
    auto scene = Scene::open(header.source, arena);
    if (scene.ok() && (*scene)->scan_hash() != header.scan_hash)
        return Error{ErrorCode::InvalidArgument,
                     "expected the scan " + hex_text(header.scan_hash, 16) +
                         ", found another one: " + (*scene)->info().name};
    return scene;
}

Result<Reopened> reopen(const SessionFile& file, const std::filesystem::path& session,
                        const TaskArena& arena) {
    std::vector<std::size_t> points;
    for (std::size_t n = file.scene_records; n < file.records.size(); ++n)
        if (std::holds_alternative<SessionCheckpoint>(file.records[n])) points.push_back(n);
    Reopened reopened;
    const std::span records(file.records);
    // With only one checkpoint, the session is still short.
    if (points.size() >= 2)
        for (const std::size_t at : {points[points.size() - 2], points.back()}) {
            const auto& point = *std::get_if<SessionCheckpoint>(&records[at]);
            auto scene = open_recorded(file.scene, arena);
            if (!scene.ok()) return scene.error();
            Status status = restore(**scene, point, checkpoint_path(session, point.number));
            if (status.ok())
                status = replay_into(**scene, records.subspan(at + 1), Compare::Tissue, {}, at + 1);
            if (status.ok()) {
                reopened.scene = std::move(*scene);
                reopened.number = point.number;
                reopened.forgot = point.memo.steps;
                return reopened;
            }
            reopened.notes.push_back("checkpoint " + std::to_string(point.number) +
                                     " is of no use: " + status.error().message);
        }
    auto scene = open_recorded(file.scene, arena);
    if (!scene.ok()) return scene.error();
    const std::size_t first = file.scene_records;
    const Status s = replay_into(**scene, records.subspan(first), Compare::Nothing, {}, first);
    if (!s.ok()) return s.error();
    reopened.scene = std::move(*scene);
    return reopened;
}

}  // namespace pliant::serve
