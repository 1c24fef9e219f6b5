# oneTBB. Apache-2.0. Schedules data-parallel loops.
find_package(TBB REQUIRED)
