#include "complete_matching/snap_and_insert.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "common/parallel.h"
#include "complete_matching/vertex_removal.h"
#include "mesh/delaunay_flips.h"
#include "mesh/face_tree.h"
#include "mesh/vertex_blocks.h"
#include "parametric_surface/sample_feet.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 10;
constexpr Index kProgressStride = 1 << 11;
constexpr int kCandidates = 8;      // nearest samples among which a vertex chooses by normal
constexpr Index kPollInterval = 8;  // a search that looks at all faces takes a millisecond
constexpr int kRounds = 24;         // of insertion by exact search; few samples are left then
constexpr int kWalkSteps = 64;      // from a face that was near to the nearest around
constexpr Index kLooksPerInsertion = 64;

// A mesh and the samples that its vertices stand for, while it is made.
struct Matching {
  SurfaceMesh mesh;
  std::vector<Index> sample_of_vertex;  // kNone: no sample
  std::vector<Index> isolated;          // samples, ascending
};

// Which sample a vertex wants, and how far it is.
struct Wish {
  Index sample = kNone;
  double squared_distance = std::numeric_limits<double>::infinity();
};

bool has_oriented_normals(const PointCloud& cloud) {
  return !cloud.plane.empty();
}

std::vector<Wish> choose_samples(const SurfaceMesh& mesh, const PointCloud& cloud,
                                 Progress& progress) {
  std::vector<Wish> wishes(mesh.position.size());
  const bool by_normal = has_oriented_normals(cloud);
  parallel_blocks(mesh.vertex_slots(), kGrain, progress, [&](Index, Index begin, Index end) {
    std::vector<VoxelSearch::Hit> hits;
    for (Index v = begin; v < end; ++v) {
      cloud.search.k_nearest(mesh.position[v], by_normal ? kCandidates : 1, hits);
      VoxelSearch::Hit chosen = hits.front();
      if (by_normal) {
        const Vec3f normal = mesh.vertex_normal(v).cast<float>();
        const auto compatible = std::find_if(hits.begin(), hits.end(), [&](const auto& hit) {
          return cloud.normal[hit.index].dot(normal) > 0.0f;
        });
        if (compatible != hits.end()) chosen = *compatible;
      }
      wishes[v] = {chosen.index, chosen.squared_distance};
    }
  });
  return wishes;
}

// Step 1. Vertices that did not get their sample stay where they are.
Matching snap(SurfaceMesh mesh, const PointCloud& cloud, Progress& progress) {
  const std::vector<Wish> wishes = choose_samples(mesh, cloud, progress);
  std::vector<Index> vertex_of_sample(cloud.position.size(), kNone);
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    Index& holder = vertex_of_sample[wishes[v].sample];
    if (holder == kNone || wishes[v].squared_distance < wishes[holder].squared_distance) holder = v;
  }
  Matching matching;
  matching.sample_of_vertex.assign(mesh.position.size(), kNone);
  for (Index s = 0; s < cloud.size(); ++s) {
    const Index v = vertex_of_sample[s];
    if (v == kNone) {
      matching.isolated.push_back(s);
    } else {
      matching.sample_of_vertex[v] = s;
      mesh.position[v] = cloud.position[s];
    }
  }
  matching.mesh = std::move(mesh);
  return matching;
}

// Step 2; again at the end, when a vertex may go that the topology could not do without before.
VertexRemovalReport remove_unmatched(Matching& matching, Progress& progress) {
  SurfaceMesh& mesh = matching.mesh;
  std::vector<char> is_marked(mesh.position.size(), 0);
  for (Index v = 0; v < mesh.vertex_slots(); ++v)
    if (matching.sample_of_vertex[v] == kNone) is_marked[v] = 1;
  const VertexBlocks blocks(mesh.position, progress);
  const VertexRemovalReport report = remove_vertices(mesh, blocks, is_marked, progress);

  // The slots of faces have wandered with the flips; the search for the nearest face lives on
  // order.
  const std::vector<Index> new_index = mesh.compact();
  std::vector<Index> moved(mesh.position.size());
  for (std::size_t v = 0; v < new_index.size(); ++v)
    if (new_index[v] != kNone) moved[new_index[v]] = matching.sample_of_vertex[v];
  matching.sample_of_vertex = std::move(moved);
  return report;
}

// Components without a sample are debris of the start; nothing is lost with them.
void drop_components_without_samples(Matching& matching, Progress& progress) {
  SurfaceMesh& mesh = matching.mesh;
  const MeshComponents components = connected_components(mesh, progress);
  std::vector<char> has_sample(static_cast<std::size_t>(components.count), 0);
  for (Index v = 0; v < mesh.vertex_slots(); ++v)
    if (matching.sample_of_vertex[v] != kNone) has_sample[components.of_vertex[v]] = 1;
  if (std::count(has_sample.begin(), has_sample.end(), 0) == 0) return;
  std::vector<Index> new_index, samples;
  mesh = kept_components(mesh, components, has_sample, progress, &new_index);
  for (std::size_t v = 0; v < new_index.size(); ++v)
    if (new_index[v] != kNone) samples.push_back(matching.sample_of_vertex[v]);
  matching.sample_of_vertex = std::move(samples);
}

// Step 3.
class Inserter {
 public:
  Inserter(Matching& matching, const PointCloud& cloud)
      : mesh_(matching.mesh),
        matching_(matching),
        cloud_(cloud),
        by_normal_(has_oriented_normals(cloud)),
        no_blocks_({}, silent_),
        everywhere_(no_blocks_, 0, VertexBlocks::kPasses - 1) {}

  void insert_all(Progress& progress, double from, double to) {
    const double all = std::max<double>(static_cast<double>(matching_.isolated.size()), 1.0);
    const auto fraction_left = [&](double left) { return to - (to - from) * left / all; };
    for (int round = 0; round < kRounds && !matching_.isolated.empty(); ++round) {
      const double before = static_cast<double>(matching_.isolated.size());
      progress.set_range(fraction_left(before), fraction_left(0.5 * before));
      find_nearest_faces(progress);
      progress.set_range(fraction_left(0.5 * before), fraction_left(0.5 * before));
      insert_nearest_of_each_face(progress);
    }
    progress.set_range(to, to);
    insert_rest(progress);
  }

 private:
  // The faces nearest to the isolated samples.
  void find_nearest_faces(Progress& progress) {
    const FaceTree tree(mesh_, progress);
    hits_.assign(matching_.isolated.size(), {});
    const Index count = static_cast<Index>(hits_.size());
    parallel_blocks(count, kGrain, progress, [&](Index, Index begin, Index end) {
      FootSearch search(mesh_, tree, cloud_.spacing);
      for (Index i = begin; i < end; ++i) {
        if (i % kPollInterval == 0) progress.update(0.0);
        const Index sample = matching_.isolated[i];
        const Vec3& p = cloud_.position[sample];
        hits_[i] = by_normal_ ? search.nearest_facing(p, cloud_.normal[sample].cast<double>())
                              : search.nearest(p);
      }
    });
  }

  void insert_nearest_of_each_face(Progress& progress) {
    std::vector<Index> nearest_of_face(static_cast<std::size_t>(mesh_.face_slots()), kNone);
    for (Index i = 0; i < static_cast<Index>(hits_.size()); ++i) {
      Index& nearest = nearest_of_face[hits_[i].face];
      if (nearest == kNone || hits_[i].squared_distance < hits_[nearest].squared_distance)
        nearest = i;
    }
    const Index first_new = mesh_.vertex_slots();
    for (std::size_t f = 0; f < nearest_of_face.size(); ++f) {
      if (nearest_of_face[f] == kNone) continue;
      split(static_cast<Index>(f), matching_.isolated[nearest_of_face[f]]);
      if (f % kProgressStride == 0) progress.update(0.0);
    }
    for (Index v = first_new; v < mesh_.vertex_slots(); ++v) {
      flip_around(v);
      if (v % kProgressStride == 0) progress.update(0.0);
    }
    keep_if_isolated([&](Index i) { return nearest_of_face[hits_[i].face] != i; });
  }

  // What is left after the rounds are crowds at one place: one by one, each into the face that a
  // walk over the faces around finds.
  void insert_rest(Progress& progress) {
    for (std::size_t i = 0; i < matching_.isolated.size(); ++i) {
      const Index sample = matching_.isolated[i];
      split(walk_to_nearest_face(hits_[i].face, cloud_.position[sample]), sample);
      flip_around(mesh_.vertex_slots() - 1);
      if (i % kProgressStride == 0) progress.update(0.0);
    }
    matching_.isolated.clear();
  }

  void split(Index face, Index sample) {
    mesh_.split_face(face, cloud_.position[sample]);
    matching_.sample_of_vertex.push_back(sample);
  }

  // In a plane the max-min criterion is the Delaunay criterion (Lawson 1977).
  void flip_around(Index v) {
    stack_.clear();
    mesh_.for_each_outgoing(v, [&](Index h) { stack_.push_back(SurfaceMesh::next(h)); });
    Index budget = kLooksPerInsertion;
    flip_to_delaunay(mesh_, everywhere_, stack_, nullptr, budget);
  }

  Index walk_to_nearest_face(Index face, const Vec3& p) const {
    double best = squared_distance(face, p);
    for (int step = 0; step < kWalkSteps; ++step) {
      const Index before = face;
      const std::array<Index, 3> halfedges = {3 * before, 3 * before + 1, 3 * before + 2};
      for (const Index h : halfedges) {
        const Index beyond = SurfaceMesh::face(mesh_.twin(h));
        const double distance = squared_distance(beyond, p);
        if (distance >= best) continue;
        best = distance;
        face = beyond;
      }
      if (face == before) break;
    }
    return face;
  }

  double squared_distance(Index face, const Vec3& p) const {
    const auto [a, b, c] = mesh_.triangle(face);
    return foot_on_triangle(p, mesh_.position[a], mesh_.position[b], mesh_.position[c])
        .squared_distance;
  }

  template <class Predicate>
  void keep_if_isolated(const Predicate& is_isolated) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < hits_.size(); ++i) {
      if (!is_isolated(static_cast<Index>(i))) continue;
      matching_.isolated[kept] = matching_.isolated[i];
      hits_[kept++] = hits_[i];
    }
    matching_.isolated.resize(kept);
    hits_.resize(kept);
  }

  SurfaceMesh& mesh_;
  Matching& matching_;
  const PointCloud& cloud_;
  bool by_normal_;
  std::vector<FaceTree::Hit> hits_;  // of the isolated samples
  std::vector<Index> stack_;
  Progress silent_;
  VertexBlocks no_blocks_;  // the owner of everything asks nothing of them
  BlockOwner everywhere_;
};

// Samples in their order, then what is left of the other vertices.
void number_by_samples(Matching& matching, Index samples) {
  SurfaceMesh& mesh = matching.mesh;
  std::vector<Index> new_index(mesh.position.size(), kNone);
  Index extra = samples;
  for (Index v = 0; v < mesh.vertex_slots(); ++v) {
    const Index sample = matching.sample_of_vertex[v];
    new_index[v] = sample == kNone ? extra++ : sample;
  }
  mesh.renumber(new_index);
}

}  // namespace

CompleteMatching snap_and_insert(SurfaceMesh parametric, const PointCloud& cloud,
                                 const CompleteMatchingOptions&, Progress& progress) {
  if (parametric.vertex_count() < parametric.vertex_slots()) parametric.compact();
  CompleteMatching result;
  progress.set_range(0.0, 0.25);
  {
    const SampleFeet feet = find_sample_feet(parametric, cloud, progress);
    result.report.mean_foot_distance = feet.mean_distance;
    result.report.max_foot_distance = feet.max_distance;
  }
  progress.set_range(0.25, 0.35);
  Matching matching = snap(std::move(parametric), cloud, progress);

  progress.set_range(0.35, 0.5);
  VertexRemovalReport removal = remove_unmatched(matching, progress);
  drop_components_without_samples(matching, progress);
  result.report.forced_removals = removal.forced;

  Inserter(matching, cloud).insert_all(progress, 0.5, 0.95);
  if (removal.left > 0) {
    progress.set_range(0.95, 0.97);
    removal = remove_unmatched(matching, progress);
    result.report.forced_removals += removal.forced;
  }
  number_by_samples(matching, cloud.size());

  result.mesh = std::move(matching.mesh);
  result.sample_of_vertex.assign(result.mesh.position.size(), SampleId::none);
  for (Index s = 0; s < cloud.size(); ++s) result.sample_of_vertex[s] = to_sample(s);
  result.report.extra_vertices = result.mesh.vertex_count() - cloud.size();
  return result;
}

}  // namespace shrinkwrap
