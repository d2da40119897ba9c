#include "files.h"

#include <unistd.h>
#include <vcg/complex/complex.h>
#include <wrap/io_trimesh/export_ply.h>
#include <wrap/io_trimesh/import.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "attempt.h"
#include "shapes.h"
#include "shrinkwrap_reconstruct.h"
#include "surface_mesh_from_vcg.h"

namespace shrinkwrap::robustness {
namespace {

using testing::Random;

class Vertex;
class Face;
struct Types : vcg::UsedTypes<vcg::Use<Vertex>::AsVertexType, vcg::Use<Face>::AsFaceType> {};
class Vertex
    : public vcg::Vertex<Types, vcg::vertex::Coord3f, vcg::vertex::Normal3f, vcg::vertex::Color4b,
                         vcg::vertex::Qualityf, vcg::vertex::BitFlags, vcg::vertex::Mark> {};
class Face : public vcg::Face<Types, vcg::face::VertexRef, vcg::face::Normal3f, vcg::face::Color4b,
                              vcg::face::FFAdj, vcg::face::BitFlags, vcg::face::Mark> {};
class Mesh : public vcg::tri::TriMesh<std::vector<Vertex>, std::vector<Face>> {
 public:
  ~Mesh() { ClearAttributes(); }  // which vcglib's own destructor leaves to the user
};

struct File {
  std::string extension, content;
  Index points = 0;
  int damages = 0;
};

// --- whole files ---------------------------------------------------------------------------------

// Samples of a sphere, and sometimes triangles between any three of them.
struct Content {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
};

Content random_content(Random& random) {
  Content content;
  const Index count = 20 + random.below(800);
  for (Index i = 0; i < count; ++i) content.points.emplace_back(random.direction());
  if (random.uniform() < 0.3)
    for (Index i = 0; i < count; ++i)
      content.triangles.push_back({random.below(count), random.below(count), random.below(count)});
  return content;
}

enum class Encoding { ascii, little_endian, big_endian };

class PlyWriter {
 public:
  PlyWriter(Encoding encoding, Random& random) : encoding_(encoding), random_(random) {}

  std::string write(const Content& content) {
    static constexpr const char* formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    // What may stand before, between and after the coordinates.
    std::vector<std::string> properties = {"x", "y", "z"};
    // vcglib's importer does not swap the bytes of doubles.
    const bool are_floats = random_.uniform() < 0.7 || encoding_ == Encoding::big_endian;
    const std::string type = are_floats ? "float" : "double";
    for (const char* more : {"nx", "quality", "confidence", "s"})
      if (random_.uniform() < 0.3)
        properties.insert(properties.begin() + random_.below(static_cast<Index>(properties.size())),
                          more);
    text_ = std::string("ply\nformat ") + formats[static_cast<int>(encoding_)] + " 1.0\n";
    if (random_.uniform() < 0.5) text_ += "comment of no use\nobj_info nor is this\n";
    text_ += "element vertex " + std::to_string(content.points.size()) + "\n";
    for (const std::string& name : properties) text_ += "property " + type + " " + name + "\n";
    if (!content.triangles.empty())
      text_ += "element face " + std::to_string(content.triangles.size()) +
               "\nproperty list uchar int vertex_indices\n";
    text_ += "end_header\n";
    for (const Vec3& p : content.points) {
      for (const std::string& name : properties) {
        const double value = name.size() == 1 && name[0] >= 'x' ? p[name[0] - 'x'] : 0.25;
        if (type == "float")
          put(static_cast<float>(value));
        else
          put(value);
      }
      end_line();
    }
    for (const Triangle& triangle : content.triangles) {
      put(static_cast<unsigned char>(3));
      for (const Index v : triangle) put(v);
      end_line();
    }
    return std::move(text_);
  }

 private:
  template <class Number>
  void put(Number number) {
    if (encoding_ == Encoding::ascii) {
      std::ostringstream stream;
      stream.precision(17);
      stream << +number << ' ';
      text_ += stream.str();
      return;
    }
    char bytes[sizeof(Number)];
    std::memcpy(bytes, &number, sizeof bytes);
    if (encoding_ == Encoding::big_endian) std::reverse(bytes, bytes + sizeof bytes);
    text_.append(bytes, sizeof bytes);
  }
  void end_line() {
    if (encoding_ == Encoding::ascii) text_ += '\n';
  }

  Encoding encoding_;
  Random& random_;
  std::string text_;
};

std::string write_off(const Content& content) {
  std::ostringstream out;
  out << "OFF\n" << content.points.size() << ' ' << content.triangles.size() << " 0\n";
  for (const Vec3& p : content.points) out << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  for (const auto& [a, b, c] : content.triangles) out << "3 " << a << ' ' << b << ' ' << c << '\n';
  return out.str();
}

std::string write_obj(const Content& content) {
  std::ostringstream out;
  out << "# points\n";
  for (const Vec3& p : content.points) out << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  for (const auto& [a, b, c] : content.triangles)
    out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
  return out.str();
}

std::string write_stl(const Content& content) {
  std::ostringstream out;
  out << "solid points\n";
  const auto vertex = [&](Index v) {
    const Vec3& p = content.points[static_cast<std::size_t>(v)];
    out << "vertex " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  };
  for (const auto& [a, b, c] : content.triangles) {
    out << "facet normal 0 0 1\nouter loop\n";
    for (const Index v : {a, b, c}) vertex(v);
    out << "endloop\nendfacet\n";
  }
  out << "endsolid points\n";
  return out.str();
}

// --- damage --------------------------------------------------------------------------------------

std::size_t any_place(const std::string& text, Random& random) {
  return static_cast<std::size_t>(random.below(static_cast<Index>(text.size())));
}

// Half of the time near the beginning, where headers are.
std::size_t any_word(const std::string& text, Random& random) {
  const std::size_t within =
      random.uniform() < 0.5 ? std::min<std::size_t>(text.size(), 300) : text.size();
  const std::size_t place = static_cast<std::size_t>(random.below(static_cast<Index>(within)));
  const std::size_t blank = text.find_first_of(" \n", place);
  return blank == std::string::npos ? place : std::min(blank + 1, text.size() - 1);
}

void damage(std::string& text, Random& random) {
  static constexpr std::array<const char*, 12> words = {"nan",         "inf",  "-inf", "1e400",
                                                        "-1",          "0",    "",     "2147483648",
                                                        "99999999999", "word", "1e30", "3"};
  if (text.empty()) return;
  const std::size_t word = any_word(text, random);
  const std::size_t word_end = std::min(text.find_first_of(" \n", word), text.size());
  switch (random.below(7)) {
    case 0:
      text.resize(any_place(text, random));
      return;
    case 1:
      for (Index i = 1 + random.below(8); i > 0; --i)
        text[any_place(text, random)] = static_cast<char>(random.below(256));
      return;
    case 2:
      text.replace(word, word_end - word,
                   words[static_cast<std::size_t>(random.below(static_cast<Index>(words.size())))]);
      return;
    case 3:  // lines as of another system
      for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += 2)
        text.replace(i, 1, "\r\n");
      return;
    case 4: {  // a line lost
      const std::size_t end = text.find('\n', word);
      if (end != std::string::npos) text.erase(word, end - word + 1);
      return;
    }
    case 5:  // a part twice
      text.insert(word, text.substr(word, static_cast<std::size_t>(random.below(200))));
      return;
    default:  // bytes that are no text
      text.insert(any_place(text, random), std::string(1 + random.below(40), '\0'));
  }
}

File make_file(std::uint64_t number) {
  Random random(number ^ 0x66696c6573ull);
  File file;
  const Content content = random_content(random);
  file.points = static_cast<Index>(content.points.size());
  switch (random.below(8)) {
    case 0:
      file.extension = "off";
      file.content = write_off(content);
      break;
    case 1:
      file.extension = "obj";
      file.content = write_obj(content);
      break;
    case 2:
      file.extension = "stl";
      file.content = write_stl(content);
      break;
    default:
      file.extension = "ply";
      file.content = PlyWriter(static_cast<Encoding>(random.below(3)), random).write(content);
  }
  if (random.uniform() < 0.9) file.damages = 1 + random.below(3);
  for (int i = 0; i < file.damages; ++i) damage(file.content, random);
  return file;
}

// --- import, reconstruct, judge ------------------------------------------------------------------

// A place for a file, which is removed at the end.
class TemporaryPath {
 public:
  explicit TemporaryPath(const std::string& ending)
      : path_((std::filesystem::temp_directory_path() /
               ("shrinkwrap_" + std::to_string(getpid()) + ending))
                  .string()) {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);  // of a process that was killed
  }
  TemporaryPath(const TemporaryPath&) = delete;
  TemporaryPath& operator=(const TemporaryPath&) = delete;
  ~TemporaryPath() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  const std::string& name() const { return path_; }

 private:
  std::string path_;
};

using Importer = vcg::tri::io::Importer<Mesh>;

// Reads a file and writes what it read, if anything, to a whole one. Says what the importer
// returned.
void import_and_save(const std::string& from, const std::string& to, const Say& say) {
  Mesh mesh;
  int result = -1;
  bool is_refused = true;
  try {
    result = Importer::Open(mesh, from.c_str());
    is_refused = result < 0 || (result != 0 && Importer::ErrorCritical(result));
  } catch (...) {
  }
  if (!is_refused) vcg::tri::io::ExporterPLY<Mesh>::Save(mesh, to.c_str());
  say(std::to_string(result));
}

// The adapters, on whatever the importer made.
bool adapters_agree(Mesh& cloud, const std::vector<Vec3>& points) {
  Progress silent;
  const ResultMesh own = triangles_from_vcg(cloud);
  measure_mesh(own.position, own.triangles, points, {}, silent);
  Mesh mesh;
  try {
    const Reconstruction result = shrinkwrap_reconstruct(cloud, mesh);
    return mesh.FN() == result.report.faces;
  } catch (const Error& error) {
    return mesh.VN() == 0 && std::strlen(error.what()) > 20;
  }
}

// Some damaged files make vcglib's importers overrun their arrays, which shows only later: they
// work in a process of their own.
void run(const File& file, const JobOptions& job_options, const ChildLimits& limits,
         const Say& say) {
  const TemporaryPath written("." + file.extension), whole(".whole.ply");
  std::ofstream(written.name(), std::ios::binary) << file.content;
  ChildProcess reader(
      [&](const Say& reply) { import_and_save(written.name(), whole.name(), reply); }, limits);
  const ChildOutcome& outcome = reader.wait();
  Attempt made;
  if (outcome.end != ChildOutcome::End::finished) {
    const bool is_whole = file.damages == 0 && file.points > 0;
    made.verdicts = {is_whole ? Verdict::unread_file : Verdict::importer_failed};
    made.figures.add("ended_by", outcome.how);
    say(to_message(made));
    return;
  }
  Mesh cloud;
  if (std::filesystem::exists(whole.name()) && Importer::Open(cloud, whole.name().c_str()) == 0) {
    const std::vector<Vec3> points = points_from_vcg(cloud).points;
    ReconstructionOptions options;
    options.threads = job_options.threads;
    Expectation expectation;
    expectation.resolved = file.damages == 0 && file.points >= 100 && file.extension != "stl";
    made = attempt(points, options, expectation, {false, job_options.time_limit});
    if (!adapters_agree(cloud, points)) made.verdicts.push_back(Verdict::unexpected_exception);
    made.figures.add("points", points.size());
    const bool has_all =
        file.extension == "stl" || static_cast<Index>(points.size()) == file.points;
    if (file.damages == 0 && !has_all) made.verdicts.push_back(Verdict::unread_file);
  } else if (file.damages == 0 && file.points > 0) {
    made.verdicts.push_back(Verdict::unread_file);
  }
  made.figures.add("importer", outcome.output);
  say(to_message(made));
}

}  // namespace

Job file_job(std::uint64_t number, const JobOptions& options) {
  Job job;
  const File file = make_file(number);
  job.description.add("extension", file.extension)
      .add("points_written", file.points)
      .add("damages", file.damages);
  if (options.with_input) job.file = file.content;
  job.limits.memory_bytes = std::uint64_t{2} << 30;
  job.work = [file, options, limits = job.limits](const Say& say) {
    run(file, options, limits, say);
  };
  return job;
}

}  // namespace shrinkwrap::robustness
