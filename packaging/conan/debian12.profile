# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# The libraries of Debian 12, as `./dev build` installs them, in place of Conan's:
#   conan create packaging/conan -pr:a packaging/conan/debian12.profile

[settings]
os=Linux
arch=x86_64
build_type=Release
compiler=gcc
compiler.version=12
compiler.libcxx=libstdc++11
compiler.cppstd=20

[platform_requires]
boost/1.74
cli11/2.1
eigen/3.4
gdcm/3.0
highway/1.0
libpng/1.6
lz4/1.9
nlohmann_json/3.11
onetbb/2021.8
openssl/3.0
pugixml/1.13
tomlplusplus/3.3
zlib/1.2
