#include "clouds.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include "reconstruct.h"
#include "shapes.h"

namespace shrinkwrap::benchmarking {
namespace {

using testing::Random;

constexpr unsigned kSeed = 1;

std::string folded_name(const std::string& file) {
  const std::size_t begin = file.find_last_of('/') + 1;
  return file.substr(begin, file.find_last_of('.') - begin);
}

std::vector<Vec3> thinned(const std::vector<Vec3>& points, Index count) {
  Random random(kSeed);
  std::vector<Vec3> kept;
  kept.reserve(count);
  // Selection sampling (Knuth): every part of that size is equally likely, and order is kept.
  Index wanted = count, left = static_cast<Index>(points.size());
  for (const Vec3& p : points) {
    if (random.uniform() * left < wanted) {
      kept.push_back(p);
      --wanted;
    }
    --left;
  }
  return kept;
}

// A smooth surface through the cloud, of so many faces that their flatness does not show.
SurfaceMesh smooth_surface(const std::vector<Vec3>& points, Index count) {
  ReconstructionOptions options;
  options.stop_at_parametric_surface = true;
  Progress progress;
  ResultMesh result = reconstruct(points, options, progress).mesh;
  SurfaceMesh mesh = SurfaceMesh::from_triangles(std::move(result.position), result.triangles);
  for (int i = 0; i < 4 && mesh.face_count() < count / 4; ++i) mesh = loop_subdivide(mesh);
  return mesh;
}

std::vector<Vec3> densified(const std::vector<Vec3>& points, Index count) {
  const SurfaceMesh mesh = smooth_surface(points, count);
  std::vector<double> area_up_to(mesh.face_slots());
  double area = 0.0;
  for (Index f = 0; f < mesh.face_slots(); ++f) {
    area += mesh.area_vector(f).norm();
    area_up_to[f] = area;
  }
  Random random(kSeed);
  std::vector<Vec3> samples;
  samples.reserve(count);
  while (static_cast<Index>(samples.size()) < count) {
    const auto found =
        std::upper_bound(area_up_to.begin(), area_up_to.end(), random.uniform() * area);
    const Index f = std::min(static_cast<Index>(found - area_up_to.begin()), mesh.face_slots() - 1);
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    const auto [a, b, c] = mesh.triangle(f);
    samples.push_back(mesh.position[a] + u * (mesh.position[b] - mesh.position[a]) +
                      v * (mesh.position[c] - mesh.position[a]));
  }
  return samples;
}

std::vector<Vec3> sampled_shape(const std::string& name, Index count) {
  std::string known;
  for (const testing::ShapeKind kind : testing::all_shapes()) {
    const std::string& shape = testing::shape_of(kind).name;
    if (shape == name) return testing::sample_shape(kind, count, kSeed);
    known += " " + shape;
  }
  throw InvalidInput("no shape '" + name + "'; there are:" + known);
}

struct PlyHeader {
  std::size_t vertices = 0;
  bool ascii = false;
  bool coordinates_are_double = false;
  std::size_t bytes_per_vertex = 0;
};

std::size_t bytes_of(const std::string& type) {
  if (type == "double" || type == "float64") return 8;
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  return 4;
}

PlyHeader read_header(std::istream& file, const std::string& name) {
  PlyHeader header;
  bool of_vertices = false;
  int coordinates = 0;
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string word, type, property;
    words >> word;
    if (word == "end_header") break;
    if (word == "format") {
      words >> type;
      header.ascii = type == "ascii";
      if (type == "binary_big_endian") throw InvalidInput(name + ": big-endian PLY is not read");
    } else if (word == "element") {
      words >> type;
      of_vertices = type == "vertex";
      if (of_vertices) words >> header.vertices;
    } else if (word == "property" && of_vertices) {
      words >> type >> property;
      if (coordinates < 3 && property == std::string(1, "xyz"[coordinates])) {
        ++coordinates;
        header.coordinates_are_double = bytes_of(type) == 8;
      }
      header.bytes_per_vertex += bytes_of(type);
    }
  }
  if (!file || coordinates < 3) throw InvalidInput(name + ": not a PLY file of points");
  return header;
}

template <class Scalar>
Vec3 coordinates_at(const char* bytes) {
  Scalar p[3];
  std::memcpy(p, bytes, sizeof p);
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

template <class Scalar>
void write_coordinates(std::ostream& file, const std::vector<Vec3>& points) {
  std::vector<Scalar> buffer;
  buffer.reserve(3 * points.size());
  for (const Vec3& p : points)
    for (int axis = 0; axis < 3; ++axis) buffer.push_back(static_cast<Scalar>(p[axis]));
  file.write(reinterpret_cast<const char*>(buffer.data()),
             static_cast<std::streamsize>(buffer.size() * sizeof(Scalar)));
}

}  // namespace

bool CloudChoice::take(const std::string& option, const std::string& value) {
  if (option == "--shape") {
    shape = value;
  } else if (option == "--cloud") {
    file = value;
  } else if (option == "--samples") {
    samples = static_cast<Index>(std::stol(value));
    if (samples <= 0) throw InvalidInput("--samples needs a positive number");
  } else {
    return false;
  }
  return true;
}

std::string CloudChoice::name() const {
  return file.empty() ? shape : folded_name(file);
}

std::vector<Vec3> make_cloud(const CloudChoice& choice) {
  std::vector<Vec3> points;
  if (choice.file.empty()) {
    if (choice.samples == 0) throw InvalidInput("--shape needs --samples");
    points = sampled_shape(choice.shape, choice.samples);
  } else {
    points = read_ply(choice.file);
    if (choice.samples > 0) points = resample(points, choice.samples);
  }
  for (Vec3& p : points) p = rounded_to_single(p);
  return points;
}

std::vector<Vec3> resample(const std::vector<Vec3>& points, Index count) {
  const Index given = static_cast<Index>(points.size());
  if (count == given) return points;
  return count < given ? thinned(points, count) : densified(points, count);
}

std::vector<Vec3> read_ply(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  if (!file) throw InvalidInput("cannot read " + name);
  const PlyHeader header = read_header(file, name);
  std::vector<Vec3> points;
  if (header.ascii) {
    Vec3 p;
    for (std::size_t i = 0; i < header.vertices && file >> p.x() >> p.y() >> p.z(); ++i) {
      points.push_back(p);
      file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
  } else {
    std::vector<char> vertex(header.bytes_per_vertex);
    for (std::size_t i = 0; i < header.vertices; ++i) {
      if (!file.read(vertex.data(), static_cast<std::streamsize>(vertex.size()))) break;
      points.push_back(header.coordinates_are_double ? coordinates_at<double>(vertex.data())
                                                     : coordinates_at<float>(vertex.data()));
    }
  }
  if (points.size() != header.vertices) throw InvalidInput(name + ": the file ends too early");
  return points;
}

void write_ply(const std::string& name, const std::vector<Vec3>& points, bool as_double) {
  std::ofstream file(name, std::ios::binary);
  const std::string type = as_double ? "double" : "float";
  file << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size() << "\nproperty "
       << type << " x\nproperty " << type << " y\nproperty " << type << " z\nend_header\n";
  if (as_double)
    write_coordinates<double>(file, points);
  else
    write_coordinates<float>(file, points);
  file.close();
  if (file.fail()) throw InvalidInput("cannot write " + name);
}

}  // namespace shrinkwrap::benchmarking
