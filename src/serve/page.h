// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The files of the page, which are part of the program: nothing is read from the disk, and nothing
// comes from elsewhere. cmake/embed_page.cmake puts them in.

#pragma once

#include <span>
#include <string_view>

namespace pliant::serve {

struct PageFile {
    std::string_view name;  ///< "index.html", "assets/app.js"
    std::string_view bytes;
};

/// As built in; empty where there was no page to build in.
std::span<const PageFile> built_in_page();
/// A page's file. Without a built-in page there is a small one that says so.
/// @returns null if there is no such file
const PageFile* find_page_file(std::string_view name);
/// By the name's ending.
std::string_view media_type(std::string_view name);

}  // namespace pliant::serve
