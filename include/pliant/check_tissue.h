// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Conformance test of a tissue: pushes, moves, undoes, saves and loads it, and compares the
// results with the rules of tissue.h and the model's traits. The library's own tissues pass it.
//
// @code
//   const MakeTissue make = [](const Volume& scan, const TaskArena& arena) {
//       return make_chainmail(scan, {}, arena);
//   };
//   Status kept = check_tissue(make, volume, {.point_mm = point, .push_mm = {0, 3, 0}});
//   if (!kept) show(kept.error());  // undo: expected the hash before the push, found …
// @endcode

#pragma once

#include <pliant/own_tissue.h>

#include <functional>
#include <memory>
#include <span>
#include <string_view>

#pragma GCC visibility push(default)
namespace pliant {

/// Makes one more tissue of the same kind, at rest. The tissues may have different numbers of
/// threads: their states must be the same.
using MakeAnother = std::function<Result<std::shared_ptr<Tissue>>()>;

/// @param make  called several times; up to three of its tissues exist at a time
/// @param push  a push that moves tissue, as far as the model allows. A rigid tissue may reject it
/// @returns the first broken rule: its name in `field`, the expected and the found in the message;
///          Unwritable if the folder for temporary files can't be written
Status check_tissue(const MakeAnother& make, const Push& push) noexcept;
/// The same for tissues of a scan, on one, two and four threads in turn.
Status check_tissue(const MakeTissue& make, const Volume& scan, const Push& push) noexcept;

/// Names of the rules, in the order in which they are checked.
std::span<const std::string_view> tissue_rules() noexcept;

}  // namespace pliant
#pragma GCC visibility pop
