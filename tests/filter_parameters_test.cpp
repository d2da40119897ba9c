#include "filter_parameters.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <limits>
#include <set>

#include "filter_requests.h"

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

// A good value of a parameter that is not its default, and what becomes of it: the option that it
// is translated to, as a number.
struct Translation {
  const char* parameter;
  double value;
  double (*option)(const FilterRequest&);
  double expected;
};

template <class Value>
double as_number(Value value) {
  return static_cast<double>(value);
}

const std::vector<Translation>& translations() {
  using Request = const FilterRequest&;
  static const std::vector<Translation> all = {
      {"Method", 1, [](Request r) { return as_number(r.options.initial_mesh.start); },
       as_number(as_in_the_paper().initial_mesh.start)},
      {"StopAtParametricSurface", 1,
       [](Request r) { return as_number(r.options.stop_at_parametric_surface); }, 1},
      {"SmoothForNoise", 1,
       [](Request r) { return as_number(r.options.stop_at_parametric_surface); }, 1},
      {"SmoothForNoise", 1, [](Request r) { return r.options.denoising.before_initial_mesh_from; },
       0},
      {"BacksAreOpenings", 1,
       [](Request r) { return as_number(r.options.complete_matching.backs_are_openings); }, 1},
      {"Openings", 1, [](Request r) { return as_number(r.options.complete_matching.openings); },
       as_number(CompleteMatchingOptions::Openings::leave_open)},
      {"Openings", 2, [](Request r) { return as_number(r.options.complete_matching.openings); },
       as_number(CompleteMatchingOptions::Openings::automatic)},
      {"SelectedOnly", 1, [](Request r) { return as_number(r.selected_only); }, 1},
      {"ExcludeOutliers", 0, [](Request r) { return as_number(r.options.outliers.exclude); }, 0},
      {"KeepStages", 1, [](Request r) { return as_number(r.options.keep_stages); }, 1},
      {"Threads", 2, [](Request r) { return as_number(r.options.threads); }, 2},
      {"Neighbours", 24, [](Request r) { return as_number(r.options.samples.neighbours); }, 24},
      {"VoxelSize", 1.1, [](Request r) { return r.options.initial_mesh.voxel_size; }, 1.1},
      {"Level", 0.3, [](Request r) { return r.options.initial_mesh.level; }, 0.3},
      {"WidestOpening", 12, [](Request r) { return r.options.complete_matching.widest_opening; },
       12},
      {"MaximumGenus", 3, [](Request r) { return as_number(r.options.initial_mesh.maximum_genus); },
       3},
      {"CutFalseHandles", 0,
       [](Request r) { return as_number(r.options.initial_mesh.false_handles.enabled); }, 0},
      {"MinComponentSamples", 50,
       [](Request r) { return as_number(r.options.initial_mesh.min_component_samples); }, 50},
      {"ShrinkIterations", 7,
       [](Request r) { return as_number(r.options.initial_mesh.shrink_iterations); }, 7},
      {"BoxLevels", 5, [](Request r) { return as_number(r.options.initial_mesh.levels); }, 5},
      {"Projection", 0.6, [](Request r) { return r.options.initial_mesh.projection; }, 0.6},
      {"BoxRelaxation", 0.1, [](Request r) { return r.options.initial_mesh.box_relaxation; }, 0.1},
      {"ControlVertices", 500,
       [](Request r) { return as_number(r.options.control_mesh.target_vertices); }, 500},
      {"FitIterations", 8,
       [](Request r) { return as_number(r.options.parametric_surface.iterations); }, 8},
      {"Attraction", 0.5, [](Request r) { return r.options.parametric_surface.attraction; }, 0.5},
      {"CreaseAngle", 45, [](Request r) { return r.options.edge_optimisation.crease_angle; },
       kPi / 4.0},
      {"CreaseAngle", 0, [](Request r) { return r.options.edge_optimisation.crease_angle; }, 0},
      {"LeastGap", 0.5, [](Request r) { return r.options.edge_optimisation.least_gap; }, 0.5},
      {"LeastGap", 0, [](Request r) { return r.options.edge_optimisation.least_gap; }, 0},
      {"RepairIntersections", 0,
       [](Request r) { return as_number(r.options.intersection_repair.enabled); }, 0},
      {"CountIntersections", 0,
       [](Request r) { return as_number(r.options.report.count_self_intersections); }, 0},
      {"FailIfIncomplete", 1, [](Request r) { return as_number(r.fail_if_incomplete); }, 1},
  };
  return all;
}

std::vector<Translation> translations_of(const std::string& parameter) {
  std::vector<Translation> chosen;
  for (const Translation& translation : translations())
    if (translation.parameter == parameter) chosen.push_back(translation);
  return chosen;
}

// So that no parameter comes without a test of its default and of a value.
TEST(FilterParameters, EveryOneIsInTheTableOfTranslations) {
  std::set<std::string> declared, translated;
  for (const Filter filter : all_filters())
    for (const Parameter& parameter : parameters_of(filter))
      if (parameter.kind != Parameter::Kind::layer) declared.insert(parameter.name);
  for (const Translation& translation : translations()) translated.insert(translation.parameter);
  EXPECT_EQ(declared, translated);
}

// Defaults of the dialog are those of the library, of the options that have no parameter too.
TEST(FilterParameters, DefaultsAreTheLibrarys) {
  const FilterRequest expected;
  for (const Filter filter : all_filters()) {
    SCOPED_TRACE(filter_name(filter));
    const FilterRequest request = request_of(filter, default_values(filter));
    for (const Translation& translation : translations())
      EXPECT_EQ(translation.option(request), translation.option(expected)) << translation.parameter;
  }
}

TEST(FilterParameters, ValuesReachTheirOptionAndNoOther) {
  for (const Filter filter : all_filters())
    for (const Parameter& changed : parameters_of(filter))
      for (const Translation& translation : translations_of(changed.name)) {
        SCOPED_TRACE(std::string(filter_name(filter)) + " " + changed.name);
        ParameterValues values = default_values(filter);
        ASSERT_NE(values.at(changed.name), translation.value) << "the default shows nothing";
        values[changed.name] = translation.value;
        const FilterRequest request = request_of(filter, values);
        EXPECT_DOUBLE_EQ(translation.option(request), translation.expected);
        if (changed.name == "Method") continue;  // which has constants of its own
        for (const Parameter& other : parameters_of(filter)) {
          if (other.name == changed.name) continue;
          for (const Translation& kept : translations_of(other.name))
            EXPECT_EQ(kept.option(request), kept.option(FilterRequest())) << other.name;
        }
      }
}

// "-1: automatic" in a label is a value that a user may type.
TEST(FilterParameters, ValuesNamedInLabelsAreAllowed) {
  int named = 0;
  for (const Filter filter : all_filters())
    for (const Parameter& parameter : parameters_of(filter)) {
      const std::string& label = parameter.label;
      const std::size_t colon = label.find(':');
      if (colon == std::string::npos) continue;
      const std::size_t begin = label.find_last_of(" (", colon) + 1;
      const std::string number = label.substr(begin, colon - begin);
      ParameterValues values = default_values(filter);
      EXPECT_EQ(label.find("below"), std::string::npos) << label << ": not every value below";
      values[parameter.name] = std::stod(number);
      EXPECT_NO_THROW(request_of(filter, values)) << label;
      ++named;
    }
  EXPECT_GE(named, 8);
}

// An opening is where the surface is as far from the samples as this: twice as much from rim to
// rim.
TEST(FilterParameters, TheTooltipTellsHowWideOpeningsAre) {
  ASSERT_EQ(2.0 * CompleteMatchingOptions().membrane_high, 8.0);
  std::string tooltip;
  for (const Parameter& parameter : parameters_of(Filter::reconstruct))
    if (parameter.name == "Openings") tooltip = parameter.tooltip;
  EXPECT_NE(tooltip.find("wider than about eight sample spacings"), std::string::npos) << tooltip;
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

TEST(FilterParameters, RefusesWhatIsNeitherAutomaticNorAValue) {
  for (const char* name : {"CreaseAngle", "LeastGap"}) {
    ParameterValues values = default_values(Filter::edge_optimisation);
    values[name] = -0.5;
    EXPECT_THROW(request_of(Filter::edge_optimisation, values), InvalidInput) << name;
    values[name] = -1.0;
    EXPECT_NO_THROW(request_of(Filter::edge_optimisation, values)) << name;
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
