// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Instruction sets that kernels are compiled for; comes before Highway's headers. Each one is the
// whole kernel compiled again, so those that bring nothing are left out: SSSE3 and SSE4 (processors
// with them and without AVX2 are older than 2013, and the baseline gives them the same bits), and
// the extensions of AVX-512 (AVX3_DL; in newer Highways AVX3_ZEN4 and AVX3_SPR), whose instructions
// no kernel uses. On x86-64 the baseline, AVX2 and AVX3 remain.

#pragma once

// GCC gives a target's attribute to no function that it makes itself, such as a constructor of a
// struct of vectors. So NEON with AES, which no kernel uses, is left out where the compiler's
// baseline is without. NEON without AES, a target since Highway 1.0.5, needs no attribute.
#if defined(__aarch64__) && !defined(__ARM_FEATURE_AES)
#define PLIANT_NEON_WITH_AES HWY_NEON
#else
#define PLIANT_NEON_WITH_AES 0
#endif

// Vectors whose size is known only at run time can't be kept in arrays and structs: SVE and RVV.
#define HWY_DISABLED_TARGETS                                                            \
    (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV | HWY_SSSE3 | HWY_SSE4 | \
     PLIANT_NEON_WITH_AES | HWY_AVX3_DL | (1LL << 6) /* AVX3_ZEN4 */ | (1LL << 4) /* AVX3_SPR */)
