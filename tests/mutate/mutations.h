// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Damage to files: bytes, cuts, numbers, long fields, garbage, nesting, and a format's own words in
// wrong places.

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "support/random.h"

namespace pliant::mutate {

using test::Random;

/// A format's words: field names and values. One that ends with a separator (": ", " = ") begins a
/// field.
using Words = std::vector<std::string>;

/// Makes one to four changes.
/// @param header  length of the part in front that is a header; it gets three quarters of the
///                changes. 0: all of it
void mutate(std::string& bytes, std::size_t header, const Words& words, Random& random);

/// A number as text that readers stumble over.
std::string odd_number(Random& random);

template <class T>
const T& any_of(const std::vector<T>& all, Random& random) {
    return all[std::size_t(random.whole(0, int(all.size()) - 1))];
}

}  // namespace pliant::mutate
