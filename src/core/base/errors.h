// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Factories of common errors.

#pragma once

#include <pliant/core/files.h>
#include <pliant/result.h>

#include <filesystem>
#include <string>
#include <utility>

namespace pliant {

inline Error invalid(const std::string& message) {
    return {ErrorCode::InvalidArgument, message};
}
/// Error about one field; its message is composed of the three parts.
inline Error expected_error(std::string field, std::string expected, std::string found,
                            ErrorCode code = ErrorCode::InvalidArgument) {
    std::string message = field + ": expected " + expected + ", found " + found;
    return {code, std::move(message), std::move(field), std::move(expected), std::move(found)};
}
/// Error about one field. @param text  its fault
inline Error about(std::string field, ErrorCode code, const std::string& text) {
    std::string message = field + ": " + text;
    return {code, std::move(message), std::move(field)};
}
/// The same error with a file or a part of a struct in front of its message.
inline Error within(const std::string& where, Error error) {
    error.message = where + ": " + error.message;
    return error;
}
inline Error unreadable(const std::filesystem::path& path, const std::string& message) {
    return {ErrorCode::Unreadable, path.string() + ": " + message};
}
inline Error unsupported(const std::filesystem::path& path, const std::string& message) {
    return {ErrorCode::Unsupported, path.string() + ": " + message};
}

/// Whether an error reports lack of memory and no other cause.
inline bool is_out_of_memory(const Error& error) noexcept {
    return error.code == ErrorCode::LimitExceeded && error.message.ends_with("out of memory");
}

/// The error's text without line ends and other control characters, which quoted text may contain.
inline Error in_one_line(Error error) {
    error.message = one_line(error.message);
    return error;
}

}  // namespace pliant
