// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A tissue of one's own in everything that the library does with a tissue.
//
//   own_tissue            serves it in the page
//   own_tissue --needle   serves jelly with a needle, which is driven like a catheter
//   own_tissue --check    pushes, resamples, renders, feels, saves and takes back, and exits with 1
//                         where something is not as it must be

#include <pliant/check_tissue.h>
#include <pliant/render.h>
#include <pliant/resample.h>
#include <pliant/serve.h>
#include <pliant/volume.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "jelly.h"
#include "needle.h"

namespace {

int fail(const std::string& message) {
    std::fprintf(stderr, "own_tissue: %s\n", message.c_str());
    return 1;
}

int serve(const pliant::MakeTissue& tissue, const pliant::TaskArena& arena) {
    auto server = pliant::Server::start({.own_tissue = tissue}, arena);
    if (!server) return fail(server.error().message);
    std::puts(server->link().c_str());
    std::fflush(stdout);  // also where the output is a pipe
    server->wait();
    return 0;
}

int check(const pliant::TaskArena& arena) {
    const auto phantom = pliant::make_phantom({.name = "airway", .size = {64, 64, 64}}, arena);
    if (!phantom) return fail(phantom.error().message);
    auto made = example::Jelly::create(phantom->volume, arena);
    if (!made) return fail(made.error().message);
    pliant::Tissue& tissue = **made;
    const std::uint64_t at_rest = tissue.hash();

    // Pushed by a tool, and resampled: only boxes that changed are written.
    auto live = pliant::LiveDeformation::create(tissue);
    if (!live) return fail(live.error().message);
    const pliant::PhantomLandmark& carina = phantom->landmarks.front();
    tissue.begin_group("push");
    const pliant::Vec3d ahead = normalized(carina.push_mm);
    const auto pushed = tissue.push(1, {.point_mm = carina.push_point_mm, .push_mm = 4.0 * ahead});
    tissue.end_group();
    if (!pushed) return fail(pushed.error().message);
    const auto update = live->update();
    if (!update) return fail(update.error().message);
    std::printf("%lld voxels written\n", static_cast<long long>(update->written_voxels));
    if (update->written_voxels == 0) return fail("expected voxels to be written");
    const std::uint64_t deformed = tissue.hash();

    // Rendered: the wall in front of the tool has gone away from it.
    const pliant::Vec3d eye = carina.push_point_mm - 5.0 * ahead;
    const auto depth = [&](const pliant::Volume& shown) {
        const pliant::RayCaster rays(shown, arena);
        const auto hit = rays.first_hit(eye, ahead, -500, pliant::Polarity::Rising);
        return hit ? hit->distance_mm : 0;
    };
    std::printf("wall at %.2f mm, was at %.2f mm\n", depth(live->volume()), depth(phantom->volume));
    if (depth(live->volume()) < depth(phantom->volume) + 1) return fail("expected a moved wall");

    // Felt, saved, taken back, loaded again.
    const auto force = tissue.force_n(1);
    if (!force || !(dot(*force, ahead) < 0)) return fail("expected a force against the push");
    const auto file = std::filesystem::temp_directory_path() / "own_tissue.state";
    if (const auto s = tissue.save_state(file); !s) return fail(s.error().message);
    if (const auto s = tissue.undo(); !s) return fail(s.error().message);
    if (tissue.hash() != at_rest) return fail("expected undo to give the same bits");
    if (const auto s = tissue.redo(); !s) return fail(s.error().message);
    if (tissue.hash() != deformed) return fail("expected redo to give the same bits");
    if (const auto s = tissue.reset(); !s) return fail(s.error().message);
    if (const auto s = tissue.load_state(file); !s) return fail(s.error().message);
    std::filesystem::remove(file);
    if (tissue.hash() != deformed) return fail("expected a loaded state to give the same bits");
    for (auto sweep = tissue.sweep(); sweep && !sweep->settled;) sweep = tissue.sweep();
    if (tissue.hash() != at_rest) return fail("expected released jelly to come to rest");

    // All rules of tissues.
    const auto kept =
        pliant::check_tissue(example::Jelly::create, phantom->volume,
                             {.point_mm = carina.push_point_mm, .push_mm = 4.0 * ahead});
    if (!kept) return fail(kept.error().message);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const pliant::TaskArena arena;
    const std::string_view option = argc > 1 ? argv[1] : "";
    if (option == "--check") return check(arena);
    return serve(option == "--needle" ? example::Needle::create : example::Jelly::create, arena);
}
