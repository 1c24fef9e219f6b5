# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
#
# The archive of a release is named by the environment, as packaging/README.md says.

class Pliant < Formula
  desc "Real-time soft-tissue deformation and virtual endoscopy for medical scans"
  url ENV.fetch("HOMEBREW_PLIANT_ARCHIVE")
  version "0.2.0"
  sha256 ENV.fetch("HOMEBREW_PLIANT_SHA256")
  license "Apache-2.0"

  depends_on "boost" => :build
  depends_on "cli11" => :build
  depends_on "cmake" => :build
  depends_on "eigen" => :build
  depends_on "ninja" => :build
  depends_on "nlohmann-json" => :build
  depends_on "tomlplusplus" => :build
  depends_on "gdcm"
  depends_on "highway"
  depends_on "libpng"
  depends_on :linux
  depends_on "lz4"
  depends_on "openssl@3"
  depends_on "pugixml"
  depends_on "tbb"
  uses_from_macos "zlib"

  def install
    system "cmake", "-S", ".", "-B", "build", "-G", "Ninja", "-DPLIANT_BUILD_VIEWER=OFF",
           "-DPLIANT_BUILD_TESTS=OFF", *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    system bin/"pliant", "phantom", "airway", "--size", "48", "--out", "airway.nrrd"
    system bin/"pliant", "deform", "airway.nrrd", "--push", "2.5,-1,-9:6,0,0",
           "--tool", "sphere:3", "--out", "pushed.nrrd"
    assert_path_exists testpath/"pushed.nrrd"
  end
end
