// Does with the plugin what PyMeshLab does, on a MeshLab of either generation:
//
//   scripting_driver PLUGIN functions                 the table of Python names and parameters
//   scripting_driver PLUGIN reconstruct CLOUD DUMP    with defaults, with arguments, with errors
//   scripting_driver PLUGIN dump MESH DUMP            a mesh file as a dump
//   scripting_driver PLUGIN builtins CLOUD FOLDER     the reconstructions of the host's plugins
//
// The first and the last need the interface of 2021. A dump holds positions and faces as they are
// in memory: two meshes are the same if their dumps are.
#include <QApplication>
#include <QDir>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <set>

#include "plugin_calls.h"

// After the host's own headers, which they need.
#include <wrap/io_trimesh/import_ply.h>

#include <wrap/ply/plylib.cpp>

#include "python_table.h"
#include "script_figures.h"

#if SHRINKWRAP_MESHLAB_GENERATION == 2021
#include <common/globals.h>
#include <common/plugins/plugin_manager.h>
#include <common/python/function_set.h>
#endif

namespace {

using shrinkwrap::HostInterface;
using shrinkwrap::testing::Applied;
using shrinkwrap::testing::parameter_list;
using Values = std::map<std::string, QVariant>;
using Position = std::array<MESHLAB_SCALAR, 3>;

constexpr bool kHasResultMap = SHRINKWRAP_MESHLAB_GENERATION == 2021;

[[noreturn]] void fail(const std::string& why) {
  std::fprintf(stderr, "scripting_driver: %s\n", why.c_str());
  std::exit(1);
}

void expect(bool holds, const std::string& what) {
  if (!holds) fail("expected: " + what);
}

// --- layers ---

void load(MeshDocument& document, const char* file) {
  MeshModel* layer = document.addNewMesh("", "cloud", true);
  int mask = 0;
  if (vcg::tri::io::ImporterPLY<CMeshO>::Open(layer->cm, file, mask) != 0)
    fail(std::string(file) + " cannot be read");
  vcg::tri::UpdateBounding<CMeshO>::Box(layer->cm);
}

std::set<Position> positions_of(const CMeshO& mesh) {
  std::set<Position> positions;
  for (const auto& vertex : mesh.vert)
    if (!vertex.IsD()) positions.insert({vertex.cP()[0], vertex.cP()[1], vertex.cP()[2]});
  return positions;
}

void dump(const CMeshO& mesh, const char* file) {
  std::ofstream out(file, std::ios::binary);
  for (const auto& vertex : mesh.vert)
    for (int axis = 0; axis < 3; ++axis) {
      const MESHLAB_SCALAR x = vertex.cP()[axis];
      out.write(reinterpret_cast<const char*>(&x), sizeof x);
    }
  for (const auto& face : mesh.face)
    for (int corner = 0; corner < 3; ++corner) {
      const auto v = static_cast<std::int32_t>(face.cV(corner) - mesh.vert.data());
      out.write(reinterpret_cast<const char*>(&v), sizeof v);
    }
  if (!out.flush()) fail(std::string(file) + " cannot be written");
}

// --- calls ---

// Sets an argument by its Python name.
void set_argument(RichParameterList& list, const char* name, const Value& value) {
  for (const RichParameter& parameter : list) {
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
    const QString python_name = parameter.name().toLower();
#else
    const QString python_name = parameter.pythonName();
#endif
    if (python_name == name) return list.setValue(parameter.name(), value);
  }
  fail(std::string("there is no parameter ") + name);
}

// Filters of the host call it without looking whether there is one.
bool go_on(const int, const char*) {
  return true;
}

Applied apply(HostInterface& plugin, QAction* action, MeshDocument& document,
              const RichParameterList& list) {
  return shrinkwrap::testing::apply(plugin, action, document, list, go_on);
}

// --- reconstruct ---

void print_values(const char* title, const Values& values) {
  std::printf("%s:\n", title);
  for (const auto& [name, value] : values)
    std::printf("  %s: %s = %s\n", name.c_str(), value.typeName(),
                qUtf8Printable(value.toString()));
}

// Names and types as documented: a script may rely on them.
void expect_documented(const Values& values) {
  if (!kHasResultMap) return;
  for (const std::string& name :
       shrinkwrap::testing::script_figures(shrinkwrap::Filter::reconstruct))
    expect(values.count(name) == 1, "a value " + name);
  for (const auto& [name, value] : values) {
    const char* const type = shrinkwrap::testing::is_real_figure(name) ? "double" : "int";
    expect(std::strcmp(value.typeName(), type) == 0,
           name + " to be of its type, not " + value.typeName());
  }
}

void expect_refused(HostInterface& plugin, QAction* action, MeshDocument& document,
                    const RichParameterList& list, const char* what, const char* word) {
  const std::size_t layers = shrinkwrap::layers_of(document).size();
  const MeshModel* const current = document.mm();
  const Applied outcome = apply(plugin, action, document, list);
  expect(!outcome.error.empty(), std::string(what) + " to be refused");
  expect(outcome.error.find(word) != std::string::npos,
         std::string(what) + " to be refused by name, not with: " + outcome.error);
  expect(shrinkwrap::layers_of(document).size() == layers && document.mm() == current,
         "a failed run to leave the document");
  std::printf("%s is refused: %s\n", what, outcome.error.c_str());
}

void reconstruct(HostInterface& plugin, const char* cloud, const char* file) {
  QAction* const action = shrinkwrap::testing::action_of(plugin, shrinkwrap::Filter::reconstruct);
  if (action == nullptr) fail("the plugin has no such filter");
  MeshDocument document;
  load(document, cloud);
  MeshModel* const samples = document.mm();
  if (sizeof(MESHLAB_SCALAR) == sizeof(double))  // coordinates that single precision cannot hold
    for (auto& vertex : samples->cm.vert) vertex.P() *= 1.0 + std::ldexp(1.0, -40);
  const std::set<Position> positions = positions_of(samples->cm);

  RichParameterList list = parameter_list(plugin, action, document);
  Applied outcome = apply(plugin, action, document, list);
  if (!outcome.error.empty()) fail(outcome.error);
  print_values("with the defaults", outcome.values);
  expect_documented(outcome.values);
  const CMeshO& mesh = document.mm()->cm;
  expect(document.mm() != samples && mesh.fn > 0, "a new layer with faces");
  expect(positions_of(mesh) == positions && static_cast<std::size_t>(mesh.vn) == positions.size(),
         "every sample to be one vertex, bit for bit, and nothing else");
  std::printf("%d vertices, %d faces; every sample is one vertex, bit for bit (%s)\n", mesh.vn,
              mesh.fn, sizeof(MESHLAB_SCALAR) == sizeof(double) ? "double" : "float");
  dump(mesh, file);

  document.setCurrentMesh(samples->id());
  set_argument(list, "stopatparametricsurface", BoolValue(true));
  set_argument(list, "neighbours", IntValue(12));
  set_argument(list, "voxelsize", FloatValue(2.0f));
  outcome = apply(plugin, action, document, list);
  if (!outcome.error.empty()) fail(outcome.error);
  print_values("stopped at the parametric surface", outcome.values);
  expect_documented(outcome.values);
  expect(document.mm()->label().contains("parametric surface"), "the argument to be heeded");

  document.setCurrentMesh(samples->id());
  set_argument(list, "voxelsize", FloatValue(-3.0f));
  expect_refused(plugin, action, document, list, "a voxel size of -3", "VoxelSize");
  MeshDocument empty;
  empty.addNewMesh("", "empty", true);
  expect_refused(plugin, action, empty, parameter_list(plugin, action, empty), "an empty layer",
                 "no points");
}

#if SHRINKWRAP_MESHLAB_GENERATION == 2021

// --- functions: as the classes that PyMeshLab is made of tell them ---

void print_functions(HostInterface& plugin) {
  const pymeshlab::FunctionSet& functions = pymeshlab::functionSetInstance();
  for (QAction* action : plugin.actions()) {
    const QString name = plugin.pythonFilterName(action);
    expect(functions.containsFilterFunction(name), "a function " + name.toStdString());
    const pymeshlab::Function& function = functions.filterFunction(name);
    expect(function.meshlabFunctionName() == plugin.filterName(action),
           "the function to be that filter");
    shrinkwrap::testing::PythonFunction shown{
        plugin.filterName(action).toStdString(), name.toStdString(), {}};
    for (const pymeshlab::FunctionParameter& parameter : function) {
      shrinkwrap::testing::PythonParameter row{parameter.pythonName().toStdString(),
                                               parameter.pythonTypeString().toStdString(),
                                               parameter.defaultValueString().toStdString(),
                                               {}};
      const RichParameter& rich = parameter.richParameter();
      if (const auto* choice = dynamic_cast<const RichEnum*>(&rich))
        for (const QString& value : choice->enumvalues) row.choices.push_back(value.toStdString());
      if (rich.isOfType<RichMesh>()) row.value = "id of a layer that fits";
      shown.parameters.push_back(row);
    }
    shrinkwrap::testing::print_python_function(shown);
  }
}

// --- builtins: the host's own reconstructions, with their defaults, beside ours ---

struct HostFilter {
  FilterPlugin* plugin = nullptr;
  QAction* action = nullptr;
};
HostFilter find_filter(const QString& python_name) {
  for (FilterPlugin* plugin : meshlab::pluginManagerInstance().filterPluginIterator())
    for (QAction* action : plugin->actions())
      if (plugin->pythonFilterName(action) == python_name) return {plugin, action};
  return {};
}

Applied apply_with_defaults(const HostFilter& filter, MeshDocument& document) {
  if (document.mm() != nullptr)
    document.mm()->updateDataMask(filter.plugin->getRequirements(filter.action));
  return apply(*filter.plugin, filter.action, document,
               parameter_list(*filter.plugin, filter.action, document));
}

void run_builtin(const char* name, const char* cloud) {
  const HostFilter filter = find_filter(name);
  if (filter.plugin == nullptr) {
    std::printf("| `%s` | not in this build of MeshLab | | | |\n", name);
    return;
  }
  MeshDocument document;
  load(document, cloud);
  const std::set<Position> samples = positions_of(document.mm()->cm);
  if (const HostFilter normals = find_filter("compute_normal_for_point_clouds"); normals.plugin) {
    document.mm()->updateDataMask(MeshModel::MM_VERTNORMAL);  // which Screened Poisson wants
    apply_with_defaults(normals, document);
  }
  const auto begin = std::chrono::steady_clock::now();
  const Applied outcome = apply_with_defaults(filter, document);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const CMeshO& mesh = document.mm()->cm;
  if (!outcome.error.empty() || mesh.fn == 0) {
    std::printf("| `%s` | no mesh: %s | | | |\n", name, outcome.error.c_str());
    return;
  }
  std::size_t kept = 0;
  for (const Position& position : positions_of(mesh)) kept += samples.count(position);
  std::printf("| `%s` | %d | %d | %zu of %zu | %.2f |\n", name, mesh.vn, mesh.fn, kept,
              samples.size(), seconds);
}

void run_builtins(const char* cloud, const char* folder) {
  try {
    meshlab::pluginManagerInstance().loadPlugins(QDir(QString::fromLocal8Bit(folder)));
  } catch (const MLException& error) {
    std::fprintf(stderr, "%s\n", error.what());  // told of some; the others are loaded
  }
  std::printf(
      "| filter | vertices | faces | samples kept | seconds |\n|---|---:|---:|---:|---:|\n");
  for (const char* name :
       {"generate_surface_reconstruction_shrink_wrap",
        "generate_surface_reconstruction_ball_pivoting",
        "generate_surface_reconstruction_screened_poisson", "generate_alpha_wrap"}) {
    run_builtin(name, cloud);
    std::fflush(stdout);
  }
}

// As pymeshlab.load_plugin does it.
HostInterface* load_plugin(const QString& file) {
  try {
    PluginManager::checkPlugin(file);
    auto* plugin = dynamic_cast<HostInterface*>(meshlab::pluginManagerInstance().loadPlugin(file));
    if (plugin == nullptr) fail("no plugin of filters");
    pymeshlab::functionSetInstance().loadFilterPlugin(plugin);
    return plugin;
  } catch (const MLException& error) {
    fail(error.what());
  }
}

#else

HostInterface* load_plugin(const QString& file) {
  static_assert(!kHasResultMap, "another generation");
  HostInterface* const plugin = shrinkwrap::testing::load_plugin(file);
  if (plugin == nullptr) fail("no plugin of filters");
  return plugin;
}

#endif

}  // namespace

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  if (argc < 3) fail("usage: see the head of its source");
  HostInterface* const plugin = load_plugin(QString::fromLocal8Bit(argv[1]));
  const std::string command = argv[2];
  if (command == "reconstruct" && argc == 5) {
    reconstruct(*plugin, argv[3], argv[4]);
  } else if (command == "dump" && argc == 5) {
    MeshDocument document;
    load(document, argv[3]);
    dump(document.mm()->cm, argv[4]);
#if SHRINKWRAP_MESHLAB_GENERATION == 2021
  } else if (command == "functions" && argc == 3) {
    print_functions(*plugin);
  } else if (command == "builtins" && argc == 5) {
    run_builtins(argv[3], argv[4]);
#endif
  } else {
    fail("unknown arguments");
  }
  return 0;
}
