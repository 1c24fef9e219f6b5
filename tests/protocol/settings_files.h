// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Texts that are made from the rows of settings: tables of docs/, and types of the page.

#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace pliant::test {

/// Tables in Markdown by the name of their place, `<!-- settings: NAME -->` … `<!-- end -->`.
std::map<std::string, std::string> settings_tables();
/// viewer/src/net/settings.ts.
std::string settings_types();
/// A document with the text between its marks replaced. An unknown name leaves it as it is.
std::string with_tables(const std::string& document);

}  // namespace pliant::test
