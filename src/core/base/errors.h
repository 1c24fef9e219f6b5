// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Factories of common errors.

#pragma once

#include <pliant/files.h>
#include <pliant/result.h>

#include <filesystem>
#include <new>
#include <stdexcept>
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
inline Error within(const std::string& place, Error error) {
    error.message = place + ": " + error.message;
    return error;
}
inline Error unreadable(const std::filesystem::path& path, const std::string& message) {
    return {ErrorCode::Unreadable, path.string() + ": " + message};
}
inline Error unsupported(const std::filesystem::path& path, const std::string& message) {
    return {ErrorCode::Unsupported, path.string() + ": " + message};
}

/// Error of an operation that ran out of memory and was rolled back. Doesn't allocate.
inline Error out_of_memory() noexcept {
    return {ErrorCode::LimitExceeded, "out of memory"};  // fits the small-string buffer
}

/// Whether an error reports lack of memory and no other cause.
inline bool is_out_of_memory(const Error& error) noexcept {
    return error.code == ErrorCode::LimitExceeded && error.message.ends_with("out of memory");
}

/// Runs work, which returns a Result, for a public entry point, and converts exceptions for lack of
/// memory to its error. Rollback is the responsibility of work.
template <class Work>
auto attempt(Work&& work) noexcept -> decltype(work()) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return out_of_memory();
    } catch (const std::length_error&) {  // thrown by a container beyond its size limit
        return out_of_memory();
    } catch (const std::runtime_error&) {  // thrown by oneTBB if a thread can't be started
        return out_of_memory();
    }
}

/// The error's text without line ends and other control characters, which quoted text may contain.
inline Error in_one_line(Error error) {
    error.message = one_line(error.message);
    return error;
}

}  // namespace pliant
