// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/core/files.h>
#include <pliant/core/output_file.h>
#include <pliant/core/text.h>
#include <pliant/scan_files.h>
#include <pliant/volume.h>

#include <bit>

namespace pliant {
namespace {

std::string numbers(std::initializer_list<double> values) {
    std::string text;
    for (const double v : values) text += (text.empty() ? "" : " ") + text_of(v);
    return text;
}

std::string header_of(const Volume& volume, const std::string& name) {
    const Grid& g = volume.grid;
    std::string extent;
    for (int a = 0; a < 3; ++a) extent += (a ? " 0 " : "0 ") + std::to_string(g.size[a] - 1);
    const auto& d = g.direction.columns;
    const char* order = std::endian::native == std::endian::big ? "BigEndian" : "LittleEndian";
    // The direction row by row.
    return std::string(
               "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" "
               "byte_order=\"") +
           order + "\" header_type=\"UInt64\">\n<ImageData WholeExtent=\"" + extent +
           "\" Origin=\"" + numbers({g.origin_mm.x, g.origin_mm.y, g.origin_mm.z}) +
           "\" Spacing=\"" + numbers({g.spacing_mm.x, g.spacing_mm.y, g.spacing_mm.z}) +
           "\" Direction=\"" +
           numbers({d[0].x, d[1].x, d[2].x, d[0].y, d[1].y, d[2].y, d[0].z, d[1].z, d[2].z}) +
           "\">\n<Piece Extent=\"" + extent + "\">\n<PointData Scalars=\"" + name +
           "\">\n<DataArray type=\"" + (volume.is_16_bit() ? "Int16" : "Float32") + "\" Name=\"" +
           name +
           "\" format=\"appended\" offset=\"0\"/>\n</PointData>\n</Piece>\n</ImageData>\n"
           "<AppendedData encoding=\"raw\">\n_";
}

}  // namespace

Status write_vti(const std::filesystem::path& path, const Volume& volume, const std::string& name) {
    if (name.empty() || name.find_first_of("<>&\"'") != name.npos)
        return Error{ErrorCode::InvalidArgument,
                     path.string() + ": the name '" + name + "' of its values can't stand in XML"};
    if (Status s = check_volume(volume, path.string()); !s) return s;
    StagedFiles staged;
    const auto target = staged.stage(path);
    if (!target) return target.error();
    OutputFile file(*target, path.string());
    file.write(header_of(volume, name));
    std::visit(
        [&](const auto& voxels) {
            const std::uint64_t length = voxels.size() * sizeof(*voxels.data());
            file.write({reinterpret_cast<const char*>(&length), sizeof length});
            file.write({reinterpret_cast<const char*>(voxels.data()), std::size_t(length)});
        },
        volume.voxels);
    file.write("\n</AppendedData>\n</VTKFile>\n");
    if (Status s = file.close(); !s) return s;
    return staged.commit();
}

}  // namespace pliant
