# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# NLopt. MIT; the library holds routines of Luksan's under the LGPL too, which are not called.
# Derivative-free searches for the parameters of spring networks.
find_package(NLopt 2.7 ${PLIANT_FIND})
set(PLIANT_RECIPE_FOUND ${NLopt_FOUND})
