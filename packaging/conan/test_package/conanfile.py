# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Builds examples/consumer with the package and runs it."""

import pathlib

from conan import ConanFile
from conan.tools.build import can_run
from conan.tools.cmake import CMake, cmake_layout


class Consumer(ConanFile):
    """A program of README.md."""

    settings = ("os", "arch", "compiler", "build_type")
    generators = ("CMakeDeps", "CMakeToolchain")
    test_type = "explicit"

    def requirements(self):
        """The package under test."""
        self.requires(self.tested_reference_str)

    def layout(self):
        """Conan's own."""
        cmake_layout(self)

    def build(self):
        """The example that the installed library is tested with."""
        example = pathlib.Path(self.recipe_folder).parent.parent.parent / "examples/consumer"
        cmake = CMake(self)
        cmake.configure(build_script_folder=str(example))
        cmake.build()

    def test(self):
        """Pushes a wall."""
        if can_run(self):
            self.run(f"{self.cpp.build.bindir}/consumer . --check", env="conanrun")
