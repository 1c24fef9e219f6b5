// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Random things done to a scene, and recorded as the server does.

#pragma once

#include <gtest/gtest.h>

#include "session/scene.h"
#include "session/session_log.h"
#include "support/random.h"

namespace pliant::serve {

using test::Random;

inline const SceneSource kCube{.phantom = "cube", .phantom_size = {40, 40, 40}};

/// The cube's values would count as bone.
inline MaterialsCommand soft() {
    return {.values = {{"bone_threshold_hu", 3000.0}}};
}

inline std::unique_ptr<Scene> open_scene(const TaskArena& arena,
                                         const SceneSource& source = kCube) {
    auto scene = Scene::open(source, arena);
    EXPECT_TRUE(scene.ok());
    (*scene)->carry_out(9, soft());
    return std::move(*scene);
}

inline std::uint64_t hash_of(Scene& scene) {
    (void)scene.update();
    return hash_volume(scene.deformed()) ^ scene.tissue().hash();
}

inline Vec3d random_place(const Scene& scene, Random& random) {
    const Vec3i n = scene.info().grid.size;
    return world_from_voxel(
        scene.info().grid,
        {random.real(0.1, 0.9) * n.x, random.real(0.1, 0.9) * n.y, random.real(0.1, 0.9) * n.z});
}

inline Action random_action(const Scene& scene, Random& random) {
    const Vec3d at = random_place(scene, random);
    switch (random.whole(0, 15)) {
        case 0:
        case 1:
        case 2:
            return PushCommand{.push = {at, random.vector(4), random.real(1, 4)},
                               .stroke = std::uint32_t(random.whole(0, 2))};
        case 3:
            return PushCommand{.push = {at, random.vector(3), 2}, .slide = true, .stroke = 5};
        case 4:
            return GrabCommand{.position = {at, {0, 0, 0}, random.real(1, 4)}, .reach_mm = 10};
        case 5:
        case 6:
        case 7:
            return DragCommand{random.vector(6)};
        case 8:
            return LetGoCommand{};
        case 9:
            return CutCommand{{.line_mm = {at, at + random.vector(9), at + random.vector(9)},
                               .depth_mm = random.vector(9)}};
        case 10:
            return CarveCommand{.tool = {.from_mm = at, .to_mm = at, .radius_mm = 2},
                                .stroke = std::uint32_t(random.whole(0, 1))};
        case 11:
            return RelaxCommand{random.whole(0, 2) > 0};
        case 12:
            return ReleaseCommand{};
        case 13: {
            MaterialsCommand materials = soft();
            materials.values.emplace_back("offset", random.real(0.1, 0.4));
            materials.values.emplace_back("air_enabled", random.whole(0, 1) == 1);
            return materials;
        }
        case 14:
            return EyeCommand{at, random.whole(0, 3) ? random.real(0.1, 3) : 0};
        default:
            return IsoCommand{.iso_hu = random.real(-900, 900),
                              .stroke = std::uint32_t(random.whole(1, 2))};
    }
}

/// Does random things, and records them as the server does.
inline std::vector<SessionRecord> play(Scene& scene, Random& random, int count) {
    std::vector<SessionRecord> records = {SessionCommand{9, soft()}};
    for (int n = 0; n < count; ++n) {
        Action action = random_action(scene, random);
        if (random.whole(0, 5) == 0) action = UndoCommand{};
        if (random.whole(0, 8) == 0) action = RedoCommand{};
        const auto client = std::uint32_t(random.whole(1, 2));
        const Outcome outcome = scene.carry_out(client, action);
        records.push_back(SessionCommand{client, action, !outcome.ok()});
        SessionSweeps sweeps;
        for (; scene.wants_sweep() && sweeps.count < 3; ++sweeps.count) (void)scene.sweep();
        // A sweep that a command interrupts.
        if (scene.wants_sweep() && random.whole(0, 1)) {
            sweeps.parts = scene.sweep({.max_parts = random.whole(0, 9)}).value().parts;
            if (!sweeps.parts) ++sweeps.count;
        }
        if (sweeps.count || sweeps.parts) records.push_back(sweeps);
        if (n % 10 == 0) {
            (void)scene.update();
            records.push_back(SessionMark{hash_volume(scene.deformed()), scene.tissue().hash()});
        }
    }
    return records;
}

}  // namespace pliant::serve
