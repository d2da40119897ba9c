#include "orientation/orientation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/parallel.h"
#include "orientation/component_shape.h"
#include "orientation/visibility.h"
#include "orientation/winding_number.h"

namespace shrinkwrap {
namespace {

constexpr Index kGrain = 1 << 12;
constexpr int kMostLayers = 64;           // of components within or behind components
constexpr Index kProbes = 32;             // samples of a component that tell what it lies in
constexpr Index kDrawnPerComponent = 32;  // at least, of each that has as many
constexpr double kDepthTolerance = 0.7;   // x spacing of the samples drawn
constexpr double kSeenOpenly = 0.25;      // of the possible votes: not through a wall
constexpr double kLeastCosine = 0.1;      // of a sheet that faces a direction
constexpr double kSteepCosine = 0.3;      // with the way to the station: beyond doubt
constexpr double kLeastGround = 0.1;      // of the samples: flat pieces of bodies are less, mostly
constexpr double kLeastInFront = 0.02;    // x samples of a sheet, to tell which way it faces: a few
                                          // houses are, but no stray sets
constexpr double kUnknown = 2.0;          // no majority

// Of every stride-th sample.
VisibilityOptions views_of(const PointCloud& cloud, const OrientationOptions& options, Index stride,
                           int directions) {
  const double spacing = cloud.spacing * std::sqrt(static_cast<double>(stride));
  VisibilityOptions views;
  views.directions = directions;
  views.min_cosine = options.min_cosine;
  views.pixel = options.pixel_size * spacing;
  views.depth_tolerance = kDepthTolerance * spacing;
  return views;
}

SampleVotes draw_samples(const PointCloud& cloud, const OrientationOptions& options, Index most,
                         int directions, Progress& progress) {
  const Index stride = (cloud.size() - 1) / std::max<Index>(most, 1) + 1;
  SampleVotes samples;
  for (Index i = 0; i < cloud.size(); i += stride) samples.drawn.push_back(i);
  samples.votes = visibility_votes(cloud, samples.drawn,
                                   views_of(cloud, options, stride, directions), progress);
  return samples;
}

// Takes the signs that neighbours and views agreed upon for the sets of samples that are to be
// turned (DisputedSigns::find_turned) by a coarse drawing and, unless that was of all samples, also
// by one so fine that hardly a wall is seen through. This one is not made if the coarse one turns
// nothing.
void follow_agreement(const PointCloud& cloud, const NeighbourGraph& graph,
                      const OrientationOptions& options, const SampleVotes& votes,
                      SpanningForest& forest, Progress& progress) {
  const DisputedSigns disputed(graph, forest, progress);
  const auto find_turned = [&](const SampleVotes& judges) {
    return disputed.find_turned(judges, options.signs.least_majority, options.disputes);
  };
  std::vector<char> turned = find_turned(votes);
  if (std::find(turned.begin(), turned.end(), 1) == turned.end()) return;
  if (votes.drawn.size() < cloud.position.size()) {
    const std::vector<char> finely = find_turned(draw_samples(
        cloud, options, options.judging_samples, options.judging_directions, progress));
    for (std::size_t set = 0; set < turned.size(); ++set) turned[set] &= finely[set];
  }
  for (Index i = 0; i < cloud.size(); ++i)
    if (disputed.set_of(i) != kNone && turned[disputed.set_of(i)])
      forest.flipped[i] = !forest.flipped[i];
}

// Chooses a sign for every component, layer by layer from outside.
class ComponentSigns {
 public:
  // `votes` on the normals as they are now.
  ComponentSigns(const PointCloud& cloud, const SpanningForest& forest, const SampleVotes& votes,
                 const OrientationOptions& options, Progress& progress)
      : cloud_(cloud), forest_(forest), votes_(votes), options_(options), progress_(progress) {}

  // For each component, whether to flip it.
  std::vector<char> decide(OrientationReport& report) {
    const auto components = static_cast<std::size_t>(forest_.components);
    shape_ = component_shapes(cloud_, forest_);
    for (const ComponentShape& shape : shape_) size_.push_back(shape.samples);
    by_itself_.assign(components, kUnknown);
    waiting_.assign(components, 1);
    std::vector<char> flip(components, 0);
    std::size_t left = components;
    for (int layer = 0; left > 0 && layer < kMostLayers; ++layer) {
      const std::vector<VisibilityVote> votes = layer == 0 ? first_votes() : clear_votes();
      const std::vector<char> enclosed = layer > 0 ? within_decided(flip) : std::vector<char>();
      has_ground_ = has_ground_ || sees_ground(votes);
      std::vector<std::size_t> seen, undecided_sheets;
      for (std::size_t c = 0; c < components; ++c) {
        if (!waiting_[c] || is_hidden(c, votes[c])) continue;
        const bool is_of_ground = is_ground(c, votes[c]);
        const double outward = is_of_ground ? 0.0 : measure_outwardness(c, votes[c]);
        seen.push_back(c);
        report.enclosed_components += layer > 0;
        report.undecided_components += is_of_ground || is_close(outward);
        if (is_of_ground || (may_be_open(c, votes[c]) && is_close(outward))) {
          undecided_sheets.push_back(c);
          continue;
        }
        // The wall of a cavity is seen from within the body.
        const bool is_cavity = layer > 0 && enclosed[c];
        flip[c] = is_cavity ? outward > 0.0 : outward < 0.0;
        add_to_front(c, flip[c]);
      }
      std::stable_sort(undecided_sheets.begin(), undecided_sheets.end(),
                       [&](std::size_t a, std::size_t b) { return size_[a] > size_[b]; });
      for (const std::size_t c : undecided_sheets) {
        flip[c] = towards_front(c) < 0.0;
        add_to_front(c, flip[c]);
      }
      for (const std::size_t c : seen) waiting_[c] = 0;
      const std::size_t decided = seen.size();
      if (decided == 0) break;
      left -= decided;
    }
    report.undecided_components += static_cast<Index>(left);
    return flip;
  }

 private:
  // Too small a component hides behind the splats of what is around it.
  bool is_large(std::size_t component) const { return size_[component] > kDrawnPerComponent; }
  // Only through other components, as views of few of the samples see through walls, or behind
  // their splats, as what lies deep in a hole of another.
  bool is_seen_through(const VisibilityVote& vote) const {
    return vote.foremost <= options_.least_visible * vote.possible &&
           vote.seen > options_.least_visible * vote.possible;
  }
  // What is seen through others waits for these to be decided, unless that is so much of it that
  // no wall can be between. Pre: drawn as finely as can be, if a large component is seen through.
  bool is_hidden(std::size_t component, const VisibilityVote& vote) const {
    if (is_large(component) && is_seen_through(vote))
      return vote.seen <= kSeenOpenly * vote.possible;
    return vote.seen <= options_.least_visible * vote.possible;
  }
  bool is_close(double majority) const { return std::abs(majority) < options_.least_vote; }

  bool may_be_open(std::size_t component, const VisibilityVote& vote) const {
    return shape_[component].is_sheet() && (vote.trust() < 1.0 || is_close(vote.majority()));
  }
  // A large flat sheet of which, by itself, more is seen from one side though its shape does not
  // tell: what stands on it hides its front. What only others hide, such as the inner side of a
  // roof or of a face, tells its side.
  bool is_ground(std::size_t component, const VisibilityVote& vote) {
    return size_[component] >= kLeastGround * cloud_.size() && may_be_open(component, vote) &&
           shape_[component].is_flat() && !is_close(majority_by_itself(component));
  }
  bool sees_ground(const std::vector<VisibilityVote>& votes) {
    for (std::size_t c = 0; c < votes.size(); ++c)
      if (waiting_[c] && !is_hidden(c, votes[c]) && is_ground(c, votes[c])) return true;
    return false;
  }
  // Positive if the normals of a component point outwards. Where there is ground, a sheet may be
  // a piece of it, that would tell as little by itself. Pre: it is not ground.
  double measure_outwardness(std::size_t component, const VisibilityVote& vote) {
    if (!may_be_open(component, vote)) return vote.majority();
    const double among_others = vote.trust() * vote.majority();
    return has_ground_ ? among_others : among_others + majority_by_itself(component);
  }
  double majority_by_itself(std::size_t component) {
    double& known = by_itself_[component];
    if (known == kUnknown) known = votes_on(component).majority();
    return known;
  }
  void add_to_front(std::size_t component, bool is_flipped) {
    const Vec3& sum = shape_[component].normal_sum;
    front_ += is_flipped ? Vec3(-sum) : sum;
    in_front_ += size_[component];
  }

  // Positive if a sheet faces where the components that have a sign do on the whole or, where these
  // face all around or are too few to tell, +z (or +y, +x if it stands upright).
  double towards_front(std::size_t component) const {
    const Vec3& sum = shape_[component].normal_sum;
    const bool is_clear = in_front_ >= kLeastInFront * size_[component] &&
                          front_.norm() >= kLeastSheetNormal * in_front_;
    const Vec3 front = is_clear ? front_.normalized() : Vec3(Vec3::Zero());
    const Vec3 sides[] = {front, Vec3::UnitZ(), Vec3::UnitY(), Vec3::UnitX()};
    for (const Vec3& side : sides)
      if (std::abs(sum.dot(side)) > kLeastCosine * sum.norm()) return sum.dot(side);
    return 0.0;
  }

  // For each component that is waiting, whether it lies within the body that those decided bound.
  std::vector<char> within_decided(const std::vector<char>& flip) const {
    std::vector<signed char> sign(cloud_.position.size());
    std::vector<Index> probed(size_.size(), 0), passed(size_.size(), 0);
    std::vector<double> sum(size_.size(), 0.0);
    for (Index i = 0; i < cloud_.size(); ++i) {
      const Index component = forest_.component_of_sample[i];
      sign[i] = static_cast<signed char>(waiting_[component] ? 0 : flip[component] ? -1 : 1);
    }
    const WindingNumber winding(cloud_, sign, progress_);
    for (Index i = 0; i < cloud_.size(); ++i) {
      const Index component = forest_.component_of_sample[i];
      if (!waiting_[component]) continue;
      if (passed[component]++ % (size_[component] / kProbes + 1) != 0) continue;
      progress_.update(1.0);
      sum[component] += winding.at(cloud_.position[i]);
      ++probed[component];
    }
    std::vector<char> enclosed(size_.size(), 0);
    for (std::size_t c = 0; c < size_.size(); ++c) enclosed[c] = sum[c] > 0.5 * probed[c];
    return enclosed;
  }

  // Where all samples were drawn, so finely again: what they saw of each other's components was not
  // known then.
  std::vector<VisibilityVote> first_votes() const {
    if (votes_.drawn.size() < cloud_.position.size()) return clear_votes();
    if (forest_.components == 1) return by_component(votes_);
    return by_component(votes_on(votes_.drawn, 1, options_.view_directions));
  }

  // Votes on the components that are waiting. Coarse drawings see through thin parts, so that votes
  // nearly cancel, and through other components: then finer ones are made, with fewer views as they
  // cost more.
  std::vector<VisibilityVote> clear_votes() const {
    Index samples = 0;
    for (std::size_t c = 0; c < waiting_.size(); ++c)
      if (waiting_[c]) samples += size_[c];
    Index stride = samples / std::max<Index>(options_.drawn_samples, 1) + 1;
    int directions = options_.view_directions;
    for (;;) {
      std::vector<VisibilityVote> votes = by_component(vote(stride, directions));
      bool clear = true;
      for (std::size_t c = 0; c < votes.size() && clear; ++c)
        clear = !waiting_[c] || !is_large(c) ||
                !(is_seen_through(votes[c]) ||
                  (!is_hidden(c, votes[c]) && is_close(votes[c].majority())));
      if (clear || stride == 1) return votes;
      stride = std::max<Index>(1, stride / 4);
      directions = std::max(std::min(directions, 24), directions / 2);
    }
  }

  SampleVotes vote(Index stride, int directions) const {
    std::vector<Index> drawn, passed(size_.size(), 0);
    for (Index i = 0; i < cloud_.size(); ++i) {
      const Index component = forest_.component_of_sample[i];
      if (!waiting_[component]) continue;
      const Index own_stride = std::clamp<Index>(size_[component] / kDrawnPerComponent, 1, stride);
      if (passed[component]++ % own_stride == 0) drawn.push_back(i);
    }
    return votes_on(std::move(drawn), stride, directions);
  }

  // On one component, as if there were nothing else.
  VisibilityVote votes_on(std::size_t component) {
    if (samples_.empty()) sort_by_component();
    const Index stride = size_[component] / std::max<Index>(options_.drawn_samples, 1) + 1;
    std::vector<Index> drawn;
    for (Index k = first_[component]; k < first_[component + 1]; k += stride)
      drawn.push_back(samples_[k]);
    VisibilityVote sum;
    for (const VisibilityVote& vote :
         votes_on(std::move(drawn), stride, options_.view_directions).votes)
      sum.add(vote);
    return sum;
  }
  void sort_by_component() {
    first_.assign(size_.size() + 1, 0);
    std::partial_sum(size_.begin(), size_.end(), first_.begin() + 1);
    samples_.resize(cloud_.position.size());
    std::vector<Index> next(first_.begin(), first_.end() - 1);
    for (Index i = 0; i < cloud_.size(); ++i) samples_[next[forest_.component_of_sample[i]]++] = i;
  }

  // Of samples, each of which stands for `stride`.
  SampleVotes votes_on(std::vector<Index> drawn, Index stride, int directions) const {
    SampleVotes samples{std::move(drawn), {}};
    samples.votes =
        visibility_votes(cloud_, samples.drawn, views_of(cloud_, options_, stride, directions),
                         progress_, &forest_.component_of_sample);
    return samples;
  }
  std::vector<VisibilityVote> by_component(const SampleVotes& samples) const {
    return samples.by_component(forest_.component_of_sample, forest_.components);
  }

  const PointCloud& cloud_;
  const SpanningForest& forest_;
  const SampleVotes& votes_;
  const OrientationOptions& options_;
  Progress& progress_;
  std::vector<Index> size_;    // samples of each component
  std::vector<char> waiting_;  // components without a sign yet
  std::vector<ComponentShape> shape_;
  std::vector<double> by_itself_;  // majority of the votes on each component as if it were alone
  Vec3 front_ = Vec3::Zero();      // sum of the signed normals of the components that have a sign
  double in_front_ = 0.0;          // samples of these
  bool has_ground_ = false;        // among the components seen so far
  std::vector<Index> samples_;     // by component, and where each begins: once asked for
  std::vector<Index> first_;
};

// Makes the signs of neighbours consistent.
SpanningForest turn_alike(PointCloud& cloud, const NeighbourGraph& graph,
                          const OrientationOptions& options, SampleVotes& votes,
                          Progress& progress) {
  SpanningForest forest = span_normals(graph, votes, options.signs, progress);
  if (!forest.flipped_as_agreed.empty())
    follow_agreement(cloud, graph, options, votes, forest, progress);
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    if (forest.flipped[i]) cloud.normal[i] = -cloud.normal[i];
  });
  for (std::size_t k = 0; k < votes.drawn.size(); ++k)
    if (forest.flipped[votes.drawn[k]]) votes.votes[k] = votes.votes[k].turned();
  return forest;
}

void turn_outward(PointCloud& cloud, const SpanningForest& forest, const SampleVotes& votes,
                  const OrientationOptions& options, OrientationReport& report,
                  Progress& progress) {
  const std::vector<char> flip =
      ComponentSigns(cloud, forest, votes, options, progress).decide(report);
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    if (flip[forest.component_of_sample[i]]) cloud.normal[i] = -cloud.normal[i];
  });
}

// Each component as most of it faces the station, and then each sample that is seen steeply.
void turn_towards(const Vec3& station, PointCloud& cloud, const SpanningForest& forest,
                  Progress& progress) {
  const auto cosine = [&](Index i) {
    const Vec3 way = (station - cloud.position[i]).normalized();  // zero stays zero
    return cloud.normal[i].cast<double>().dot(way);
  };
  std::vector<double> towards(static_cast<std::size_t>(forest.components), 0.0);
  for (Index i = 0; i < cloud.size(); ++i) towards[forest.component_of_sample[i]] += cosine(i);
  parallel_for_each(cloud.size(), kGrain, progress, [&](Index i) {
    Vec3f& normal = cloud.normal[i];
    if (towards[forest.component_of_sample[i]] < 0.0) normal = -normal;
    if (cosine(i) < -kSteepCosine) normal = -normal;
  });
}

// See PointCloud::closedness. What closes on itself has normals all around, be it sampled so
// sparsely that views see through it: a sheet is what has a mean normal of twice the least that
// sheets have, and less so what has a shorter one.
double closedness_of(const PointCloud& cloud, const SampleVotes& votes) {
  VisibilityVote on_all;
  for (const VisibilityVote& vote : votes.votes) on_all.add(vote);
  Vec3 sum = Vec3::Zero();
  for (const Vec3f& normal : cloud.normal) sum += normal.cast<double>();
  const double beyond = sum.norm() / cloud.size() - kLeastSheetNormal;
  return std::max(on_all.trust(), 1.0 - std::clamp(beyond / kLeastSheetNormal, 0.0, 1.0));
}

// exp(-x) for x in [0, 2.5], within 0.2 %: four terms at a quarter of x.
inline float falling_exponential(float x) {
  const float y = 0.25f * x;
  const float growth = 1.0f + y * (1.0f + y * (0.5f + y * (1.0f / 6.0f + y * (1.0f / 24.0f))));
  const float squared = growth * growth;
  return 1.0f / (squared * squared);
}

TangentPlane tangent_plane(const PointCloud& cloud, int neighbours, Index sample) {
  const Vec3& origin = cloud.position[sample];
  const Vec3f& normal = cloud.normal[sample];
  const Index* list = cloud.neighbours_of(sample);
  const int count = std::min(neighbours, cloud.neighbour_count);
  const float reach = (cloud.position[list[count - 1]] - origin).cast<float>().squaredNorm();
  const float decay = reach > 0.0f ? 2.5f / reach : 0.0f;
  Vec3f offset = Vec3f::Zero(), mean_normal = normal;  // the sample itself, of weight 1
  float total = 1.0f;
  for (int entry = 1; entry < count; ++entry) {
    const Vec3f& other = cloud.normal[list[entry]];
    const float cosine = other.dot(normal);
    if (!(cosine > 0.1f)) continue;
    const Vec3f d = (cloud.position[list[entry]] - origin).cast<float>();
    const float weight = falling_exponential(decay * d.squaredNorm()) * cosine * cosine;
    offset += weight * d;
    mean_normal += weight * other;
    total += weight;
  }
  return {(origin + (offset / total).cast<double>()).cast<float>(), mean_normal.normalized()};
}

}  // namespace

OrientationReport orient_normals(PointCloud& cloud, const OrientationOptions& options,
                                 Progress& progress) {
  progress.begin(Stage::orientation);
  OrientationReport report;
  progress.set_range(0.0, 0.05);
  if (!cloud.conditioning.on_lines)
    report.poled =
        fit_pole_normals(cloud, scatter_of_samples(cloud, progress), options.poles, progress);
  progress.set_range(0.05, 0.25);
  SampleVotes votes =
      draw_samples(cloud, options, options.propagation_samples, options.view_directions, progress);
  progress.set_range(0.25, 0.6);
  const NeighbourGraph graph(cloud, options.propagation_neighbours, progress);
  const SpanningForest forest = turn_alike(cloud, graph, options, votes, progress);
  progress.set_range(0.6, 0.85);
  const Vec3 origin = cloud.frame.to_unit(Vec3::Zero());
  report.components = forest.components;
  report.is_view = is_view_from(cloud, origin, options.station, progress);
  if (report.is_view) {
    turn_towards(origin, cloud, forest, progress);
  } else {
    turn_outward(cloud, forest, votes, options, report, progress);
    report.turned = turn_inverted_patches(cloud, graph, votes, options.inverted, progress);
  }

  report.closedness = cloud.closedness = closedness_of(cloud, votes);

  progress.set_range(0.85, 0.95);
  if (graph.noise() <= options.most_noise_at_creases && !cloud.conditioning.on_lines)
    report.creased = fit_crease_planes(cloud, options.creases, progress);

  progress.set_range(0.95, 1.0);
  measure_tangent_planes(cloud, options.plane_neighbours, progress);
  return report;
}

void measure_tangent_planes(PointCloud& cloud, int neighbours, Progress& progress) {
  cloud.plane.resize(cloud.position.size());
  parallel_for_each(cloud.size(), kGrain, progress,
                    [&](Index i) { cloud.plane[i] = tangent_plane(cloud, neighbours, i); });
}

}  // namespace shrinkwrap
