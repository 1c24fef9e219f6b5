// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "network/page.h"

#include <utility>

namespace pliant::serve {
namespace {

constexpr std::string_view kPlainPage = R"(<!doctype html>
<html lang="en">
<head><meta charset="utf-8"><title>Pliant</title></head>
<body>
<h1>Pliant is running</h1>
<p>This program was built without its page (PLIANT_BUILD_VIEWER=OFF, or the folder viewer/dist was
empty), so there is nothing to see here. Its WebSocket is at <code>/ws</code>;
docs/developers/protocol.md describes its messages. <code>./dev build</code> makes the program
with the page.</p>
</body>
</html>
)";
constexpr PageFile kPlainFile{"index.html", kPlainPage};

}  // namespace

const PageFile* find_page_file(std::string_view name) {
    if (name.empty()) name = "index.html";
    const auto files = built_in_page();
    for (const PageFile& file : files)
        if (file.name == name) return &file;
    return files.empty() && name == kPlainFile.name ? &kPlainFile : nullptr;
}

std::string_view media_type(std::string_view name) {
    constexpr std::pair<std::string_view, std::string_view> kTypes[] = {
        {".html", "text/html; charset=utf-8"},
        {".js", "text/javascript; charset=utf-8"},
        {".mjs", "text/javascript; charset=utf-8"},
        {".css", "text/css; charset=utf-8"},
        {".json", "application/json"},
        {".map", "application/json"},
        {".svg", "image/svg+xml"},
        {".png", "image/png"},
        {".ico", "image/x-icon"},
        {".webp", "image/webp"},
        {".woff2", "font/woff2"},
        {".wasm", "application/wasm"},
        {".txt", "text/plain; charset=utf-8"},
    };
    for (const auto& [ending, type] : kTypes)
        if (name.ends_with(ending)) return type;
    return "application/octet-stream";
}

}  // namespace pliant::serve
