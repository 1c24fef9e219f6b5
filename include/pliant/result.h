// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Errors as values. A function that depends on data (a file, a setting, a message) returns a
// Result: the value, or an Error with one line of text that names the file or field, the found and
// the expected value. One exception crosses the library's interface: const functions that return a
// container by value throw std::bad_alloc, as a copy of the container would. They change nothing.

#pragma once

#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#pragma GCC visibility push(default)
namespace pliant {

// PLIANT_ASSERT reports programming errors only. It is active in Debug and sanitizer builds. Bad
// data is never asserted: it becomes an Error. The handler is replaceable; the default one prints
// and aborts.

using AssertHandler = void (*)(const char* expression, const char* file, int line);

/// Replaces the handler. @returns the previous one
AssertHandler set_assert_handler(AssertHandler handler);
void assert_failed(const char* expression, const char* file, int line);

}  // namespace pliant
#pragma GCC visibility pop

#ifdef PLIANT_ASSERTIONS
#define PLIANT_ASSERT(expression) \
    ((expression) ? void(0) : ::pliant::assert_failed(#expression, __FILE__, __LINE__))
#else
#define PLIANT_ASSERT(expression) void(sizeof(!(expression)))
#endif

#pragma GCC visibility push(default)
namespace pliant {

enum class ErrorCode {
    InvalidArgument,  ///< a setting or an option is out of range
    NotFound,         ///< a file, folder or part of it is missing
    Unreadable,       ///< a file exists but is damaged, truncated or of another kind than its name
                      ///< says
    Unsupported,      ///< well-formed, but not supported by Pliant
    Unwritable,       ///< the output can't be written
    LimitExceeded,    ///< needs more memory or time than allowed or available
};

struct Error {
    ErrorCode code = ErrorCode::InvalidArgument;
    std::string message;  ///< one line, no trailing full stop or newline
    // Parts of a message about one field: "field: expected …, found …".
    std::string field{};  ///< of a settings struct, or of a command: "depth_mm", "[air] stretch"
    std::string expected{}, found{};
};

/// The same error under another field name, for example that of a command-line option.
inline Error renamed(Error error, std::string field) {
    if (error.field.empty() || !error.message.starts_with(error.field)) return error;
    error.message.replace(0, error.field.size(), field);
    error.field = std::move(field);
    return error;
}

/// A value or an Error.
template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : m_state(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : m_state(std::in_place_index<1>, std::move(error)) {}

    bool ok() const { return m_state.index() == 0; }
    explicit operator bool() const { return ok(); }

    /// @pre ok()
    T& value() & { return (PLIANT_ASSERT(ok()), *std::get_if<0>(&m_state)); }
    const T& value() const& { return (PLIANT_ASSERT(ok()), *std::get_if<0>(&m_state)); }
    T&& value() && { return (PLIANT_ASSERT(ok()), std::move(*std::get_if<0>(&m_state))); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }

    /// @pre !ok()
    const Error& error() const { return (PLIANT_ASSERT(!ok()), *std::get_if<1>(&m_state)); }

  private:
    std::variant<T, Error> m_state;
};

struct Ok {};

/// Success, or an Error.
using Status = Result<Ok>;

/// Error of an operation that ran out of memory and was rolled back. Doesn't allocate.
inline Error out_of_memory() noexcept {
    return {ErrorCode::LimitExceeded, "out of memory"};  // fits the small-string buffer
}

/// Runs work, which returns a Result, and converts exceptions for lack of memory to its error. A
/// function that is noexcept, such as those of a tissue of your own, begins with it. Rollback is
/// the responsibility of work.
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

}  // namespace pliant
#pragma GCC visibility pop
