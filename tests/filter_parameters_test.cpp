#include "filter_parameters.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <limits>
#include <set>

namespace {

using namespace shrinkwrap;

std::vector<Filter> all_filters() {
  std::vector<Filter> filters;
  for (int i = 0; i < kFilterCount; ++i) filters.push_back(static_cast<Filter>(i));
  return filters;
}

TEST(FilterParameters, NamesAreUnique) {
  std::set<std::string> names;
  for (const Filter filter : all_filters()) EXPECT_TRUE(names.insert(filter_name(filter)).second);
  for (const Filter filter : all_filters()) {
    std::set<std::string> keys;
    for (const Parameter& parameter : parameters_of(filter))
      EXPECT_TRUE(keys.insert(parameter.name).second) << parameter.name;
  }
}

// Scripts of others call the functions: in snake_case, and never renamed.
TEST(FilterParameters, NamesForScriptsAreUniqueAndPlain) {
  const std::string snake_case = "abcdefghijklmnopqrstuvwxyz_";
  std::set<std::string> names;
  for (const Filter filter : all_filters()) {
    const std::string name = scripting_name(filter);
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_GT(name.size(), 10u);
    EXPECT_EQ(name.find_first_not_of(snake_case), std::string::npos) << name;
    for (const Parameter& parameter : parameters_of(filter))
      for (const char letter : parameter.name)
        EXPECT_TRUE(std::isalpha(static_cast<unsigned char>(letter)))
            << parameter.name << ": the host would make another name of it";
  }
  EXPECT_EQ(scripting_name(Filter::reconstruct),
            std::string("generate_surface_reconstruction_shrink_wrap"));
}

TEST(FilterParameters, EveryParameterIsExplainedAndItsDefaultAllowed) {
  for (const Filter filter : all_filters())
    for (const Parameter& parameter : parameters_of(filter)) {
      EXPECT_FALSE(parameter.label.empty());
      EXPECT_GT(parameter.tooltip.size(), 20u) << parameter.name;
      EXPECT_GE(parameter.default_value, parameter.minimum) << parameter.name;
      EXPECT_LE(parameter.default_value, parameter.maximum) << parameter.name;
      EXPECT_EQ(parameter.choices.empty(), parameter.kind != Parameter::Kind::choice)
          << parameter.name;
    }
}

TEST(FilterParameters, FewAreNotAdvanced) {
  for (const Filter filter : all_filters()) {
    int simple = 0;
    for (const Parameter& parameter : parameters_of(filter))
      if (!parameter.advanced && parameter.kind != Parameter::Kind::layer) ++simple;
    EXPECT_LE(simple, 4) << filter_name(filter);
  }
}

// Defaults of the dialog are those of the library.
TEST(FilterParameters, DefaultsAreTheLibrarys) {
  const ReconstructionOptions expected;
  for (const Filter filter : all_filters()) {
    const FilterRequest request = request_of(filter, default_values(filter));
    const ReconstructionOptions& options = request.options;
    EXPECT_FALSE(request.selected_only);
    EXPECT_FALSE(request.fail_if_incomplete);
    EXPECT_EQ(options.samples.neighbours, expected.samples.neighbours);
    EXPECT_EQ(options.initial_mesh.start, expected.initial_mesh.start);
    EXPECT_EQ(options.initial_mesh.voxel_size, expected.initial_mesh.voxel_size);
    EXPECT_EQ(options.initial_mesh.level, expected.initial_mesh.level);
    EXPECT_EQ(options.initial_mesh.min_component_samples,
              expected.initial_mesh.min_component_samples);
    EXPECT_EQ(options.initial_mesh.shrink_iterations, expected.initial_mesh.shrink_iterations);
    EXPECT_EQ(options.initial_mesh.levels, expected.initial_mesh.levels);
    EXPECT_EQ(options.initial_mesh.projection, expected.initial_mesh.projection);
    EXPECT_EQ(options.initial_mesh.box_relaxation, expected.initial_mesh.box_relaxation);
    EXPECT_EQ(options.control_mesh.target_vertices, expected.control_mesh.target_vertices);
    EXPECT_EQ(options.parametric_surface.iterations, expected.parametric_surface.iterations);
    EXPECT_EQ(options.parametric_surface.attraction, expected.parametric_surface.attraction);
    EXPECT_EQ(options.complete_matching.openings, expected.complete_matching.openings);
    EXPECT_EQ(options.edge_optimisation.crease_angle, expected.edge_optimisation.crease_angle);
    EXPECT_EQ(options.edge_optimisation.least_gap, expected.edge_optimisation.least_gap);
    EXPECT_EQ(options.report.count_self_intersections, expected.report.count_self_intersections);
    EXPECT_EQ(options.stop_at_parametric_surface, expected.stop_at_parametric_surface);
    EXPECT_EQ(options.keep_stages, expected.keep_stages);
    EXPECT_EQ(options.threads, expected.threads);
  }
}

TEST(FilterParameters, PaperMethodKeepsThePapersConstants) {
  ParameterValues values = default_values(Filter::reconstruct);
  values["Method"] = 1;
  const ReconstructionOptions options = request_of(Filter::reconstruct, values).options;
  const ReconstructionOptions paper = as_in_the_paper();
  EXPECT_EQ(options.initial_mesh.start, paper.initial_mesh.start);
  EXPECT_EQ(options.initial_mesh.projection, paper.initial_mesh.projection);
  EXPECT_EQ(options.control_mesh.area_weighted, paper.control_mesh.area_weighted);
  EXPECT_EQ(options.parametric_surface.target, paper.parametric_surface.target);
  EXPECT_EQ(options.parametric_surface.attraction, paper.parametric_surface.attraction);
  EXPECT_EQ(options.complete_matching.method, paper.complete_matching.method);
  EXPECT_EQ(options.edge_optimisation.criterion, paper.edge_optimisation.criterion);
  EXPECT_EQ(paper.edge_optimisation.crease_angle, 0.0);
  EXPECT_EQ(paper.edge_optimisation.least_gap, 1.0);
  ParameterValues of_edges = default_values(Filter::edge_optimisation);
  of_edges["Method"] = 1;
  EXPECT_EQ(request_of(Filter::edge_optimisation, of_edges).options.edge_optimisation.crease_angle,
            0.0);
  EXPECT_EQ(request_of(Filter::edge_optimisation, of_edges).options.edge_optimisation.least_gap,
            1.0);
}

TEST(FilterParameters, ValuesReachTheirOption) {
  ParameterValues values = default_values(Filter::reconstruct);
  values["StopAtParametricSurface"] = 1;
  values["Openings"] = 1;
  values["SelectedOnly"] = 1;
  values["KeepStages"] = 1;
  values["VoxelSize"] = 1.1;
  values["Threads"] = 2;
  const FilterRequest request = request_of(Filter::reconstruct, values);
  EXPECT_TRUE(request.selected_only);
  EXPECT_TRUE(request.options.stop_at_parametric_surface);
  EXPECT_EQ(request.options.complete_matching.openings,
            CompleteMatchingOptions::Openings::leave_open);
  EXPECT_TRUE(request.options.keep_stages);
  EXPECT_EQ(request.options.initial_mesh.voxel_size, 1.1);
  EXPECT_EQ(request.options.threads, 2);

  ParameterValues of_surface = default_values(Filter::parametric_surface);
  of_surface["Attraction"] = 0.5;
  EXPECT_EQ(
      request_of(Filter::parametric_surface, of_surface).options.parametric_surface.attraction,
      0.5);
  ParameterValues of_control = default_values(Filter::control_mesh);
  of_control["ControlVertices"] = 500;
  EXPECT_EQ(request_of(Filter::control_mesh, of_control).options.control_mesh.target_vertices, 500);
  ParameterValues of_edges = default_values(Filter::edge_optimisation);
  const auto crease_angle = [&] {
    return request_of(Filter::edge_optimisation, of_edges).options.edge_optimisation.crease_angle;
  };
  of_edges["CreaseAngle"] = 45;
  EXPECT_DOUBLE_EQ(crease_angle(), kPi / 4.0);
  of_edges["CreaseAngle"] = 0;
  EXPECT_EQ(crease_angle(), 0.0);
  of_edges["LeastGap"] = 0;
  EXPECT_EQ(request_of(Filter::edge_optimisation, of_edges).options.edge_optimisation.least_gap,
            0.0);
}

// The host of 2020.09 folds nothing away: a row is some 31 pixels, and 16 are 500.
TEST(FilterParameters, DialogsFitAScreen) {
  for (const Filter filter : all_filters()) EXPECT_LE(parameters_of(filter).size(), 16u);
}

// Every parameter of every filter, out of range on either side, no number, and missing.
TEST(FilterParameters, RefusesWhatIsOutOfRangeByName) {
  const auto message_of = [](Filter filter, const ParameterValues& values) -> std::string {
    try {
      request_of(filter, values);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  for (const Filter filter : all_filters())
    for (const Parameter& parameter : parameters_of(filter)) {
      if (parameter.kind == Parameter::Kind::layer) continue;
      for (const double wrong : {parameter.minimum - 1.0, parameter.maximum + 1.0, std::nan(""),
                                 std::numeric_limits<double>::infinity()}) {
        ParameterValues values = default_values(filter);
        values[parameter.name] = wrong;
        EXPECT_NE(message_of(filter, values).find(parameter.name), std::string::npos)
            << parameter.name << ' ' << wrong;
      }
      ParameterValues values = default_values(filter);
      values.erase(parameter.name);
      EXPECT_NE(message_of(filter, values).find(parameter.name), std::string::npos)
          << parameter.name;
    }
}

TEST(FilterParameters, RefusesFractionsOfCountsAndTooFewControlVertices) {
  ParameterValues values = default_values(Filter::reconstruct);
  values["Neighbours"] = 16.5;
  EXPECT_THROW(request_of(Filter::reconstruct, values), InvalidInput);
  values = default_values(Filter::control_mesh);
  values["ControlVertices"] = 3;
  EXPECT_THROW(request_of(Filter::control_mesh, values), InvalidInput);
}

}  // namespace
