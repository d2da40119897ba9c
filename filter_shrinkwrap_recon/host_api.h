// The only file that knows MeshLab's generation: 2020 is the interface of 2020.09, 2021 that of
// 2021.05 and later. FilterHost turns either into the same four functions; everything else here
// hides a difference of names.
#pragma once

#include <QAction>
#include <QApplication>
#include <QDockWidget>
#include <QObject>
#include <QString>
#include <QStringList>
#include <QTimer>
#include <charconv>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "filter_parameters.h"
#include "filter_runs.h"

#if SHRINKWRAP_MESHLAB_GENERATION == 2020
#include <common/interfaces.h>
#elif SHRINKWRAP_MESHLAB_GENERATION == 2021
#include <common/ml_document/mesh_document.h>
#include <common/plugins/interfaces/filter_plugin.h>
#else
#error "SHRINKWRAP_MESHLAB_GENERATION must be 2020 or 2021"
#endif

namespace shrinkwrap {

#if SHRINKWRAP_MESHLAB_GENERATION == 2020
using HostInterface = MeshFilterInterface;
using HostAction = QAction*;
using HostArity = MeshFilterInterface::FILTER_ARITY;
using DocumentOfDialog = MeshDocument;
#else
using HostInterface = FilterPlugin;
using HostAction = const QAction*;
using HostArity = FilterPlugin::FilterArity;
using DocumentOfDialog = const MeshDocument;
#endif

/// What the host wants to know of a filter.
struct FilterDescription {
  QString name;
  QString scripting_name;  ///< of later generations
  QString help;
  int categories = 0;  ///< HostInterface::FilterClass, or-ed
  bool takes_layers_as_parameters = false;
  int changes = 0;  ///< MeshModel::MM_..., or-ed
};

/// How a run of a filter ended.
struct FilterRun {
  QString error;    ///< why it failed; empty if it did not
  Figures figures;  ///< what later generations hand to scripts
};

#if SHRINKWRAP_MESHLAB_GENERATION == 2020
/// The host makes a dialog at least as high as its content, and forgets the title bar: a dialog
/// higher than two thirds of the screen, which Qt makes no higher than it must be, has its last row
/// below its buttons. This gives it the height of the bar too, once the host has made it.
inline void make_room_for_title_bar(const QString& title) {
  QTimer::singleShot(0, qApp, [title] {
    for (QWidget* window : QApplication::topLevelWidgets()) {
      const auto* dialog = qobject_cast<QDockWidget*>(window);
      if (dialog == nullptr || dialog->windowTitle() != title) continue;
      if (const QWidget* content = dialog->widget())
        window->setMinimumHeight(content->sizeHint().height() + window->height() -
                                 content->height());
    }
  });
}
#endif

/// A plugin of filters, in the terms of neither generation. Filters are numbered from 0.
class FilterHost : public HostInterface {
 public:
  QString filterName(int filter) const override { return describe(filter).name; }
  QString filterInfo(int filter) const override { return describe(filter).help; }
  HostArity filterArity(HostAction action) const override {
    return describe(ID(action)).takes_layers_as_parameters ? HostInterface::FIXED
                                                           : HostInterface::SINGLE_MESH;
  }
  int postCondition(HostAction action) const override { return describe(ID(action)).changes; }
  QString pluginName() const override { return "ShrinkWrapRecon"; }

#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  FilterClass getClass(QAction* action) override {
    return FilterClass(describe(ID(action)).categories);
  }
  void initParameterSet(QAction* action, MeshDocument& document, RichParameterList& list) override {
    declare_parameters(ID(action), document, list);
    make_room_for_title_bar(filterName(ID(action)));
  }
  bool applyFilter(QAction* action, MeshDocument& document, const RichParameterList& list,
                   vcg::CallBackPos* callback) override {
    errorMessage = run(ID(action), document, list, callback).error;
    return errorMessage.isEmpty();
  }
#else
  FilterClass getClass(const QAction* action) const override {
    return FilterClass(describe(ID(action)).categories);
  }
  QString vendor() const override {
    return "filter_shrinkwrap_recon";
  }
  QString pythonFilterName(int filter) const override {
    return describe(filter).scripting_name;
  }
  RichParameterList initParameterList(const QAction* action,
                                      const MeshDocument& document) override {
    RichParameterList list;
    declare_parameters(ID(action), document, list);
    return list;
  }
  std::map<std::string, QVariant> applyFilter(const QAction* action, const RichParameterList& list,
                                              MeshDocument& document, unsigned int&,
                                              vcg::CallBackPos* callback) override {
    const FilterRun done = run(ID(action), document, list, callback);
    if (!done.error.isEmpty()) throw MLException(done.error);
    std::map<std::string, QVariant> values;
    for (const auto& [name, figure] : done.figures)
      values[name] = std::visit([](auto value) { return QVariant(value); }, figure);
    return values;
  }
#endif

 protected:
  virtual FilterDescription describe(int filter) const = 0;
  virtual void declare_parameters(int filter, DocumentOfDialog& document,
                                  RichParameterList& list) const = 0;
  /// Throws nothing.
  virtual FilterRun run(int filter, MeshDocument& document, const RichParameterList& list,
                        vcg::CallBackPos* callback) = 0;

  /// To be called by the constructor of the plugin, which owns the actions.
  void announce_filters(int count, QObject* owner) {
    for (int filter = 0; filter < count; ++filter) {
      typeList.push_back(filter);
      actionList.push_back(new QAction(filterName(filter), owner));
    }
  }

  void log_line(const std::string& text) {
    log_line(GLLogStream::FILTER, text);
  }
  void log_line(GLLogStream::Levels level, const std::string& text) {
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
    Log(level, text);
#else
    log(level, text);
#endif
  }
};

// --- layers ---

/// The layers of a document, in the order in which the host lists them.
template <class Document>
std::vector<decltype(std::declval<Document&>().mm())> layers_of(Document& document) {
  std::vector<decltype(document.mm())> layers;
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  for (MeshModel* layer : document.meshList) layers.push_back(layer);
#else
  for (auto& layer : document.meshIterator()) layers.push_back(&layer);
#endif
  return layers;
}

inline void remove_layer(MeshDocument& document, MeshModel* layer) {
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  document.delMesh(layer);
#else
  document.delMesh(layer->id());
#endif
}

// --- parameters ---

/// Adds one entry to a dialog. Later generations fold advanced entries away.
inline void add_parameter(RichParameterList& list, const Parameter& parameter) {
  const QString name = QString::fromStdString(parameter.name);
  const QString label = QString::fromStdString(parameter.label);
  const QString tooltip = QString::fromStdString(parameter.tooltip);
  const auto add = [&](auto rich_parameter) { list.addParam(rich_parameter); };
  QStringList choices;
  for (const std::string& choice : parameter.choices) choices << QString::fromStdString(choice);
  const auto whole = static_cast<int>(parameter.default_value);
  const auto real = static_cast<MESHLAB_SCALAR>(parameter.default_value);
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  switch (parameter.kind) {
    case Parameter::Kind::boolean:
      return add(RichBool(name, whole != 0, label, tooltip));
    case Parameter::Kind::integer:
      return add(RichInt(name, whole, label, tooltip));
    case Parameter::Kind::real:
      return add(RichFloat(name, real, label, tooltip));
    case Parameter::Kind::choice:
      return add(RichEnum(name, whole, choices, label, tooltip));
#else
  const bool folded = parameter.advanced;
  switch (parameter.kind) {
    case Parameter::Kind::boolean:
      return add(RichBool(name, whole != 0, label, tooltip, folded));
    case Parameter::Kind::integer:
      return add(RichInt(name, whole, label, tooltip, folded));
    case Parameter::Kind::real:
      return add(RichFloat(name, real, label, tooltip, folded));
    case Parameter::Kind::choice:
      return add(RichEnum(name, whole, choices, label, tooltip, folded));
#endif
    case Parameter::Kind::layer:
      return;  // needs the document: add_layer_parameter
  }
}

/// Adds a choice among the layers of the document. Pre: `layer` is one of them.
template <class Layer>
void add_layer_parameter(RichParameterList& list, const Parameter& parameter,
                         DocumentOfDialog& document, Layer* layer) {
  const QString name = QString::fromStdString(parameter.name);
  const QString label = QString::fromStdString(parameter.label);
  const QString tooltip = QString::fromStdString(parameter.tooltip);
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  list.addParam(RichMesh(name, layer, &document, label, tooltip));
#else
  list.addParam(RichMesh(name, static_cast<unsigned int>(layer->id()), &document, label, tooltip));
#endif
}

/// True if the list has the parameter with a value of its kind: the host aborts when asked for any
/// other.
inline bool has_value_of(const RichParameterList& list, const QString& name, Parameter::Kind kind) {
  if (!list.hasParameter(name)) return false;
  const Value& value = list.getParameterByName(name).value();
  switch (kind) {
    case Parameter::Kind::boolean:
      return value.isBool();
    case Parameter::Kind::real:
      return value.isFloat();
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
    case Parameter::Kind::integer:
      return value.isInt() && !value.isEnum();
    case Parameter::Kind::choice:
      return value.isEnum();
    case Parameter::Kind::layer:
      return value.isMesh();
#else
    case Parameter::Kind::integer:
    case Parameter::Kind::choice:
    case Parameter::Kind::layer:
      return value.isInt();
#endif
  }
  return false;
}

/// The layer that was chosen; null if there is none.
inline MeshModel* chosen_layer(const RichParameterList& list, MeshDocument& document,
                               const char* name) {
  if (!has_value_of(list, name, Parameter::Kind::layer)) return nullptr;
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  MeshModel* layer = list.getMesh(name);
#else
  MeshModel* layer = document.getMesh(list.getMeshId(name));
#endif
  for (MeshModel* known : layers_of(document))
    if (known == layer) return layer;
  return nullptr;
}

/// The decimal number that a user typed: 0.4 and not 0.4f.
inline double typed_number(float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  double number = 0.0;
  std::from_chars(text, end, number);
  return number;
}
inline double typed_number(double value) {
  const auto single = static_cast<float>(value);  // through which scripts pass their arguments
  return single == value ? typed_number(single) : value;
}

/// The values of a dialog, layers left out, and those of another type than declared.
inline ParameterValues values_of(const RichParameterList& list,
                                 const std::vector<Parameter>& parameters) {
  ParameterValues values;
  for (const Parameter& parameter : parameters) {
    const QString name = QString::fromStdString(parameter.name);
    if (!has_value_of(list, name, parameter.kind)) continue;
    switch (parameter.kind) {
      case Parameter::Kind::boolean:
        values[parameter.name] = list.getBool(name) ? 1.0 : 0.0;
        break;
      case Parameter::Kind::integer:
        values[parameter.name] = list.getInt(name);
        break;
      case Parameter::Kind::real:
        values[parameter.name] = typed_number(list.getFloat(name));
        break;
      case Parameter::Kind::choice:
        values[parameter.name] = list.getEnum(name);
        break;
      case Parameter::Kind::layer:
        break;
    }
  }
  return values;
}

}  // namespace shrinkwrap
