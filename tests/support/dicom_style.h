// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Elements and sequences of DICOM, written in each way that the format allows.

#pragma once

#include "support/scan_files.h"

#include <cstdint>
#include <string>
#include <vector>

namespace pliant::test {

/// How sequences are written.
struct Style {
    bool implicit = false, known_lengths = false;

    std::string tag(std::uint32_t t) const {
        return packed<std::uint16_t>({std::uint16_t(t >> 16), std::uint16_t(t)});
    }
    static std::string u32(std::size_t n) { return packed<std::uint32_t>({std::uint32_t(n)}); }
    /// @param type  with a length of 16 bits
    std::string element(std::uint32_t t, const char* type, std::string text) const {
        if (text.size() % 2) text += ' ';
        if (implicit) return tag(t) + u32(text.size()) + text;
        return tag(t) + type + packed<std::uint16_t>({std::uint16_t(text.size())}) + text;
    }
    std::string decimals(std::uint32_t t, const std::string& text) const {
        return element(t, "DS", text);
    }
    std::string shorts(std::uint32_t t, const std::vector<std::uint16_t>& numbers) const {
        return element(t, "US", packed(numbers));
    }
    std::string sequence(std::uint32_t t, const std::vector<std::string>& items) const {
        std::string body;
        for (const std::string& item : items)
            body += tag(0xfffee000) + (known_lengths
                                           ? u32(item.size()) + item
                                           : u32(0xffffffff) + item + tag(0xfffee00d) + u32(0));
        const std::string start = tag(t) + (implicit ? "" : std::string("SQ\0\0", 4));
        if (known_lengths) return start + u32(body.size()) + body;
        return start + u32(0xffffffff) + body + tag(0xfffee0dd) + u32(0);
    }
};

}  // namespace pliant::test
