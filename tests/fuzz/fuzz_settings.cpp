// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A settings file: TOML, or the lines of an older program. Accepted settings round-trip, and a
// lattice can be made with them or reports an error.

#include <pliant/chainmail.h>
#include <pliant/volume.h>

#include "fuzz/fuzz.h"
#include "material/settings.h"

using namespace pliant;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const TaskArena arena(1);
    static const auto phantom = make_phantom({.name = "cube", .size = {8, 8, 8}}, arena);
    const std::string_view text = fuzz::text_of(data, size);
    const auto settings = read_chainmail_settings(fuzz::write_anew("s.toml", text), nullptr);
    if (!settings.ok()) {
        fuzz::expect_one_line(settings.error().message);
        return 0;
    }
    const std::string own = settings_text(*settings);
    const auto again = parse_settings("own", own);
    fuzz::expect(again.ok(), "its own text can be read", again.ok() ? own : again.error().message);
    fuzz::expect(settings_text(*again) == own, "the same text again", own);
    const auto tissue = ChainMail::create(phantom->volume, *settings, arena);
    if (!tissue.ok()) fuzz::expect_one_line(tissue.error().message);
    return 0;
}
