#include "initial_mesh/initial_mesh.h"

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <numeric>
#include <optional>
#include <tuple>

#include "common/attempted.h"
#include "common/parallel.h"
#include "initial_mesh/bounding_box_start.h"
#include "initial_mesh/genus_limit.h"
#include "initial_mesh/voxel_boundary.h"
#include "initial_mesh/voxel_refinement.h"
#include "initial_mesh/voxel_solid.h"
#include "mesh/one_ring.h"
#include "orientation/winding_number.h"
#include "samples/tangent_target.h"

namespace shrinkwrap {
namespace {

constexpr double kLeastVoxelSize = 0.25;  // that may be asked for, x s
constexpr Index kGrain = 1 << 11;
// Weight of the Laplacian where no sample holds the mesh.
constexpr double kMembraneSmoothing = 0.5;
constexpr double kSupportReach = 3.0;  // x size of a voxel
// A sample is sharp if the normal of one of so many beside it makes a smaller cosine with its own.
constexpr int kNearestSamples = 6;
constexpr float kSharpCosine = 0.7071f;
constexpr float kFacingCosine = -0.5f;        // of the normals of sheets that face each other
constexpr double kLeastLevel = 0.08;          // of sheets: lower ones are far from the samples
constexpr double kLeastClosedness = 0.5;      // of clouds that are no sheets
constexpr double kLeastVoxelForBodies = 0.4;  // x s

// Shrinks the mesh towards the planes of the samples of its own side, all vertices at once (eq.
// 4-8, with the plane in place of the nearest sample, which folds the mesh in concavities).
void shrink(SurfaceMesh& mesh, const PointCloud& cloud, const InitialMeshOptions& options,
            double spacing, Progress& progress) {
  const TangentTarget tangent(cloud);
  const double max_step = options.max_step * spacing;
  std::vector<Index> hint(mesh.position.size(), kNone);
  std::vector<Vec3> moved(mesh.position.size());
  for (int iteration = 0; iteration < options.shrink_iterations; ++iteration) {
    progress.set_range(0.7 + 0.3 * iteration / options.shrink_iterations,
                       0.7 + 0.3 * (iteration + 1) / options.shrink_iterations);
    const bool smoothing = iteration < options.smoothing_iterations;
    parallel_for_each(mesh.vertex_slots(), kGrain, progress, [&](Index v) {
      const OneRing ring = gather_one_ring(mesh, v);
      const Vec3 laplacian = ring.laplacian(), &p = mesh.position[v];
      const TangentTarget::Target target = tangent.find(p, ring.normal, p + laplacian, hint[v]);
      hint[v] = target.nearest;
      if (target.is_membrane) {
        moved[v] = p + kMembraneSmoothing * laplacian;
        return;
      }
      Vec3 step = options.step * (target.point - p);
      const double length = step.norm();
      if (length > max_step) step *= max_step / length;
      moved[v] =
          p + step +
          (smoothing
               ? Vec3(options.smoothing * laplacian)
               : Vec3(options.relaxation * (laplacian - laplacian.dot(ring.normal) * ring.normal)));
    });
    mesh.position.swap(moved);
  }
}

// Above a sample, x the spacing that the voxels suit.
Vec3 point_above(const PointCloud& cloud, const VoxelSolid& solid, Index i, double height) {
  return cloud.position[i] + height * solid.spacing * cloud.normal[i].cast<double>();
}

bool has_solid_at(std::initializer_list<double> heights, const PointCloud& cloud, Index i,
                  const VoxelSolid& solid) {
  return std::any_of(heights.begin(), heights.end(), [&](double height) {
    return solid.contains(point_above(cloud, solid, i, height));
  });
}

bool is_faced_at(std::initializer_list<double> heights, const PointCloud& cloud, Index i,
                 const VoxelSolid& solid) {
  return std::any_of(heights.begin(), heights.end(), [&](double height) {
    const Index other = cloud.search.nearest(point_above(cloud, solid, i, height)).index;
    return cloud.normal[other].dot(cloud.normal[i]) < kFacingCosine;
  });
}

template <class IsCounted>
double fraction_of_samples(const PointCloud& cloud, const IsCounted& is_counted,
                           Progress& progress) {
  const Index count =
      parallel_sum(cloud.size(), kGrain, progress, Index{0}, [&](Index begin, Index end) {
        Index found = 0;
        for (Index i = begin; i < end; ++i) found += is_counted(i);
        return found;
      });
  return static_cast<double>(count) / cloud.size();
}

double fraction_with_solid_behind(const PointCloud& cloud, const VoxelSolid& solid,
                                  Progress& progress) {
  const auto has_solid_behind = [&](Index i) {
    return has_solid_at({-1.0, -1.5, -2.0, -2.5, -3.0}, cloud, i, solid);
  };
  return fraction_of_samples(cloud, has_solid_behind, progress);
}

// See InitialMeshReport::grown_together.
double fraction_grown_together(const PointCloud& cloud, const VoxelSolid& solid,
                               Progress& progress) {
  const auto is_grown_together = [&](Index i) {
    return has_solid_at({1.5, 2.0}, cloud, i, solid) && is_faced_at({2.0, 3.5}, cloud, i, solid);
  };
  return fraction_of_samples(cloud, is_grown_together, progress);
}

// Half of the samples are with components that have at least so many.
Index typical_support(std::vector<Index> support) {
  std::sort(support.begin(), support.end(), std::greater<>());
  const double all = std::accumulate(support.begin(), support.end(), 0.0);
  double sum = 0.0;
  for (const Index samples : support)
    if ((sum += samples) >= 0.5 * all) return samples;
  return 0;
}

// How many samples must support a component: of a small cloud a hundredth of all is enough, unless
// more than usual were asked for.
Index least_support(Index samples, Index asked_for) {
  if (asked_for > InitialMeshOptions().min_component_samples) return asked_for;
  return std::min(asked_for, std::max<Index>(samples / 100, 4));
}

// Which components at least `min_samples` samples support, each sample the one that is nearest to
// it, or a quarter of what is typical where all are small; always the best supported.
std::vector<char> find_supported(const SurfaceMesh& mesh, const MeshComponents& components,
                                 const PointCloud& cloud, double reach, Index min_samples,
                                 Progress& progress) {
  std::vector<char> is_kept(static_cast<std::size_t>(components.count), 1);
  if (components.count < 2) return is_kept;
  const VoxelSearch vertices(mesh.position, progress);
  std::vector<Index> supported(cloud.position.size(), kNone);
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    const auto nearest = vertices.nearest(cloud.position[i]);
    if (nearest.squared_distance <= reach * reach)
      supported[i] = components.of_vertex[nearest.index];
  });
  std::vector<Index> support(is_kept.size(), 0);
  for (const Index component : supported)
    if (component != kNone) ++support[component];
  const Index needed = std::min(min_samples, (typical_support(support) + 3) / 4);
  for (std::size_t c = 0; c < support.size(); ++c) is_kept[c] = support[c] >= needed;
  return is_kept;
}

// Six times the volume that each component encloses; negative for a cavity.
std::vector<double> volumes_of(const SurfaceMesh& mesh, const MeshComponents& components) {
  std::vector<double> volume(static_cast<std::size_t>(components.count), 0.0);
  const auto& p = mesh.position;
  for (Index f = 0; f < mesh.face_slots(); ++f) {
    const Triangle t = mesh.triangle(f);
    volume[components.of_vertex[t[0]]] += p[t[0]].dot(p[t[1]].cross(p[t[2]]));
  }
  return volume;
}

// Leaves out the components with too little support, and reports what there is.
void keep_supported(InitialMesh& boundary, const PointCloud& cloud, double reach, Index min_samples,
                    Progress& progress) {
  SurfaceMesh& mesh = boundary.mesh;
  InitialMeshReport& report = boundary.report;
  const MeshComponents components = connected_components(mesh, progress);
  const std::vector<char> is_kept =
      find_supported(mesh, components, cloud, reach, min_samples, progress);
  const std::vector<double> volume = volumes_of(mesh, components);
  report.components = report.cavities = report.dropped = 0;
  for (std::size_t c = 0; c < is_kept.size(); ++c)
    ++(!is_kept[c] ? report.dropped : volume[c] > 0.0 ? report.components : report.cavities);
  if (report.dropped > 0) mesh = kept_components(mesh, components, is_kept, progress);
  report.genus = report.components + report.cavities - mesh.euler_characteristic() / 2;
}

// The boundary of the voxel solid of one voxel size, in two steps, as what is only tried may be
// given up after the first.
class SolidBoundary {
 public:
  SolidBoundary(const PointCloud& cloud, const WindingNumber& winding,
                const InitialMeshOptions& options, Progress& progress)
      : cloud_(cloud),
        options_(options),
        least_support_(least_support(cloud.size(), options.min_component_samples)),
        solid_(make_voxel_solid(cloud, winding, options, progress)) {
    InitialMeshReport& report = result_.report;
    const double voxel_size = solid_.lattice.size;
    report.voxel_size = voxel_size / cloud.spacing;
    report.spacing = solid_.spacing / cloud.spacing;
    report.voxels_are_larger = voxel_size > options.voxel_size * solid_.spacing;
    if (!report.voxels_are_larger)
      report.refined_parts = refine_dense_parts(solid_, cloud, winding, options, progress);
    progress.set_range(0.6, 0.7);
    extract(progress);
  }

  // Cutting false handles adds none: it parts nothing but the wall of a cavity.
  Index components() const { return result_.report.components; }

  InitialMesh finish(Progress& progress) && {
    cut_what_is_false(progress);
    if (result_.mesh.face_count() == 0) {
      solid_.image.mask = solid_.near_samples;
      solid_.image.mask.resize(static_cast<std::size_t>(solid_.image.bricks.size()), 0);
      least_support_ = 1;
      extract(progress);
      cut_what_is_false(progress);
    }
    result_.report.samples_with_solid_behind = fraction_with_solid_behind(cloud_, solid_, progress);
    result_.report.grown_together = fraction_grown_together(cloud_, solid_, progress);
    return std::move(result_);
  }

 private:
  void extract(Progress& progress) {
    make_well_composed(solid_.image, progress);
    result_.mesh = boundary_of(solid_.image, solid_.lattice, progress);
    keep_what_is_supported(progress);
  }

  void cut_what_is_false(Progress& progress) {
    if (!options_.false_handles.enabled) return;
    FalseHandleOptions options = options_.false_handles;
    options.least_of_cavity = std::max(options.least_of_cavity, least_support_);
    const FalseHandleReport cut = cut_false_handles(result_.mesh, cloud_, options, progress);
    InitialMeshReport& report = result_.report;
    report.false_handles = cut.handles;
    report.false_mouths = cut.mouths;
    report.genus -= cut.handles;
    if (cut.mouths == 0) return;
    const Index dropped = report.dropped;
    keep_what_is_supported(progress);
    report.dropped += dropped;
  }

  void keep_what_is_supported(Progress& progress) {
    keep_supported(result_, cloud_, kSupportReach * solid_.lattice.size, least_support_, progress);
  }

  const PointCloud& cloud_;
  const InitialMeshOptions& options_;
  Index least_support_;
  VoxelSolid solid_;
  InitialMesh result_;
};

InitialMesh solid_boundary(const PointCloud& cloud, const WindingNumber& winding,
                           const InitialMeshOptions& options, Progress& progress) {
  return SolidBoundary(cloud, winding, options, progress).finish(progress);
}

// Handles, and of as many the fewer that had to be cut.
bool has_fewer_handles(const InitialMeshReport& a, const InitialMeshReport& b) {
  return std::tie(a.genus, a.false_handles) < std::tie(b.genus, b.false_handles);
}

// With voxels of so many times the size. Nothing where no solid comes of it, as what is only tried
// fails no run, or one of fewer components than would be of use.
std::optional<InitialMesh> try_boundary(const PointCloud& cloud, const WindingNumber& winding,
                                        InitialMeshOptions options, double ratio,
                                        Index least_components, Progress& progress) {
  options.voxel_size *= ratio;
  std::optional<InitialMesh> boundary;
  attempted([&] {
    SolidBoundary solid(cloud, winding, options, progress);
    if (solid.components() >= least_components) boundary = std::move(solid).finish(progress);
  });
  return boundary;
}

// The boundary that the evidence speaks for: a handle of the object is there at either voxel size,
// one that voxels made between close sheets or through thin walls seldom is.
InitialMesh boundary_with_fewer_handles(InitialMesh first, const PointCloud& cloud,
                                        const WindingNumber& winding,
                                        const InitialMeshOptions& options, Progress& progress) {
  if ((first.report.genus == 0 && first.report.false_handles == 0) ||
      options.second_voxel_ratio <= 0.0)
    return first;
  std::optional<InitialMesh> second = try_boundary(
      cloud, winding, options, options.second_voxel_ratio, first.report.components, progress);
  if (!second) return first;
  const InitialMeshReport &a = first.report, &b = second->report;
  if (!has_fewer_handles(b, a) || b.components < a.components ||
      (b.voxels_are_larger && !a.voxels_are_larger) ||
      (options.second_voxel_ratio < 1.0 && b.components + b.cavities < a.components + a.cavities))
    return first;
  second->report.handles_refuted = a.genus - b.genus;
  return std::move(*second);
}

// Bodies may have grown together that smaller voxels tell apart, and ever smaller ones as long as
// they tell more.
InitialMesh boundary_with_more_bodies(InitialMesh first, const PointCloud& cloud,
                                      const WindingNumber& winding, InitialMeshOptions options,
                                      Progress& progress) {
  options.sideways = options.sideways_for_bodies;
  const double per_attempt = options.voxel_ratio_for_bodies;
  if (per_attempt <= 0.0 || per_attempt >= 1.0 || first.report.voxels_are_larger ||
      cloud.closedness < kLeastClosedness)
    return first;
  for (double ratio = per_attempt;
       first.report.grown_together > 0.0 && ratio * options.voxel_size >= kLeastVoxelForBodies;
       ratio *= per_attempt) {
    std::optional<InitialMesh> second =
        try_boundary(cloud, winding, options, ratio, first.report.components + 1, progress);
    if (!second) break;
    const InitialMeshReport &a = first.report, &b = second->report;
    const Index more = b.components - a.components;
    const double lost = (a.samples_with_solid_behind - b.samples_with_solid_behind) * cloud.size();
    const bool is_as_sound = b.genus <= a.genus && b.false_handles <= a.false_handles &&
                             b.cavities == a.cavities && b.dropped <= a.dropped &&
                             !b.voxels_are_larger && lost < more - 0.5;
    if (more <= 0 || !is_as_sound) break;
    second->report.handles_refuted = a.handles_refuted + a.genus - b.genus;
    second->report.bodies_parted = a.bodies_parted + more;
    first = std::move(*second);
  }
  return first;
}

// What lies in shadow on a sheet is spanned at a lower level, and so may holes of the object be.
InitialMesh boundary_without_tunnels(InitialMesh first, const PointCloud& cloud,
                                     const WindingNumber& winding, InitialMeshOptions options,
                                     Progress& progress) {
  const double per_attempt = options.level_ratio_for_shadows;
  if (!options.false_handles.enabled || per_attempt <= 0.0 || per_attempt >= 1.0 ||
      cloud.closedness >= kLeastClosedness || first.mesh.face_count() == 0)
    return first;
  const Index genus = first.report.genus, refuted = first.report.handles_refuted;
  const double size = first.report.voxel_size / (options.voxel_size * first.report.spacing);
  Index tunnels = 0;
  attempted([&] {
    tunnels = count_tunnels_of_shadows(first.mesh, cloud, options.false_handles, progress);
  });
  while (first.report.genus > genus - tunnels && options.level * per_attempt >= kLeastLevel) {
    options.level *= per_attempt;
    std::optional<InitialMesh> lower =
        try_boundary(cloud, winding, options, size, first.report.components, progress);
    if (!lower || lower->report.genus < genus - tunnels) break;
    const InitialMeshReport &a = first.report, &b = lower->report;
    const bool is_as_sound = b.components == a.components && b.cavities <= a.cavities &&
                             b.dropped <= a.dropped && b.voxel_size < 1.01 * a.voxel_size &&
                             b.samples_with_solid_behind >= a.samples_with_solid_behind;
    if (b.genus >= a.genus || !is_as_sound) continue;
    lower->report.handles_refuted = refuted + genus - b.genus;
    first = std::move(*lower);
  }
  return first;
}

// Part of the samples that are sharp: see InitialMeshOptions::least_sharp.
double fraction_of_sharp_samples(const PointCloud& cloud, Progress& progress) {
  const int count = std::min(kNearestSamples + 1, cloud.neighbour_count);
  const auto is_sharp = [&](Index i) {
    const Index* near = cloud.neighbours_of(i);
    return std::any_of(near + 1, near + count, [&](Index other) {
      return cloud.normal[i].dot(cloud.normal[other]) < kSharpCosine;
    });
  };
  return fraction_of_samples(cloud, is_sharp, progress);
}

// With smaller voxels, of which `options` are to be; nothing if they are not asked for.
std::optional<InitialMesh> boundary_of_detail(const PointCloud& cloud, const WindingNumber& winding,
                                              InitialMeshOptions& options, double sharp,
                                              Progress& progress) {
  const double ratio = options.voxel_ratio_for_detail;
  if (ratio <= 0.0 || sharp <= options.least_sharp || cloud.closedness < kLeastClosedness)
    return std::nullopt;
  std::optional<InitialMesh> mesh = try_boundary(cloud, winding, options, ratio, 0, progress);
  if (!mesh || mesh->report.voxels_are_larger) return std::nullopt;
  options.voxel_size *= ratio;
  return boundary_with_fewer_handles(std::move(*mesh), cloud, winding, options, progress);
}

// Where voxels of the usual size show fewer handles than smaller ones: cuts the handles of the
// latter that are in doubt, and returns whether more are left even so. If not, the mesh is of no
// use any more.
bool are_more_left(InitialMesh& detailed, const InitialMesh& usual, const PointCloud& cloud,
                   const InitialMeshOptions& options, Progress& progress) {
  InitialMeshReport& report = detailed.report;
  if (report.components < usual.report.components) return false;
  const Index more = report.genus - usual.report.genus;
  const Index cut = cut_doubtful_handles(detailed.mesh, usual.mesh, cloud, options.false_handles,
                                         more - 1, progress);
  if (cut >= more) return false;
  report.genus -= cut;
  report.handles_refuted += cut;
  return true;
}

InitialMesh most_plausible_boundary(const PointCloud& cloud, InitialMeshOptions options,
                                    Progress& progress) {
  options.level -=
      (1.0 - cloud.closedness) * std::max(options.level - options.level_of_sheets, 0.0);
  progress.set_range(0.0, 0.0);
  const WindingNumber winding(cloud, progress);
  const double sharp = fraction_of_sharp_samples(cloud, progress);
  const auto of_the_size_asked_for = [&] {
    InitialMesh fewer = boundary_with_fewer_handles(
        solid_boundary(cloud, winding, options, progress), cloud, winding, options, progress);
    return boundary_without_tunnels(std::move(fewer), cloud, winding, options, progress);
  };
  InitialMesh mesh;
  InitialMeshOptions smaller = options;
  std::optional<InitialMesh> detailed =
      boundary_of_detail(cloud, winding, smaller, sharp, progress);
  const Index genus = detailed ? detailed->report.genus : 0;
  if (genus > 0) mesh = of_the_size_asked_for();
  if (!detailed) {
    mesh = boundary_with_more_bodies(of_the_size_asked_for(), cloud, winding, options, progress);
  } else if (genus > mesh.report.genus && mesh.report.components >= detailed->report.components &&
             !are_more_left(*detailed, mesh, cloud, options, progress)) {
    mesh.report.handles_refuted = std::max(
        mesh.report.handles_refuted, genus + detailed->report.handles_refuted - mesh.report.genus);
  } else {
    mesh = boundary_with_more_bodies(std::move(*detailed), cloud, winding, smaller, progress);
    mesh.report.is_of_detail_size = true;
  }
  mesh.report.sharp = sharp;
  return mesh;
}

}  // namespace

InitialMesh make_initial_mesh(const PointCloud& cloud, const InitialMeshOptions& options,
                              Progress& progress) {
  progress.begin(Stage::initial_mesh);
  if (options.start == InitialMeshOptions::Start::bounding_box)
    return shrink_bounding_box(cloud, options, progress);
  if (!(options.voxel_size >= kLeastVoxelSize))
    throw InvalidInput(
        "voxels are to be a quarter of the sample spacing or larger: the planes of "
        "samples would reach over too many.");
  InitialMesh result = most_plausible_boundary(cloud, options, progress);
  if (result.mesh.face_count() == 0)
    throw ReconstructionFailed(
        "no solid was found around the samples: try a larger voxel size or a lower level");
  if (options.maximum_genus >= 0 && result.report.genus > options.maximum_genus) {
    result.report.handles_cut = limit_genus(result.mesh, options.maximum_genus, progress).cut;
    result.report.genus -= result.report.handles_cut;
  }
  shrink(result.mesh, cloud, options, result.report.spacing * cloud.spacing, progress);
  return result;
}

}  // namespace shrinkwrap
