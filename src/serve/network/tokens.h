// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The secrets of a server's links. Those of a session are kept beside it, so that links outlive a
// restart.

#pragma once

#include <pliant/result.h>

#include <filesystem>
#include <string>

namespace pliant::serve {

/// Secrets of the links with control and view permission.
struct Tokens {
    std::string control, view;
};

Tokens random_tokens();

/// Reads the secrets of a session from SESSION.links, or makes the file, for this user only. An
/// empty file is none.
/// @returns Unreadable for a file with other contents, of another user, or that others may read;
///          Unwritable
Result<Tokens> tokens_of_session(const std::filesystem::path& session);

}  // namespace pliant::serve
