// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "network/tokens.h"

#include <fcntl.h>

#include <cerrno>
#include <fstream>
#include <random>
#include <system_error>

#include "base/descriptor.h"
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
    Tokens tokens;
    if (std::ifstream file(path); file) {
        std::getline(file, tokens.control);
        std::getline(file, tokens.view);
        if (is_token(tokens.control) && is_token(tokens.view)) return tokens;
        return Error{ErrorCode::Unreadable,
                     path.string() +
                         ": expected two lines of 32 hexadecimal digits, found others; "
                         "without the file there are new links"};
    }
    tokens = random_tokens();
    const std::string text = tokens.control + "\n" + tokens.view + "\n";
    Descriptor file = open_file(path, O_WRONLY | O_CREAT | O_EXCL, 0600);
    int error = file.is_open() ? write_all(file.number(), text.data(), text.size()) : errno;
    if (!error) error = file.close();
    if (!error) return tokens;
    return Error{ErrorCode::Unwritable,
                 path.string() + ": can't be written: " + std::generic_category().message(error)};
}

}  // namespace pliant::serve
