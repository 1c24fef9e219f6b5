# CLI11. BSD-3-Clause. The program's command line.
find_package(CLI11 REQUIRED)
