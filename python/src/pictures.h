// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pliant/render.h>

#include "arrays.h"

namespace pliant::python {

/// An array (height, width, 3) of uint8 that keeps the pixels.
nb::object picture_of(Image image);
/// A copy of such an array. @param name  of the argument, in messages
Image image_of(const nb::object& given, const char* name);
/// Raises an error for pictures without pixels or with too many.
void check_size(int width, int height);

}  // namespace pliant::python
