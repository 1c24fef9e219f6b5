// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Nothing: the target of this file has the headers that all tests precompile.
