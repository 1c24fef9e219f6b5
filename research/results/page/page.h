// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The page with the results: Markdown with pictures and tables, written to its folder at the end.

#pragma once

#include <pliant/core/files.h>
#include <pliant/core/text.h>
#include <pliant/render.h>

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace pliant::results {

/// Digits with a thin space between groups of three.
std::string grouped_text(std::int64_t count);

class Page {
  public:
    explicit Page(std::filesystem::path folder, std::string name = "README.md")
        : m_folder(std::move(folder)), m_name(std::move(name)) {}

    void heading(int level, std::string_view text);
    void paragraph(std::string_view text);
    /// Adds a table with the page's command, date and machine, and the load by other processes
    /// until finish().
    void origin(const std::string& command);
    void table(std::initializer_list<std::string> head,
               const std::vector<std::vector<std::string>>& rows);
    /// @param name  of the file, without its extension
    void picture(std::string_view name, std::string_view description, const Image& image);
    /// Writes pictures and page atomically.
    Status finish();

  private:
    std::filesystem::path m_folder;
    std::string m_name;
    StagedFiles m_files;
    std::string m_text;
    std::string m_failure;               ///< first picture that couldn't be written
    double m_start_s = 0, m_busy_s = 0;  ///< at origin(): time, and busy time of other processes
};

}  // namespace pliant::results
