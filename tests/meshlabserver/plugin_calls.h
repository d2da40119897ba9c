// What a host calls of a plugin of filters, in the terms of neither generation.
#pragma once

#include <QPluginLoader>
#include <QVariant>
#include <cstdio>
#include <map>
#include <string>

#include "host_api.h"

namespace shrinkwrap::testing {

/// Null, and a line on the error output, if the file is no such plugin.
inline HostInterface* load_plugin(const QString& file) {
  QPluginLoader loader(file);
  auto* plugin = qobject_cast<HostInterface*>(loader.instance());
  if (plugin == nullptr) std::fprintf(stderr, "%s\n", qUtf8Printable(loader.errorString()));
  return plugin;
}

/// Null if the plugin has no such filter.
inline QAction* action_of(HostInterface& plugin, Filter filter) {
  for (QAction* action : plugin.actions())
    if (action->text() == filter_name(filter)) return action;
  return nullptr;
}

/// The parameters of a filter with the values that its dialog starts with.
inline RichParameterList parameter_list(HostInterface& plugin, QAction* action,
                                        MeshDocument& document) {
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  RichParameterList list;
  plugin.initParameterSet(action, document, list);
  return list;
#else
  return plugin.initParameterList(action, document);
#endif
}

struct Applied {
  std::string error;                       ///< empty if the filter succeeded
  std::map<std::string, QVariant> values;  ///< of later generations
};

inline Applied apply(HostInterface& plugin, QAction* action, MeshDocument& document,
                     const RichParameterList& list, vcg::CallBackPos* callback) {
  Applied applied;
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  if (!plugin.applyFilter(action, document, list, callback))
    applied.error = plugin.errorMsg().toStdString();
#else
  try {
    unsigned int mask = MeshModel::MM_UNKNOWN;
    applied.values = plugin.applyFilter(action, list, document, mask, callback);
  } catch (const MLException& error) {
    applied.error = error.what();
    if (applied.error.empty()) applied.error = "(no reason given)";
  }
#endif
  return applied;
}

}  // namespace shrinkwrap::testing
