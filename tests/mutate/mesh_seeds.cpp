// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Seeds: meshes, those of the fuzz targets' corpus.

#include "mutate/formats.h"

namespace pliant::mutate {
namespace {

Format meshes(const Sources& from, const std::string& name, const std::vector<std::string>& files,
              Words words) {
    Format format{.name = name, .words = std::move(words), .seeds = {}};
    for (const std::string& file : files)
        format.seeds.push_back(
            {.name = file,
             .files = {{.name = file, .bytes = corpus_bytes(from.fuzz_corpus / "mesh" / file)}},
             .commands = {"mesh " + file + " --json", "mesh " + file,
                          "mesh " + file + " --out w.vtu --ghost g.ply --threads 1"}});
    return format;
}

}  // namespace

Format surface(const Sources& from) {
    return meshes(from, "surface", {"b.ply", "a.obj", "a.stl", "b.stl", "a.off", "a.mesh"},
                  {"ply\n",
                   "format ascii 1.0\n",
                   "format binary_big_endian 1.0\n",
                   "comment ",
                   "obj_info ",
                   "element vertex ",
                   "element face ",
                   "element edge 3\n",
                   "property float x\n",
                   "property list uchar int vertex_indices\n",
                   "property list uint uint x\n",
                   "property double z\n",
                   "end_header\n",
                   "v ",
                   "vn 0 0 1\n",
                   "vt 0 0\n",
                   "f 1 2 3\n",
                   "f 1//1 2//2 3//3\n",
                   "f -1 -2 -3\n",
                   "f ",
                   "l 1 2\n",
                   "g ",
                   "usemtl ",
                   "s off\n",
                   "#",
                   "\\\n",
                   "f 1 2 3 4 5 6 7 8\n",
                   "OFF\n",
                   "MeshVersionFormatted 2\n",
                   "Dimension 3\n",
                   "Vertices\n",
                   "Tetrahedra\n",
                   "Quadrilaterals\n",
                   "solid ",
                   "facet normal 0 0 1\n",
                   "outer loop\n",
                   "vertex ",
                   "endloop\n",
                   "endfacet\n",
                   "endsolid\n",
                   "vertex 1 2 3\n"});
}

Format vtk(const Sources& from) {
    return meshes(from, "vtk", {"a.vtk", "b.vtk", "v42.vtk"},
                  {"# vtk DataFile Version 4.2\n",
                   "ASCII\n",
                   "BINARY\n",
                   "DATASET UNSTRUCTURED_GRID\n",
                   "DATASET POLYDATA\n",
                   "POINTS ",
                   "CELLS ",
                   "POLYGONS ",
                   "LINES ",
                   "CELL_TYPES ",
                   "OFFSETS vtktypeint64\n",
                   "CONNECTIVITY vtktypeint64\n",
                   "POINT_DATA ",
                   "CELL_DATA ",
                   "FIELD FieldData 1\n",
                   "SCALARS x double 1\n",
                   "LOOKUP_TABLE default\n",
                   "VECTORS v float\n",
                   "METADATA\n",
                   "double",
                   "int",
                   "bit",
                   "vtkIdType"});
}

Format vtk_xml(const Sources& from) {
    return meshes(from, "vtk_xml", {"o.vtp", "ascii.vtu", "bin.vtu", "plain.vtu"},
                  {"<VTKFile type=\"PolyData\">",
                   "<Piece>",
                   "NumberOfPoints=\"",
                   "NumberOfPolys=\"",
                   "NumberOfCells=\"",
                   "<DataArray ",
                   "type=\"Int8\"",
                   "type=\"Float64\"",
                   "format=\"appended\"",
                   "format=\"binary\"",
                   "offset=\"",
                   "header_type=\"UInt32\"",
                   "compressor=\"vtkZLibDataCompressor\"",
                   "byte_order=\"BigEndian\"",
                   "_",
                   "&amp;",
                   "&#0;",
                   "<![CDATA[",
                   "<!-- ",
                   "<!DOCTYPE a [<!ENTITY b \"c\">]>",
                   "&b;",
                   "NumberOfComponents=\"",
                   "RangeMin=\"",
                   "AAAA",
                   "encoding=\"raw\"",
                   "Name=\"connectivity\"",
                   "Name=\"offsets\"",
                   "Name=\"types\""});
}

Format msh(const Sources& from) {
    return meshes(from, "msh", {"g22a.msh", "g22b.msh", "g41a.msh", "g41b.msh"},
                  {"$MeshFormat\n", "$EndMeshFormat\n", "$Nodes\n", "$EndNodes\n", "$Elements\n",
                   "$EndElements\n", "$PhysicalNames\n", "$Entities\n", "$Periodic\n",
                   "$Comments\n", "2.2 0 8\n", "4.1 1 8\n", "4.0 0 8\n", "1 0 4\n", "$NodeData\n"});
}

}  // namespace pliant::mutate
