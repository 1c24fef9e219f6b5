// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate/input.h"

#include "support/scan_files.h"

namespace pliant::mutate {
namespace {

void damage(File& file, const Words& words, Random& random) {
    const bool inside = file.gzip && random.whole(0, 2) > 0;
    if (file.gzip && !inside) {
        file.bytes = test::gzipped(file.bytes);
        file.gzip = false;
        file.header = 0;
    }
    mutate(file.bytes, file.header, words, random);
}

Files packed(Files files) {
    for (File& file : files)
        if (file.gzip) file.bytes = test::gzipped(file.bytes);
    return files;
}

}  // namespace

Files good_files(const Seed& seed) {
    return packed(seed.files);
}

Files damaged_files(const Seed& seed, const Words& words, Random& random) {
    if (seed.damaged) return seed.damaged(random);
    Files files = seed.files;
    std::vector<File*> loose;
    for (File& file : files)
        if (!file.fixed) loose.push_back(&file);
    damage(*any_of(loose, random), words, random);
    if (loose.size() > 1 && random.whole(0, 3) == 0) damage(*any_of(loose, random), words, random);
    files = packed(std::move(files));
    if (seed.repair) seed.repair(files);
    return files;
}

}  // namespace pliant::mutate
