# libpng. libpng licence (permissive). Writes pictures.
find_package(PNG REQUIRED)
