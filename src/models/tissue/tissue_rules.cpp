// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "tissue/tissue_rules.h"

#include <pliant/deformation.h>

#include <atomic>
#include <system_error>

#include <unistd.h>

#include "base/input_file.h"

namespace pliant::rules {

StateFile::StateFile() {
    static std::atomic<int> count = 0;
    std::error_code error;
    m_path = std::filesystem::temp_directory_path(error);
    expect(!error, "a folder for temporary files", error.message());
    m_path /= "pliant-check-" + std::to_string(getpid()) + '-' + std::to_string(count++);
}

StateFile::~StateFile() {
    std::error_code ignored;
    std::filesystem::remove(m_path, ignored);
}

void StateFile::damage() const {
    std::error_code error;
    std::filesystem::resize_file(m_path, InputFile(m_path).size() / 2, error);
    expect(!error, "a file from save_state()", error.message());
}

Vec3i most_moved_element(const Tissue& tissue) {
    const Deformation& deformation = tissue.deformation();
    const Box3i box = deformation.moved_box();
    Vec3i found = box.begin;
    double most = 0;
    for (int k = box.begin.z; k < box.end.z; ++k)
        for (int j = box.begin.y; j < box.end.y; ++j)
            for (int i = box.begin.x; i < box.end.x; ++i)
                if (const double size = norm(deformation.displacement_mm({i, j, k})); size > most) {
                    most = size;
                    found = {i, j, k};
                }
    return found;
}

}  // namespace pliant::rules
