// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Meshes as plain values: hexahedra, tetrahedra, triangles. Nodes are positions in the world; cells
// are lists of corners. Hexahedra have VTK's corner order:
//
//        7───────6        local axes   face   its corners, outward by the right hand
//       /|      /|         t            0     −r: 0 4 7 3
//      4───────5 |         | s          1     +r: 1 2 6 5
//      | 3─────|─2         |/           2     −s: 0 1 5 4
//      |/      |/          0── r        3     +s: 3 7 6 2
//      0───────1                        4     −t: 0 3 2 1
//                                       5     +t: 4 5 6 7
//
// @code
//   const HexMesh block = hex_mesh({.size = {10, 10, 10}, .spacing_mm = {1, 1, 1}});
//   if (const Status s = check_mesh(block); !s.ok()) std::puts(s.error().message.c_str());
// @endcode

#pragma once

#include <pliant/core/record.h>
#include <pliant/core/tasks.h>
#include <pliant/core/vec.h>
#include <pliant/result.h>

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)
namespace pliant {

struct HexMesh {
    std::vector<Vec3d> nodes_mm;
    std::vector<std::array<std::int32_t, 8>> cells;
};

struct TetMesh {
    std::vector<Vec3d> nodes_mm;
    /// Positive orientation: (b−a)×(c−a) points to the last corner.
    std::vector<std::array<std::int32_t, 4>> cells;
};

struct TriangleMesh {
    std::vector<Vec3d> nodes_mm;
    std::vector<std::array<std::int32_t, 3>> cells;
};

/// Box of nodes along the world's axes, i fastest, for large regular solids.
struct HexLattice {
    Vec3i size{2, 2, 2};  ///< nodes along x, y, z; one cell less
    Vec3d spacing_mm{1, 1, 1};
    Vec3d origin_mm{0, 0, 0};  ///< position of node (0, 0, 0)
};

constexpr std::int64_t node_count(const HexLattice& l) {
    return std::int64_t(l.size.x) * l.size.y * l.size.z;
}
constexpr std::int64_t cell_count(const HexLattice& l) {
    return std::int64_t(l.size.x - 1) * (l.size.y - 1) * (l.size.z - 1);
}
/// @pre ijk is inside
constexpr std::int32_t node_index(const HexLattice& l, Vec3i p) {
    return p.x + l.size.x * (p.y + l.size.y * p.z);
}
constexpr std::int32_t cell_index(const HexLattice& l, Vec3i p) {
    return p.x + (l.size.x - 1) * (p.y + (l.size.y - 1) * p.z);
}
Vec3d node_position_mm(const HexLattice& lattice, std::int32_t node);
std::array<std::int32_t, 8> cell_corners(const HexLattice& lattice, std::int32_t cell);

/// @returns InvalidArgument that names the field; at most 2³⁰ nodes
Status check_lattice(const HexLattice& lattice);

// @pre check_lattice accepts the lattice.

/// Converts a lattice. Nodes and cells keep their numbers.
HexMesh hex_mesh(const HexLattice& lattice);
/// Splits each cell into six tetrahedra around the diagonal from corner 0 to corner 6, so that
/// neighbours conform.
TetMesh tet_mesh(const HexLattice& lattice);

/// One of a hexahedron's six quadrilaterals; see the drawing.
struct HexFace {
    std::int32_t cell = 0;
    int face = 0;
    friend constexpr bool operator==(const HexFace&, const HexFace&) = default;
};
inline constexpr int kHexFaceCorners[6][4] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                              {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};

/// Faces of one cell only, in the order of the cells.
std::vector<HexFace> boundary_faces(const HexMesh& mesh);
/// The boundary, each quadrilateral as two triangles; unused nodes are left out.
TriangleMesh boundary_triangles(const HexMesh& mesh);

/// For each node, the number of its connected piece, from 0 in the order of their first nodes. A
/// node without cells is a piece. @pre check_cells accepts the mesh
std::vector<std::int32_t> pieces(const HexMesh& mesh);
std::vector<std::int32_t> pieces(const TetMesh& mesh);
std::vector<std::int32_t> pieces(const TriangleMesh& mesh);

/// Flatter cells are refused. Ratio of the determinant at a corner (triangles: the cross product)
/// to the product of the lengths of the edges there.
inline constexpr double kFlattestCorner = 1e-6;

/// Checks each cell: its nodes exist, are finite and distinct, and it is neither inverted nor flat.
/// @returns InvalidArgument that names the cell and node
Status check_cells(const HexMesh& mesh);
Status check_cells(const TetMesh& mesh);
Status check_cells(const TriangleMesh& mesh);

/// Also checks that each node is used and the mesh is one piece.
Status check_mesh(const HexMesh& mesh);
Status check_mesh(const TetMesh& mesh);
Status check_mesh(const TriangleMesh& mesh);

// Signed distance to a triangle surface: exact, by a bounding volume hierarchy. The sign comes from
// the pseudonormal at the nearest point [Baerentzen2005]. The pseudonormal of a triangle is its
// normal, that of an edge the mean of its two triangles', that of a node the mean weighted by the
// triangles' angles. With these normals, (x − nearest)·normal has the correct sign everywhere
// around a closed surface.
//
// @code
//   const auto distance = SurfaceDistance::create(surface);   // closed, oriented
//   if (distance) std::printf("%g\n", distance->signed_mm({0, 0, 0}));  // negative inside
// @endcode

/// Edge statistics of a triangle surface.
struct SurfaceTopology {
    std::int64_t edges = 0;
    std::int64_t open_edges = 0;          ///< edges of one triangle
    std::int64_t non_manifold_edges = 0;  ///< non-manifold edges, of three or more triangles
    std::int64_t disagreeing_edges = 0;   ///< edges that two triangles traverse in the same
                                          ///< direction
    std::int64_t pinched_nodes = 0;       ///< nodes whose triangles form more than one fan
    std::int64_t pieces = 0;              ///< components connected through shared nodes
    std::int64_t euler = 0;               ///< used nodes − edges + triangles

    bool closed_manifold() const {
        return open_edges == 0 && non_manifold_edges == 0 && disagreeing_edges == 0 &&
               pinched_nodes == 0;
    }
};
/// @pre the triangles name nodes below node_count
SurfaceTopology surface_topology(std::span<const std::array<std::int32_t, 3>> triangles,
                                 std::size_t node_count);
SurfaceTopology surface_topology(const TriangleMesh& surface);

/// Checks that a surface has an inside: closed, consistently oriented, not folded back on itself.
/// @returns InvalidArgument that names the fault
Status check_closed(const TriangleMesh& surface);

/// Enclosed volume [mm³], negative if the triangles face inwards.
double enclosed_volume_mm3(const TriangleMesh& surface);

/// Thread safety: immutable.
class SurfaceDistance {
  public:
    /// @returns InvalidArgument if the surface isn't closed (check_closed) or has a flat cell
    static Result<SurfaceDistance> create(TriangleMesh surface);
    SurfaceDistance(SurfaceDistance&&) noexcept;
    SurfaceDistance& operator=(SurfaceDistance&&) noexcept;
    ~SurfaceDistance();

    struct Nearest {
        double distance_mm = std::numeric_limits<double>::infinity();  ///< negative inside
        Vec3d position_mm{0, 0, 0};                                    ///< on the surface
        std::int32_t triangle = -1;  ///< the first of equally near ones; −1: none within reach
    };
    /// @param within_mm  farther triangles are ignored
    Nearest nearest(Vec3d x_mm, double within_mm = std::numeric_limits<double>::infinity()) const;
    double signed_mm(Vec3d x_mm) const { return nearest(x_mm).distance_mm; }
    const TriangleMesh& surface() const;

  private:
    struct Impl;
    explicit SurfaceDistance(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

/// Contents of a mesh's file (mesh_files.h), as far as Pliant uses them. Polygons are split into
/// triangles.
struct MeshData {
    std::vector<Vec3d> nodes_mm;
    std::vector<std::array<std::int32_t, 4>> tetrahedra;
    std::vector<std::array<std::int32_t, 3>> triangles;
    std::vector<std::vector<std::int32_t>> lines;  ///< two nodes or more each
    /// Numbers at the nodes, the components of one node contiguous.
    struct Field {
        std::string name;
        std::size_t components = 1;
        std::vector<double> values;
    };
    std::vector<Field> node_fields;
    std::vector<Field> tetrahedron_fields;  ///< numbers of the tetrahedra, such as labels; VTU only
    std::vector<std::string> notes;         ///< remarks of the reader, one line each

    const Field* field(std::string_view name) const { return find(node_fields, name); }
    const Field* tetrahedron_field(std::string_view name) const {
        return find(tetrahedron_fields, name);
    }

  private:
    static const Field* find(const std::vector<Field>& fields, std::string_view name) {
        for (const Field& f : fields)
            if (f.name == name) return &f;
        return nullptr;
    }
};

/// Largest distance of a node from the origin [mm]. Patients and treatment rooms are smaller; one
/// distant node would cause lattices of millions of cells.
inline constexpr double kMaxNodeDistanceMm = 1e4;

/// Merges nodes in equal positions and drops collapsed triangles.
TriangleMesh joined(const TriangleMesh& surface);
/// Likewise, for surfaces of other programs: drops repeated triangles, and merges nodes that are
/// within 10⁻⁵ of the extent if that closes edges and collapses no triangle.
/// @param[out] notes  grows by a line for each change; may be null
TriangleMesh cleaned(const TriangleMesh& surface, std::vector<std::string>* notes = nullptr);
/// Swaps two corners of tetrahedra in mirrored order. A tetrahedron in the order of its neighbours
/// stays inverted, because the mesh is folded there.
/// @returns number of turned tetrahedra
std::int64_t turn_mirrored(std::span<const Vec3d> nodes_mm,
                           std::span<std::array<std::int32_t, 4>> cells);

// Quality and boundary of tetrahedral meshes, and points embedded in them.

/// Faces of one tetrahedron only, outward, with the mesh's node numbers, in the order of the cells.
/// @param[out] cells  tetrahedron of each face; may be null
std::vector<std::array<std::int32_t, 3>> boundary_faces(const TetMesh& mesh,
                                                        std::vector<std::int32_t>* cells = nullptr);
/// Boundary as a separate mesh. @param[out] nodes  the tetrahedral mesh's node for each; may be
/// null
TriangleMesh boundary_triangles(const TetMesh& mesh, std::vector<std::int32_t>* nodes = nullptr);
/// Extracts triangles, with the nodes that they use in their order.
TriangleMesh part_of(std::span<const Vec3d> nodes_mm,
                     std::span<const std::array<std::int32_t, 3>> triangles,
                     std::vector<std::int32_t>* nodes = nullptr);

struct TetQuality {
    std::int64_t nodes = 0, tetrahedra = 0;
    std::int64_t inverted = 0;  ///< of zero or negative volume
    double volume_mm3 = 0;
    double min_dihedral_deg = 180, largest_dihedral_deg = 0;
    double min_radius_ratio = 1;  ///< 3 · inscribed / circumscribed radius, 1 where regular
    double mean_radius_ratio = 0;
    double shortest_edge_mm = 0, longest_edge_mm = 0;
    std::int64_t pieces = 0;
    std::int64_t non_manifold_faces = 0;  ///< shared by three or more tetrahedra
    SurfaceTopology boundary;
};
/// @pre the cells name nodes that exist
TetQuality tet_quality(const TetMesh& mesh);
/// Checks that a mesh suits simulation: no inverted cells, and a closed manifold boundary.
/// @returns InvalidArgument that names the fault
Status check_quality(const TetQuality& quality);
/// Readable text, one line per figure, without a newline at the end.
std::string describe(const TetQuality& quality);

/// Removes unused nodes.
TetMesh with_used_nodes(const TetMesh& mesh);
/// Removes cells at edges and nodes where the boundary touches itself, until it is a manifold.
/// @returns number of removed cells
std::int64_t make_manifold(TetMesh& mesh);
/// Removes pieces of less than 1 % of the largest: islands, and fragments from coarse cells.
/// @returns number of removed pieces
int drop_crumbs(TetMesh& mesh);

/// Whether a position is inside of a tetrahedron or on its boundary; false if the tetrahedron is
/// flat.
bool is_inside_tetrahedron(Vec3d position, const std::array<Vec3d, 4>& corners);

/// A point embedded in a tetrahedron: the weighted mean of its corners.
struct Embedded {
    std::int32_t tetrahedron = 0;
    std::array<double, 4> weights{};  ///< sum 1; some are negative if the point is slightly outside
};
constexpr Vec3d position_of(const Embedded& e, const TetMesh& mesh) {
    Vec3d sum{0, 0, 0};
    for (std::size_t n = 0; n < 4; ++n)
        sum = sum +
              e.weights[n] * mesh.nodes_mm[std::size_t(mesh.cells[std::size_t(e.tetrahedron)][n])];
    return sum;
}
/// Finds the tetrahedron that contains each point, or the nearest one; the first of several.
/// @pre the mesh has cells, none inverted or flat
std::vector<Embedded> embed(std::span<const Vec3d> points_mm, const TetMesh& mesh,
                            const TaskArena& arena);

// Tetrahedra inside of a level set: isosurface stuffing [Labelle2007]. A body-centred cubic lattice
// covers the solid. Lattice nodes near the surface are warped onto it, the other edges that cross
// it are cut, and a stencil replaces each tetrahedron:
//
//        +────────+           nodes of the cubes and centres of the cubes;
//       /|  ·    /|           long edges join cubes' corners, or centres of neighbours,
//      / |    · / |           short edges a centre with its cube's eight corners
//     +────────+  |
//
// All dihedral angles are between 10.7° and 164.8° for every function. Sharp edges of the solid are
// rounded off; parts thinner than a cell may be lost.
//
// @code
//   const auto ball = [](Vec3d x) { return 10 - norm(x); };
//   const auto mesh = stuff_isosurface(ball, {.begin_mm = {-11, -11, -11}, .end_mm = {11, 11, 11},
//                                             .cell_mm = 1}, arena);
// @endcode

/// Positive inside of the solid, zero on its surface, continuous. Called from many threads.
using LevelFunction = std::function<double(Vec3d x_mm)>;

struct StuffingSettings {
    Vec3d begin_mm{0, 0, 0}, end_mm{0, 0, 0};  ///< box around the solid
    double cell_mm = 1;                        ///< edge of the lattice's cubes
    /// A node is warped to the intersection of one of its edges with the surface if that is nearer
    /// than this fraction of the edge. The angle bounds hold for these two values.
    double alpha_long = 0.24999, alpha_short = 0.41189;
    /// The function has a Lipschitz constant of 1, as distances do: points far from the surface are
    /// then not evaluated.
    bool changes_as_distance = false;
    std::int64_t max_cells = std::int64_t(1) << 25;
};

/// Stuffs a level set. The result is equal for any number of threads. The boundary's nodes lie on
/// the surface (to 1e-9 of a cell).
/// @returns InvalidArgument for settings out of range, a function that isn't finite, a solid that
///          reaches the box's border or is empty; LimitExceeded
Result<TetMesh> stuff_isosurface(const LevelFunction& level, const StuffingSettings& settings,
                                 const TaskArena& arena);

struct FillSettings {
    double cell_mm = 0;  ///< edge of the lattice's cubes; 0: it follows from the number
    std::int64_t tetrahedra = 20'000;

    friend bool operator==(const FillSettings&, const FillSettings&) = default;
};
SettingRows<FillSettings> fill_rows() noexcept;

/// The solid that a surface encloses.
struct FilledSurface {
    TetMesh mesh;
    double cell_mm = 0;
    double surface_mm3 = 0;          ///< volume that the surface encloses
    std::int64_t removed_cells = 0;  ///< where the boundary would have touched itself
    int dropped_pieces = 0;          ///< by drop_crumbs
};

/// Fills a closed surface with tetrahedra, by stuff_isosurface on its signed distance. Triangles
/// may all face inwards.
/// @returns InvalidArgument for settings out of range, a surface that isn't closed (check_closed),
///          and cells as large as the solid; LimitExceeded
Result<FilledSurface> fill_surface(TriangleMesh surface, const FillSettings& settings,
                                   const TaskArena& arena) noexcept;

}  // namespace pliant
#pragma GCC visibility pop
