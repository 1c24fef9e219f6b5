// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Scan files of every kind that the three header formats allow, made byte by byte. Their hashes
// are recorded in recorded_hashes.inc.

#pragma once

#include "support/scan_files.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace pliant::test {

struct MadeScan {
    /// The table's row is the part before " / ": scans of one row share a hash.
    std::string name;
    /// Names and bytes; the first is the one that is read.
    std::vector<std::pair<std::string, std::string>> files;
    bool is_field = false;  ///< for read_vector_field
};
using MadeScans = std::vector<MadeScan>;

MadeScans nrrd_scans();
MadeScans nrrd_key_scans();
MadeScans meta_scans();
MadeScans nifti_scans();
/// Random positions and directions of voxels, many scans to a row.
MadeScans nifti_orientations();

/// Types of numbers with the formats' names; and 24 numbers of each, including the extremes.
struct NumberType {
    const char* name;
    std::vector<std::string> nrrd;
    std::vector<std::string> meta;
    std::int16_t nifti;
    std::size_t size;
    std::string data;
    std::string text;
};
const std::vector<NumberType>& number_types();

inline std::string big(const NumberType& type) {
    return swapped(type.data, type.size);
}

}  // namespace pliant::test
