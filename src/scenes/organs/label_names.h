// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Names of the labels of a label map: from a table in the map itself, from a text beside it, or
// from a text that the user names.

#pragma once

#include <pliant/result.h>
#include <pliant/volume.h>

#include <filesystem>
#include <map>
#include <string>

#pragma GCC visibility push(default)  // for other components
namespace pliant {

using LabelNames = std::map<int, std::string>;

/// Reads a table of names: JSON ({"1": "spleen"}, {"spleen": 1}, either under the key "labels", or
/// a list of objects with "value" and "name"), 3D Slicer's colour tables (.ctbl), label
/// descriptions of ITK-SNAP, or lines of a value and a name (.csv, .txt). Most lines must have a
/// name. Underscores of a colour table are blanks.
/// @returns NotFound, or Unreadable for a file without a name, with the file in the message
Result<LabelNames> read_label_names(const std::filesystem::path& table);

/// Finds the names of a map: those of the table; without one those of the map itself, which are
/// 3D Slicer's segments (NRRD) or a LabelTable in an extension (NIfTI); without these those of a
/// text beside it with the map's name and the ending .json, .ctbl, .csv, .txt or .label. Such a
/// text must be a table throughout.
/// @param key_values  of the map
/// @param table  empty: none
/// @returns an error of read_label_names for the table; empty if there are none
Result<LabelNames> find_label_names(const std::filesystem::path& map, const KeyValues& key_values,
                                    const std::filesystem::path& table);

}  // namespace pliant
#pragma GCC visibility pop
