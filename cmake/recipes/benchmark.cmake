# Google Benchmark. Apache-2.0. Benchmarks only.
find_package(benchmark REQUIRED)
