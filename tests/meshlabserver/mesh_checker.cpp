// mesh_checker MESH [CLOUD.ply]: what a mesh is, by vcglib alone, one `key value` a line. PLY, OFF,
// or STL, whose corners are merged where their coordinates are equal, as a printer's program does.
// Shares no code with the reconstruction, so that neither can hide an error of the other.
#include <vcg/complex/algorithms/clean.h>
#include <vcg/complex/complex.h>
#include <wrap/io_trimesh/import_off.h>
#include <wrap/io_trimesh/import_ply.h>
#include <wrap/io_trimesh/import_stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>
#include <wrap/ply/plylib.cpp>

namespace {

class Vertex;
class Face;
struct Types : vcg::UsedTypes<vcg::Use<Vertex>::AsVertexType, vcg::Use<Face>::AsFaceType> {};
class Vertex
    : public vcg::Vertex<Types, vcg::vertex::Coord3f, vcg::vertex::Normal3f, vcg::vertex::Qualityf,
                         vcg::vertex::Color4b, vcg::vertex::BitFlags, vcg::vertex::Mark> {};
class Face : public vcg::Face<Types, vcg::face::VertexRef, vcg::face::Normal3f, vcg::face::FFAdj,
                              vcg::face::BitFlags, vcg::face::Mark> {};
class Mesh : public vcg::tri::TriMesh<std::vector<Vertex>, std::vector<Face>> {};

using Point = std::array<float, 3>;

// Finite positions, -0 as 0, sorted.
std::vector<Point> sorted_positions(const Mesh& mesh) {
  std::vector<Point> points;
  for (const Vertex& vertex : mesh.vert) {
    const auto& p = vertex.cP();
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))
      points.push_back({p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f});
  }
  std::sort(points.begin(), points.end());
  return points;
}

template <class Importer>
bool load_with(Mesh& mesh, const char* file) {
  int mask = 0;
  const int error = Importer::Open(mesh, file, mask);
  if (error == 0) return true;
  std::fprintf(stderr, "%s: %s\n", file, Importer::ErrorMsg(error));
  return false;
}

bool load(Mesh& mesh, const std::string& file) {
  using namespace vcg::tri;
  const std::string ending = file.substr(file.find_last_of('.') + 1);
  if (ending == "off") return load_with<io::ImporterOFF<Mesh>>(mesh, file.c_str());
  if (ending != "stl") return load_with<io::ImporterPLY<Mesh>>(mesh, file.c_str());
  if (!load_with<io::ImporterSTL<Mesh>>(mesh, file.c_str())) return false;
  Clean<Mesh>::RemoveDuplicateVertex(mesh);
  Allocator<Mesh>::CompactEveryVector(mesh);
  return true;
}

double signed_volume(const Mesh& mesh) {
  double six_volumes = 0.0;
  for (const Face& face : mesh.face) {
    const auto a = vcg::Point3d::Construct(face.cP(0)), b = vcg::Point3d::Construct(face.cP(1)),
               c = vcg::Point3d::Construct(face.cP(2));
    six_volumes += a * (b ^ c);
  }
  return six_volumes / 6.0;
}

void report_topology(Mesh& mesh) {
  using Clean = vcg::tri::Clean<Mesh>;
  vcg::tri::UpdateTopology<Mesh>::FaceFace(mesh);
  const int bad_edges = Clean::CountNonManifoldEdgeFF(mesh);
  const int bad_vertices = Clean::CountNonManifoldVertexFF(mesh);
  int edges = 0, border_edges = 0, other_edges = 0;
  Clean::CountEdgeNum(mesh, edges, border_edges, other_edges);
  const bool is_manifold = mesh.FN() > 0 && bad_edges == 0 && bad_vertices == 0;
  const bool is_closed = is_manifold && border_edges == 0;
  const int components = Clean::CountConnectedComponents(mesh);
  std::printf("vertices %d\nfaces %d\nedges %d\nborder_edges %d\n", mesh.VN(), mesh.FN(), edges,
              border_edges);
  std::printf("nonmanifold_edges %d\nnonmanifold_vertices %d\n", bad_edges, bad_vertices);
  std::printf("manifold %d\nclosed %d\ncoherent %d\n", is_manifold, is_closed,
              mesh.FN() > 0 && Clean::IsCoherentlyOrientedMesh(mesh));
  std::printf("unreferenced %d\n", Clean::CountUnreferencedVertex(mesh));
  std::printf("components %d\n", components);
  if (is_closed) {
    std::printf("genus %d\n", components - (mesh.VN() - edges + mesh.FN()) / 2);
    std::printf("outward %d\n", signed_volume(mesh) > 0.0);
  }
}

void report_matching(const Mesh& mesh, const Mesh& cloud) {
  const std::vector<Point> vertices = sorted_positions(mesh);
  std::vector<Point> samples = sorted_positions(cloud);
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  std::size_t matched = 0, twice = 0;
  for (const Point& sample : samples) {
    const auto range = std::equal_range(vertices.begin(), vertices.end(), sample);
    if (range.second - range.first == 1) ++matched;
    if (range.second - range.first > 1) ++twice;
  }
  std::printf("samples %zu\nmatched %zu\nmatched_twice %zu\n", samples.size(), matched, twice);
  std::printf("complete %d\n", matched == samples.size() && mesh.vert.size() == samples.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  Mesh mesh, cloud;
  if (!load(mesh, argv[1])) return 1;
  if (argc > 2 && !load(cloud, argv[2])) return 1;
  report_topology(mesh);
  if (argc > 2) report_matching(mesh, cloud);
  return 0;
}
