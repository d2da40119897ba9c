#include "orientation/component_sides.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "orientation/component_shape.h"
#include "orientation/winding_number.h"

namespace shrinkwrap {
namespace {

constexpr int kMostLayers = 64;           // of components within or behind components
constexpr Index kProbes = 32;             // samples of a component that tell what it lies in
constexpr Index kDrawnPerComponent = 32;  // at least, of each that has as many
constexpr double kSeenOpenly = 0.25;      // of the possible votes: not through a wall
constexpr double kLeastCosine = 0.1;      // of a sheet that faces a direction
constexpr double kLeastInFront = 0.02;    // x samples of a sheet, to tell which way it faces: a few
                                          // houses are, but no stray sets
constexpr double kUnknown = 2.0;          // no majority

// Chooses a sign for every component, layer by layer from outside.
class ComponentSigns {
 public:
  ComponentSigns(const PointCloud& cloud, const SpanningForest& forest, const SampleVotes& votes,
                 const SampleViews& views, const OrientationOptions& options, Progress& progress)
      : cloud_(cloud),
        forest_(forest),
        votes_(votes),
        views_(views),
        options_(options),
        progress_(progress) {}

  ComponentSides decide() {
    ComponentSides sides;
    const auto components = static_cast<std::size_t>(forest_.components);
    shape_ = component_shapes(cloud_, forest_);
    for (const ComponentShape& shape : shape_) size_.push_back(shape.samples);
    by_itself_.assign(components, kUnknown);
    waiting_.assign(components, 1);
    std::vector<char>& flip = sides.flip;
    flip.assign(components, 0);
    std::size_t left = components;
    for (; left > 0 && layer_ < kMostLayers; ++layer_) {
      const std::vector<VisibilityVote> votes = layer_ == 0 ? first_votes() : clear_votes();
      const std::vector<char> enclosed = layer_ > 0 ? within_decided(flip) : std::vector<char>();
      has_ground_ = has_ground_ || sees_ground(votes);
      std::vector<std::size_t> seen, undecided_sheets;
      for (std::size_t c = 0; c < components; ++c) {
        if (!waiting_[c] || is_hidden(c, votes[c])) continue;
        const bool is_of_ground = is_ground(c, votes[c]);
        const double outward = is_of_ground ? 0.0 : measure_outwardness(c, votes[c]);
        seen.push_back(c);
        sides.enclosed += layer_ > 0;
        sides.undecided += is_of_ground || is_close(outward);
        if (is_of_ground || (may_be_open(c, votes[c]) && is_close(outward))) {
          undecided_sheets.push_back(c);
          continue;
        }
        // The wall of a cavity is seen from within the body.
        const bool is_cavity = layer_ > 0 && enclosed[c];
        flip[c] = is_cavity ? outward > 0.0 : outward < 0.0;
        add_to_front(c, flip[c]);
      }
      std::stable_sort(undecided_sheets.begin(), undecided_sheets.end(),
                       [&](std::size_t a, std::size_t b) { return size_[a] > size_[b]; });
      for (const std::size_t c : undecided_sheets) {
        flip[c] = towards_front(c) < 0.0;
        add_to_front(c, flip[c]);
        if (sides.ground.isZero() && is_large_flat_sheet(c))
          sides.ground = signed_normal(c, flip[c]).normalized();
      }
      for (const std::size_t c : seen) waiting_[c] = 0;
      const std::size_t decided = seen.size();
      if (decided == 0) break;
      left -= decided;
    }
    sides.undecided += static_cast<Index>(left);
    if (views_.are_from_one_side() || !do_all_face(sides.ground, flip)) sides.ground.setZero();
    return sides;
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
  bool is_large_flat_sheet(std::size_t component) const {
    const ComponentShape& shape = shape_[component];
    return size_[component] >= options_.least_ground * cloud_.size() && shape.is_sheet() &&
           shape.is_flat();
  }
  // A large flat sheet of which, by itself, more is seen from one side though its shape does not
  // tell: what stands on it hides its front. What only others hide, such as the inner side of a
  // roof or of a face, tells its side. Views from where the ground faces tell of it as of
  // everything.
  bool is_ground(std::size_t component, const VisibilityVote& vote) {
    return !views_.are_from_one_side() && is_large_flat_sheet(component) &&
           may_be_open(component, vote) && !is_close(majority_by_itself(component));
  }
  // Whether the cloud as a whole, of these sides, is a sheet of that front.
  bool do_all_face(const Vec3& front, const std::vector<char>& flip) const {
    double along = 0.0;
    for (std::size_t c = 0; c < shape_.size(); ++c) along += signed_normal(c, flip[c]).dot(front);
    return along > kLeastSheetNormal * cloud_.size();
  }
  bool sees_ground(const std::vector<VisibilityVote>& votes) {
    for (std::size_t c = 0; c < votes.size(); ++c)
      if (waiting_[c] && !is_hidden(c, votes[c]) && is_ground(c, votes[c])) return true;
    return false;
  }
  // Positive if the normals of a component point outwards. Where there is ground, a sheet may be
  // a piece of it, that would tell as little by itself; seen from where it faces, any tells. Pre:
  // it is not ground.
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
    front_ += signed_normal(component, is_flipped);
    in_front_ += size_[component];
  }
  // The sum of its normals.
  Vec3 signed_normal(std::size_t component, bool is_flipped) const {
    const Vec3& sum = shape_[component].normal_sum;
    return is_flipped ? Vec3(-sum) : sum;
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
    SampleVotes samples =
        views_.draw(std::move(drawn), stride, directions, progress_, &forest_.component_of_sample);
    if (layer_ == 0) views_.keep_sides(samples);  // later layers may be walls of cavities
    return samples;
  }
  std::vector<VisibilityVote> by_component(const SampleVotes& samples) const {
    return samples.by_component(forest_.component_of_sample, forest_.components);
  }

  const PointCloud& cloud_;
  const SpanningForest& forest_;
  const SampleVotes& votes_;
  const SampleViews& views_;
  const OrientationOptions& options_;
  Progress& progress_;
  int layer_ = 0;
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

}  // namespace

ComponentSides find_component_sides(const PointCloud& cloud, const SpanningForest& forest,
                                    const SampleVotes& votes, const SampleViews& views,
                                    const OrientationOptions& options, Progress& progress) {
  return ComponentSigns(cloud, forest, votes, views, options, progress).decide();
}

}  // namespace shrinkwrap
