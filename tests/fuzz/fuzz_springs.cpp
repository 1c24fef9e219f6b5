// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A saved state of springs.

#include "fuzz/number_state.h"
#include "tissue/spring_tissue.h"

using namespace pliant;

namespace {

std::unique_ptr<SpringScanTissue> make(const Volume& volume, const TaskArena& arena) {
    auto made = SpringScanTissue::create(volume, {.cell_mm = 4}, arena);
    fuzz::expect(made.ok(), "springs");
    return std::move(*made);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const TaskArena arena(1);
    static const Volume volume = [] {
        Volume block;
        block.grid.size = {17, 17, 17};
        block.voxels = std::vector<std::int16_t>(voxel_count(block.grid), 40);
        return block;
    }();
    static SpringScanTissue& tissue = *make(volume, arena).release();
    static const std::string good = [] {
        fuzz::expect(tissue.save_state(fuzz::folder() / "good.state").ok(), "a state");
        return fuzz::bytes_of(fuzz::folder() / "good.state");
    }();
    fuzz::try_state(tissue, good, fuzz::text_of(data, size));
    return 0;
}
