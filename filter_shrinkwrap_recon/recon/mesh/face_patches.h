// Sets of faces, and what is around them.
#pragma once

#include <functional>
#include <vector>

#include "mesh/surface_mesh.h"

namespace shrinkwrap {

/// The faces that have one of these vertices, ascending.
std::vector<Index> faces_around(const SurfaceMesh& mesh, const std::vector<Index>& vertices);

/// The vertices of these faces, ascending.
std::vector<Index> corners_of(const SurfaceMesh& mesh, const std::vector<Index>& faces);

/// These faces and so many rings of faces around them, ascending if there are any.
std::vector<Index> faces_near(const SurfaceMesh& mesh, std::vector<Index> faces, int rings);

/// The edges of these faces: one half-edge each, ascending.
std::vector<Index> edges_of(const SurfaceMesh& mesh, const std::vector<Index>& faces);

/// The border of a set of faces in loops of half-edges, each from where the one before it ends,
/// that belong to faces of the set, their twins to others. No loop passes a vertex twice, and each
/// has three half-edges or more. `is_in`: per face; none removed. O(F).
std::vector<std::vector<Index>> border_loops_of(const SurfaceMesh& mesh,
                                                const std::vector<char>& is_in);

/// These faces (ascending) in sets that do not touch each other, each ascending, the smallest
/// first. `linked` (optional): other faces that are to be in the set of a face, if they are given.
std::vector<std::vector<Index>> clusters_of(
    const SurfaceMesh& mesh, const std::vector<Index>& faces,
    const std::function<const std::vector<Index>&(Index)>& linked = nullptr);

}  // namespace shrinkwrap
