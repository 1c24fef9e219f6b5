// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// What ITK's own readers make of a file: the second opinion in tests.

#pragma once

#include <pliant/grid.h>

#include <filesystem>
#include <string>
#include <vector>

namespace pliant::test {

struct ItkImage {
    Grid grid;
    std::vector<double> values;  ///< components fastest
    int components = 1;
    std::string error;  ///< empty: fine
};

/// Reads .nrrd, .nhdr, .mha, .mhd, .nii or .nii.gz.
ItkImage read_with_itk(const std::filesystem::path& path);

}  // namespace pliant::test
