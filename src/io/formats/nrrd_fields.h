// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The text of a NRRD header [Kindlmann2008]: lines `field: value`, `key:=value` and comments, up to
// an empty line; then the data, or a field with the name of the data file.

#pragma once

#include "formats/image_header.h"

#include <array>
#include <map>

namespace pliant {

struct NrrdFields {
    std::map<std::string, std::string, std::less<>> values;  ///< by standard names
    KeyValues key_values;                   ///< in the file's order, unescaped, each key once
    std::vector<std::string> listed_files;  ///< after "data file: LIST"
    std::uint64_t header_bytes = 0;

    std::string_view field(std::string_view name) const {
        const auto found = values.find(name);
        return found == values.end() ? std::string_view{} : found->second;
    }
};

/// Error that quotes a field.
Error bad_nrrd_field(const std::filesystem::path& path, std::string_view field,
                     std::string_view found, const std::string& expected);

/// @returns Unreadable for an invalid line, a duplicate field, and headers without an end
Result<NrrdFields> read_nrrd_fields(const std::filesystem::path& path);

/// Parsers of the fields `type`, `space` and `kinds`, with all spellings of the format.
std::optional<Component> nrrd_type_from(std::string_view name);

/// The coordinates of positions: the first three or two are in space, a fourth one is time.
struct NrrdSpace {
    enum Axes { Unnamed, Ras, Las, Lps, Other } axes = Unnamed;
    std::size_t dimension = 3;  ///< 2, 3 or 4
};
std::optional<NrrdSpace> nrrd_space_from(std::string_view name);

struct NrrdKind {
    bool is_domain = true;  ///< an axis of space or time; false: components of a voxel
    std::int64_t size = 0;  ///< required size of the axis; 0: any
};
std::optional<NrrdKind> nrrd_kind_from(std::string_view name);

/// Parses vectors "(x,y,z)", or "none", one per axis.
/// @param dimension  of the space, up to 4; the other components are 0
/// @returns nullopt for other text or numbers that aren't finite
std::optional<std::vector<std::optional<std::array<double, 4>>>> nrrd_vectors_from(
    std::string_view text, std::size_t dimension = 3);

/// Parses words in double quotes, with \" for a quote.
std::optional<std::vector<std::string>> quoted_words_from(std::string_view text);

}  // namespace pliant
