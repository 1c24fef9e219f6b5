// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A format: small valid files, the command lines that read them, and how they are damaged.

#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mutate/mutations.h"

namespace pliant::mutate {

struct File {
    std::string name;
    std::string bytes;
    std::size_t header = 0;  ///< as of mutate()
    bool fixed = false;      ///< stays as it is
    bool gzip = false;       ///< is compressed after it was changed, or before
};
using Files = std::vector<File>;

struct Seed {
    std::string name;
    Files files;
    std::vector<std::string> commands;  ///< words with blanks between; each run takes one of them.
                                        ///< Uploads: kUpload, kUploadFirstSeries
    /// Puts checksums right after the change.
    std::function<void(Files&)> repair = {};
    /// Instead of a change of bytes.
    std::function<Files(Random&)> damaged = {};
};

struct Format {
    std::string name;
    Words words;
    std::vector<Seed> seeds;
    bool may_be_long = false;  ///< the file says how much work there is
    bool is_uploaded = false;  ///< to a server that goes on; else there are command lines
};

inline const std::string kUpload = "serve, upload";
/// Chooses the first of several series. With kUpload all are dropped.
inline const std::string kUploadFirstSeries = "serve, upload, first series";

/// Sources of the seeds.
struct Sources {
    std::filesystem::path program;
    std::filesystem::path fuzz_corpus;  ///< tests/fuzz/corpus
    std::filesystem::path corpus;       ///< tests/mutate/corpus
};

/// A seed's files as the program gets them: undamaged.
Files good_files(const Seed& seed);
/// One to two of them damaged.
Files damaged_files(const Seed& seed, const Words& words, Random& random);

}  // namespace pliant::mutate
