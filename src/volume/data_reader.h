// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Reads the data after a header: raw, deflated or as text, piece by piece, so that no second copy
// of a volume is ever in memory. What is damaged or ends early is an error, never zeros.

#pragma once

#include "volume/image_header.h"

#include <functional>

namespace pliant {

/// Takes the next stored numbers, in this machine's byte order.
using DataSink = std::function<void(Component component, const void* values, std::size_t count)>;

/// Hands all numbers of an image to a sink. @pre check_header(path, …, header) was fine
Status read_data(const std::filesystem::path& path, const ImageHeader& header,
                 const DataSink& sink);

}  // namespace pliant
