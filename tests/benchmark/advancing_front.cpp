// advancing_front (--shape NAME --samples N | --cloud FILE.ply [--samples N])
//
// The yardstick: CGAL's advancing front reconstruction of the same points, without reading and
// writing them, as one line of JSON. It interpolates too, needs no normals either, and promises
// neither closed meshes nor all samples.
#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <utility>
#include <vector>

#include "clouds.h"
#include "json_line.h"
#include "process_figures.h"

namespace shrinkwrap::benchmarking {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Facet = std::array<std::size_t, 3>;

std::size_t used_points(const std::vector<Facet>& facets, std::size_t points) {
  std::vector<bool> used(points, false);
  for (const Facet& facet : facets)
    for (const std::size_t corner : facet) used[corner] = true;
  return static_cast<std::size_t>(std::count(used.begin(), used.end(), true));
}

// Edges that are not shared by exactly two faces.
std::size_t open_edges(const std::vector<Facet>& facets) {
  std::vector<std::pair<std::size_t, std::size_t>> edges;
  edges.reserve(3 * facets.size());
  for (const Facet& facet : facets)
    for (int i = 0; i < 3; ++i)
      edges.push_back(std::minmax(facet[static_cast<std::size_t>(i)],
                                  facet[static_cast<std::size_t>((i + 1) % 3)]));
  std::sort(edges.begin(), edges.end());
  std::size_t open = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if (end - i != 2) ++open;
    i = end;
  }
  return open;
}

int run(const CloudChoice& choice) {
  std::vector<Kernel::Point_3> points;
  {
    const std::vector<Vec3> cloud = make_cloud(choice);
    points.reserve(cloud.size());
    for (const Vec3& p : cloud) points.emplace_back(p.x(), p.y(), p.z());
  }
  return_free_memory();
  const std::uint64_t baseline = resident_bytes();
  reset_peak_resident_bytes();

  std::vector<Facet> facets;
  const double processor_before = processor_seconds();
  const Stopwatch watch;
  CGAL::advancing_front_surface_reconstruction(points.begin(), points.end(),
                                               std::back_inserter(facets));
  const double seconds = watch.seconds();
  const double processor = processor_seconds() - processor_before;
  const std::uint64_t peak = peak_resident_bytes();
  const std::uint64_t peak_over = peak > baseline ? peak - baseline : 0;

  std::printf("%s\n", JsonLine()
                          .add("program", "advancing front")
                          .add("cloud", choice.name())
                          .add("samples", points.size())
                          .add("seconds", seconds)
                          .add("processor_seconds", processor)
                          .add("peak_bytes", peak_over)
                          .add("bytes_per_sample",
                               static_cast<double>(peak_over) /
                                   static_cast<double>(std::max<std::size_t>(points.size(), 1)))
                          .add("faces", facets.size())
                          .add("vertices", used_points(facets, points.size()))
                          .add("open_edges", open_edges(facets))
                          .text()
                          .c_str());
  return 0;
}

}  // namespace
}  // namespace shrinkwrap::benchmarking

int main(int argc, char** argv) {
  using namespace shrinkwrap::benchmarking;
  try {
    CloudChoice choice;
    for (int i = 1; i + 1 < argc; i += 2) choice.take(argv[i], argv[i + 1]);
    if (!choice.name().empty()) return run(choice);
    std::fprintf(stderr,
                 "usage: advancing_front (--shape NAME --samples N | --cloud FILE.ply [--samples "
                 "N])\n");
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "advancing_front: %s\n", error.what());
    return 1;
  }
}
