// Does with the plugin what PyMeshLab does, on a MeshLab of either generation:
//
//   scripting_driver PLUGIN functions                 the table of Python names and parameters
//   scripting_driver PLUGIN reconstruct CLOUD DUMP    reconstruct with the defaults, dump the mesh
//   scripting_driver PLUGIN builtins CLOUD            the host's own reconstructions (2021 and
//   later)
//
// A dump holds positions and faces as they are in memory: two hosts agree if their dumps do.
#include <QApplication>
#include <QDir>
#include <QPluginLoader>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <set>

#include "filter_parameters.h"
#include "host_api.h"

// After the host's own headers, which they need.
#include <wrap/io_trimesh/import_ply.h>

#include <wrap/ply/plylib.cpp>

#if SHRINKWRAP_MESHLAB_GENERATION == 2021
#include <common/plugins/plugin_manager.h>
#endif

namespace {

using shrinkwrap::HostInterface;

[[noreturn]] void fail(const std::string& why) {
  std::fprintf(stderr, "scripting_driver: %s\n", why.c_str());
  std::exit(1);
}

void load_cloud(MeshDocument& document, const char* file) {
  MeshModel* layer = document.addNewMesh("", "cloud", true);
  int mask = 0;
  if (vcg::tri::io::ImporterPLY<CMeshO>::Open(layer->cm, file, mask) != 0)
    fail(std::string(file) + " cannot be read");
}

QAction* action_of(HostInterface& plugin, const char* name) {
  for (QAction* action : plugin.actions())
    if (action->text() == name) return action;
  fail(std::string("there is no filter ") + name);
}

RichParameterList parameters_of(HostInterface& plugin, QAction* action, MeshDocument& document) {
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  RichParameterList list;
  plugin.initParameterSet(action, document, list);
  return list;
#else
  return plugin.initParameterList(action, document);
#endif
}

// What the filter hands to scripts, as lines; the error if it failed.
std::string apply(HostInterface& plugin, QAction* action, MeshDocument& document,
                  const RichParameterList& list, bool& succeeded) {
  std::string text;
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  succeeded = plugin.applyFilter(action, document, list, nullptr);
  if (!succeeded) text = plugin.errorMsg().toStdString();
#else
  try {
    unsigned int mask = 0;
    for (const auto& [name, value] : plugin.applyFilter(action, list, document, mask, nullptr))
      text += "  " + name + " = " + value.toString().toStdString() + "\n";
    succeeded = true;
  } catch (const MLException& error) {
    succeeded = false;
    text = error.what();
  }
#endif
  return text;
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

void reconstruct(HostInterface& plugin, const char* cloud, const char* file) {
  QAction* const action =
      action_of(plugin, shrinkwrap::filter_name(shrinkwrap::Filter::reconstruct));
  bool succeeded = false;
  {
    MeshDocument document;
    load_cloud(document, cloud);
    RichParameterList list = parameters_of(plugin, action, document);
    const std::string values = apply(plugin, action, document, list, succeeded);
    if (!succeeded) fail(values);
    std::printf("%s with the defaults:\n%s", qUtf8Printable(action->text()), values.c_str());
    dump(document.mm()->cm, file);

    // With arguments, as a script passes them.
    list.setValue("StopAtParametricSurface", BoolValue(true));
    document.setCurrentMesh(0);
    const std::string surface = apply(plugin, action, document, list, succeeded);
    if (!succeeded) fail(surface);
    std::printf("the same, stopped at the parametric surface:\n%s", surface.c_str());
  }
  // What is wrong must come back as an error, with nothing added to the document.
  MeshDocument document;
  document.addNewMesh("", "empty", true);
  const RichParameterList list = parameters_of(plugin, action, document);
  const std::string error = apply(plugin, action, document, list, succeeded);
  if (succeeded) fail("an empty layer was accepted");
  if (shrinkwrap::layers_of(document).size() != 1) fail("a failed run changed the document");
  std::printf("an empty layer is refused: %s\n", error.c_str());
}

#if SHRINKWRAP_MESHLAB_GENERATION == 2021

void print_functions(HostInterface& plugin) {
  MeshDocument document;
  document.addNewMesh("", "cloud", true);
  for (QAction* action : plugin.actions()) {
    const int id = plugin.ID(action);
    std::printf("\n## %s\n\n`%s`\n\n| parameter | type | default |\n|---|---|---|\n",
                qUtf8Printable(plugin.filterName(id)), qUtf8Printable(plugin.pythonFilterName(id)));
    for (const RichParameter& parameter : plugin.initParameterList(action, document)) {
      const QString name = parameter.pythonName();
      const char* type = parameter.value().isBool()    ? "bool"
                         : parameter.value().isFloat() ? "float"
                                                       : "int";
      QString value;
      if (parameter.value().isBool())
        value = parameter.value().getBool() ? "True" : "False";
      else if (parameter.value().isFloat())
        value = QString::number(parameter.value().getFloat());
      else
        value = QString::number(parameter.value().getInt());
      if (parameter.isOfType<RichEnum>()) type = "int, number of the choice";
      if (parameter.isOfType<RichMesh>()) {
        type = "int, id of a layer";
        value = "the current layer";
      }
      std::printf("| `%s` | %s | %s |\n", qUtf8Printable(name), type, qUtf8Printable(value));
    }
  }
}

struct HostFilter {
  FilterPlugin* plugin = nullptr;
  QAction* action = nullptr;
};
HostFilter find_filter(PluginManager& manager, const QString& python_name) {
  for (FilterPlugin* plugin : manager.filterPluginIterator())
    for (QAction* action : plugin->actions())
      if (plugin->pythonFilterName(plugin->ID(action)) == python_name) return {plugin, action};
  return {};
}

std::string apply_with_defaults(const HostFilter& filter, MeshDocument& document) {
  bool succeeded = false;
  const std::string text =
      apply(*filter.plugin, filter.action, document,
            filter.plugin->initParameterList(filter.action, document), succeeded);
  return succeeded ? "" : text;
}

using Position = std::array<MESHLAB_SCALAR, 3>;
std::set<Position> positions_of(const CMeshO& mesh) {
  std::set<Position> positions;
  for (const auto& vertex : mesh.vert)
    if (!vertex.IsD()) positions.insert({vertex.cP()[0], vertex.cP()[1], vertex.cP()[2]});
  return positions;
}

// The host's own reconstructions of the same cloud, with their defaults, beside ours.
void run_builtins(PluginManager& manager, const char* cloud) {
  std::printf(
      "| filter | vertices | faces | samples kept | seconds |\n|---|---:|---:|---:|---:|\n");
  for (const char* name :
       {"generate_surface_reconstruction_shrink_wrap",
        "generate_surface_reconstruction_ball_pivoting",
        "generate_surface_reconstruction_screened_poisson", "generate_alpha_wrap"}) {
    const HostFilter filter = find_filter(manager, name);
    if (filter.plugin == nullptr) {
      std::printf("| %s | not in this MeshLab | | | |\n", name);
      continue;
    }
    MeshDocument document;
    load_cloud(document, cloud);
    const std::set<Position> samples = positions_of(document.mm()->cm);
    const HostFilter normals = find_filter(manager, "compute_normal_for_point_clouds");
    if (normals.plugin != nullptr) {  // which Screened Poisson wants
      document.mm()->updateDataMask(MeshModel::MM_VERTNORMAL);
      apply_with_defaults(normals, document);
    }
    document.mm()->updateDataMask(filter.plugin->getRequirements(filter.action));
    const auto begin = std::chrono::steady_clock::now();
    const std::string error = apply_with_defaults(filter, document);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const CMeshO& mesh = document.mm()->cm;
    if (!error.empty() || mesh.fn == 0) {
      std::printf("| %s | no mesh | | | |\n", name);
      continue;
    }
    std::size_t kept = 0;
    for (const Position& position : positions_of(mesh)) kept += samples.count(position);
    std::printf("| %s | %d | %d | %zu of %zu | %.2f |\n", name, mesh.vn, mesh.fn, kept,
                samples.size(), seconds);
  }
}

#endif

}  // namespace

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  if (argc < 3)
    fail(
        "usage: scripting_driver PLUGIN functions | reconstruct CLOUD DUMP | builtins CLOUD "
        "FOLDER");
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  QPluginLoader loader(QString::fromLocal8Bit(argv[1]));
  auto* plugin = qobject_cast<HostInterface*>(loader.instance());
  if (plugin == nullptr) fail(loader.errorString().toStdString());
#else
  PluginManager manager;
  HostInterface* plugin = nullptr;
  try {
    plugin = dynamic_cast<HostInterface*>(manager.loadPlugin(QString::fromLocal8Bit(argv[1])));
  } catch (const MLException& error) {
    fail(error.what());
  }
  if (plugin == nullptr) fail("no plugin of filters");
  if (std::strcmp(argv[2], "functions") == 0) {
    print_functions(*plugin);
    return 0;
  }
  if (std::strcmp(argv[2], "builtins") == 0 && argc == 5) {
    try {
      manager.loadPlugins(QDir(QString::fromLocal8Bit(argv[4])));
    } catch (const MLException& error) {
      std::fprintf(stderr, "%s\n", error.what());  // some miss libraries of theirs: go on without
    }
    run_builtins(manager, argv[3]);
    return 0;
  }
#endif
  if (std::strcmp(argv[2], "reconstruct") != 0 || argc != 5) fail("unknown arguments");
  reconstruct(*plugin, argv[3], argv[4]);
  return 0;
}
