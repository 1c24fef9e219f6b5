// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The files of the page, embedded in the program by cmake/embed_page.cmake. No file is read from
// the disk or loaded from elsewhere.

#pragma once

#include <span>
#include <string_view>

namespace pliant::serve {

struct PageFile {
    std::string_view name;  ///< "index.html", "assets/app.js"
    std::string_view bytes;
};

/// Embedded files; empty if the build had no page.
std::span<const PageFile> built_in_page();
/// Finds a page's file. Without an embedded page, index.html is a short notice.
/// @returns null if there is no such file
const PageFile* find_page_file(std::string_view name);
/// Media type by the name's extension.
std::string_view media_type(std::string_view name);

}  // namespace pliant::serve
