// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Seeds: settings of tissue, label maps and directions, saved states.

#include <cstdint>
#include <cstring>

#include "mutate/formats.h"
#include "mutate/repair.h"
#include "support/scan_files.h"

namespace pliant::mutate {
namespace {

const std::string kPush = "deform c.nrrd --push 0,0,0:0,6,0 --tool sphere:20 --threads 1";

/// The cube's values would count as bone.
const std::string kSoft = "[material]\nbone_threshold_hu = 3000\n";

const std::string kEveryKey =
    "[material]\nlaw = \"draeger\"\noffset = 0.15\nbone_threshold_hu = 2500\nmax_movement_mm = "
    "12.5\n"
    "yield = 0.1\nlimits = \"rounded\"\n[push]\nscale = 1.2\n"
    "[lattice]\nbrick_size = 5\nmax_elements = 1000000\n"
    "[air]\nenabled = true\nthreshold_hu = -450\ncompress = 0.9\nstretch = 20\nshear = 30\n";

const std::string kOldKeys =
    "# as of Divod\ncubicle size = 8\nscale factor = 1\noffset = 0.2\nbone threshold = 4000\n"
    "maximum allowed movement = 20\nmax tries = 10\n";

const std::string kLabels =
    "[material]\nbone_threshold_hu = 3000\n[[label]]\nvalues = [1, 2]\nlaw = \"constant\"\n"
    "compress = 0.1\nstretch = [0.1, 0.2, 0.3]\nshear = 0\nmax_movement_mm = 4\n"
    "frame = \"direction\"\n[[label]]\nvalues = 3\nfactor = [1, 0.2, 0.2]\nyield = 0.05\n"
    "[[label]]\nvalues = 4\nlaw = \"fixed\"\n";

const Words kTomlWords = {"[material]\n",
                          "[push]\n",
                          "[lattice]\n",
                          "[air]\n",
                          "[[label]]\n",
                          "law = ",
                          "offset = ",
                          "bone_threshold_hu = ",
                          "max_movement_mm = ",
                          "yield = ",
                          "limits = ",
                          "scale = ",
                          "brick_size = ",
                          "max_elements = ",
                          "max_steps = ",
                          "max_mb = ",
                          "enabled = ",
                          "threshold_hu = ",
                          "compress = ",
                          "stretch = ",
                          "shear = ",
                          "values = ",
                          "factor = ",
                          "frame = ",
                          "\"constant\"",
                          "\"rounded\"",
                          "\"direction\"",
                          "\"fixed\"",
                          "true",
                          "[1, 2]",
                          "[[[]]]",
                          "{ a = 1 }",
                          "\"\"\"",
                          "'''",
                          "\\u0000",
                          "\\U0010FFFF",
                          "1979-05-27T07:32:00Z",
                          "0x",
                          "a.b.c = 1\n",
                          "# ",
                          "=",
                          "bonethreshold = ",
                          "maxtries = "};

File fixed(const std::string& name, const std::string& bytes) {
    return {.name = name, .bytes = bytes, .fixed = true};
}

Seed settings_seed(const std::string& name, const File& scan, const std::string& text) {
    return {.name = name,
            .files = {scan, {.name = "s.toml", .bytes = text}},
            .commands = {kPush + " --config s.toml --out out.nrrd --report r.json",
                         kPush + " --config s.toml --out out.nrrd --relax-sweeps 3 --save-state "
                                 "out.plst"}};
}

/// Damages the settings in a saved state, which have their length in front, or any of its bytes.
void damage_state(std::string& bytes, Random& random) {
    constexpr std::size_t kLengthAt = 168, kSettingsAt = kLengthAt + 4;
    std::uint32_t length = 0;
    std::memcpy(&length, &bytes[kLengthAt], sizeof length);
    if (random.whole(0, 1)) {
        std::string text = bytes.substr(kSettingsAt, length);
        mutate(text, 0, kTomlWords, random);
        const auto changed = std::uint32_t(text.size());
        std::memcpy(&bytes[kLengthAt], &changed, sizeof changed);
        bytes.replace(kSettingsAt, length, text);
    } else {
        mutate(bytes, kSettingsAt, {}, random);
    }
    repair_state(bytes);
}

}  // namespace

Format settings(const Sources& from) {
    const File scan = fixed("c.nrrd", cube(from, "8"));
    return {.name = "settings",
            .words = kTomlWords,
            .seeds = {settings_seed("soft", scan, kSoft), settings_seed("every", scan, kEveryKey),
                      settings_seed("old", scan, kOldKeys)}};
}

Format labels(const Sources& from) {
    const std::string scan = cube(from, "8");
    const std::size_t header = scan.find("\n\n") + 2;
    std::string label_header = scan.substr(0, header), labels;
    for (int n = 0; n < 512; ++n) labels += test::packed<std::int16_t>({std::int16_t(n / 64 % 5)});
    std::vector<float> along;
    for (int n = 0; n < 512; ++n) along.insert(along.end(), {0.F, float(n % 3), 1.F});
    const test::NrrdFile field{.type = "float",
                               .dimension = "4",
                               .sizes = "3 8 8 8",
                               .directions = "none (12.5,0,0) (0,12.5,0) (0,0,12.5)",
                               .kinds = "vector domain domain domain",
                               .origin = "(-43.75,-43.75,-43.75)",
                               .data = test::packed(along)};
    const std::string field_bytes = field.bytes();
    Seed seed{.name = "labels",
              .files = {fixed("c.nrrd", scan),
                        {.name = "s.toml", .bytes = kLabels},
                        {.name = "l.nrrd", .bytes = label_header + labels, .header = header},
                        {.name = "d.nrrd",
                         .bytes = field_bytes,
                         .header = field_bytes.size() - field.data.size()}},
              .commands = {kPush + " --config s.toml --labels l.nrrd --directions d.nrrd --out "
                                   "out.nrrd --displacement u.nrrd"}};
    Words words = kTomlWords;
    words.insert(words.end(), {"type: ", "sizes: ", "kinds: ", "space directions: ", "endian: ",
                               "none", "vector", "covariant-vector", "encoding: ", "content: "});
    return {.name = "labels", .words = words, .seeds = {seed}};
}

Format state(const Sources& from) {
    const File scan = fixed("c.nrrd", cube(from, "8")), soft = fixed("s.toml", kSoft);
    const auto saved = [&](const std::string& name, const std::string& how) {
        const std::string command = "deform c.nrrd --config s.toml --tool sphere:20 --threads 1 " +
                                    how + " --out o.nrrd --save-state a.plst";
        Seed seed{.name = name,
                  .files = {scan, made_by(from, {scan, soft}, command, {"a.plst"}).front()},
                  .commands = {kPush + " --load-state a.plst --out out.nrrd",
                               kPush + " --load-state a.plst --out out.nrrd --save-state b.plst"}};
        seed.damaged = [files = seed.files](Random& random) {
            Files changed = files;
            damage_state(changed.back().bytes, random);
            return changed;
        };
        return seed;
    };
    return {.name = "state",
            .words = kTomlWords,
            .seeds = {saved("pushed", "--push 0,0,0:0,6,0"),
                      saved("carved", "--push 0,0,0:0,6,0 --carve 20,0,0:15 --relax-sweeps 2"),
                      saved("cut", "--cut -60,1,0;60,1,0:0,0,60 --push 0,0,0:3,0,0")}};
}

}  // namespace pliant::mutate
