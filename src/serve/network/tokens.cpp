// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "network/tokens.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <random>
#include <string_view>
#include <system_error>

#include "base/descriptor.h"
#include "base/errors.h"
#include "protocol/messages.h"

namespace pliant::serve {
namespace {

constexpr std::size_t kDigits = 32;

std::string random_token() {
    std::random_device device;
    std::string text;
    while (text.size() < kDigits) text += hex_text(device(), 8);
    return text;
}

bool is_token(const std::string& text) {
    return text.size() == kDigits &&
           text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

Tokens random_tokens() {
    return {random_token(), random_token()};
}

Result<Tokens> tokens_of_session(const std::filesystem::path& session) {
    const std::filesystem::path path = session.string() + ".links";
    const auto refused = [&](const std::string& what) {
        return unreadable(path, what + "; without the file there are new links");
    };
    const auto unwritable = [&](int error) {
        return Error{ErrorCode::Unwritable, path.string() + ": can't be written: " +
                                                std::generic_category().message(error)};
    };
    Descriptor file = open_file(path, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK, 0600);
    if (!file.is_open() && errno == ELOOP)
        return refused("is a link to another file, expected a file of its own");
    struct stat status {};
    if (!file.is_open() || ::fstat(file.number(), &status) != 0) return unwritable(errno);
    if (!S_ISREG(status.st_mode)) return refused("is no regular file, expected one");
    // The links of a file that others write or read would be theirs too.
    if (status.st_uid != ::geteuid())
        return refused("belongs to another user, expected a file of one's own");
    if ((status.st_mode & 0077) != 0)
        return refused("can be read or written by other users, expected none (chmod 600)");
    std::array<char, 2 * (kDigits + 1) + 1> bytes;
    std::size_t count = 0;
    if (const int error = read_at(file.number(), bytes.data(), bytes.size(), 0, &count))
        return unreadable(path, "can't be read: " + std::generic_category().message(error));
    if (count > 0) {
        const std::string_view text(bytes.data(), count);
        const Tokens tokens{std::string(text.substr(0, kDigits)),
                            std::string(text.substr(std::min(count, kDigits + 1), kDigits))};
        if (text == tokens.control + "\n" + tokens.view + "\n" && is_token(tokens.control) &&
            is_token(tokens.view) && tokens.control != tokens.view)
            return tokens;
        return refused("expected two different lines of 32 hexadecimal digits, found others");
    }
    // New, or left by a start that failed or was killed.
    const Tokens tokens = random_tokens();
    const std::string text = tokens.control + "\n" + tokens.view + "\n";
    int error = write_all(file.number(), text.data(), text.size());
    if (error) (void)::ftruncate(file.number(), 0);
    if (!error) error = file.close();
    if (error) return unwritable(error);
    return tokens;
}

}  // namespace pliant::serve
