// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A saved state of a catheter in its vessel.

#include <pliant/tissues.h>

#include "fuzz/number_state.h"
#include "session/source.h"

using namespace pliant;

namespace {

const char* kScene =
    "[vessel]\nphantom = \"bend\"\nthickness_mm = 1.5\nlayers = 1\n"
    "[wall]\nsupport_pa_per_mm = 2000\n"
    "[catheter]\nlength_mm = 150\nbend_n_mm2 = 200\ntip_bend_n_mm2 = 100\n"
    "[entry]\nplace_mm = [0, 0, 45]\ndirection = [0, 0, 1]\ninserted_mm = 27\n";

struct Subject {
    TaskArena arena{1};
    Result<serve::LoadedScan> loaded;
    std::unique_ptr<Tissue> tissue;
    std::string good;

    Subject()
        : loaded(
              serve::load_scan({.file = fuzz::write_anew("bend.toml", kScene).string()}, arena)) {
        fuzz::expect(loaded.ok() && loaded->vessel, "a vessel");
        auto made =
            make_vessel(loaded->volume, loaded->vessel->wall, loaded->vessel->settings, arena);
        fuzz::expect(made.ok(), "a catheter in it");
        tissue = std::move(*made);
        const auto file = fuzz::folder() / "good.state";
        fuzz::expect(tissue->save_state(file).ok(), "a state");
        good = fuzz::bytes_of(file);
    }
};

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static Subject subject;
    fuzz::try_state(*subject.tissue, subject.good, fuzz::text_of(data, size));
    return 0;
}
