# GoogleTest. BSD-3-Clause. Tests only.
find_package(GTest REQUIRED)
