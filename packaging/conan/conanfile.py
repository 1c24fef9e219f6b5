# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Pliant for Conan 2: builds the tree that this file lies in, without the page, which needs npm."""

import pathlib
import re

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy

_PARTS = ("apps", "cmake", "include", "src", "tools", "CMakeLists.txt", "CMakePresets.json")


class Pliant(ConanFile):
    """The library and the program."""

    name = "pliant"
    license = "Apache-2.0"
    description = "Real-time soft-tissue deformation and virtual endoscopy for medical scans"
    topics = ("medical-imaging", "soft-tissue", "simulation")
    settings = ("os", "arch", "compiler", "build_type")
    package_type = "static-library"

    def _root(self):
        return pathlib.Path(self.recipe_folder).parent.parent

    def set_version(self):
        """That of the header."""
        text = (self._root() / "include/pliant/core/version.h").read_text(encoding="utf-8")
        self.version = re.search(r'PLIANT_VERSION "([\d.]+)"', text)[1]

    def export_sources(self):
        """What the build reads."""
        for part in _PARTS:
            pattern = f"{part}/*" if (self._root() / part).is_dir() else part
            copy(self, pattern, str(self._root()), self.export_sources_folder)
        for file in ("LICENSE", "THIRD_PARTY.md"):
            copy(self, file, str(self._root()), self.export_sources_folder)

    def requirements(self):
        """As cmake/house.cmake: what is linked, and what is compiled in."""
        for one in ("onetbb/[>=2021]", "highway/[>=1.0]", "lz4/[>=1.9]", "libpng/[>=1.6]",
                    "pugixml/[>=1.11]", "zlib/[>=1.2]", "openssl/[>=3]"):  # fmt: skip
            self.requires(one)
        for one in ("boost/[>=1.74]", "cli11/[>=2.1]", "eigen/[>=3.4]", "gdcm/[>=3.0]",
                    "nlohmann_json/[>=3.10]", "tomlplusplus/[>=3]"):  # fmt: skip
            self.requires(one, transitive_headers=False)

    def validate(self):
        """C++20 on Linux."""
        check_min_cppstd(self, 20)
        if self.settings.os != "Linux":
            raise ConanInvalidConfiguration(f"expected Linux, found {self.settings.os}")

    def layout(self):
        """Conan's own."""
        cmake_layout(self)

    def generate(self):
        """The toolchain, and packages for find_package."""
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["PLIANT_BUILD_VIEWER"] = False
        toolchain.cache_variables["PLIANT_BUILD_TESTS"] = False
        toolchain.generate()

    def build(self):
        """All that is installed."""
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        """By CMake."""
        CMake(self).install()

    def package_info(self):
        """Users find the package's own CMake files."""
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = ["lib/cmake/pliant"]
