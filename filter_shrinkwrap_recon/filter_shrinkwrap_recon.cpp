#include "filter_shrinkwrap_recon.h"

#include <QFileInfo>
#include <QRegularExpression>
#include <initializer_list>
#include <new>

#include "filter_runs.h"
#include "mesh_to_vcg.h"
#include "point_cloud_from_vcg.h"
#include "progress_from_vcg.h"
#include "surface_mesh_from_vcg.h"

MESHLAB_PLUGIN_NAME_EXPORTER(ShrinkWrapReconPlugin)

namespace {

using namespace shrinkwrap;

constexpr bool kHostIsSinglePrecision = sizeof(MESHLAB_SCALAR) == sizeof(float);

// What a sample may carry beside its coordinates, and keeps as a vertex.
constexpr int kCarriedData =
    MeshModel::MM_VERTCOLOR | MeshModel::MM_VERTQUALITY | MeshModel::MM_VERTRADIUS;

// The section of the paper, and whose methods it builds on.
QString reference(const char* section, std::initializer_list<const char*> methods = {}) {
  QString text =
      QString(
          "<br>See: <b>\"Complete 3D Surface Reconstruction from Unstructured Point Cloud\"</b> ") +
      section;
  for (const char* method : methods) text += QString("<br>") + method;
  return text;
}

const char* const kShrinkWrapping =
    "<i>Kobbelt et al.</i> <b>\"A Shrink Wrapping Approach to Remeshing Polygonal Surfaces\"</b> "
    "1999";
const char* const kWindingNumbers =
    "<i>Barill et al.</i> <b>\"Fast Winding Numbers for Soups and Clouds\"</b> 2018";
const char* const kQuadrics =
    "<i>Garland, Heckbert</i> <b>\"Surface Simplification Using Quadric Error Metrics\"</b> 1997";
const char* const kFitting =
    "<i>Suzuki et al.</i> <b>\"Subdivision Surface Fitting to a Range of Points\"</b> 1999";
const char* const kRetiling = "<i>Turk</i> <b>\"Re-Tiling Polygonal Surfaces\"</b> 1992";

// Short: the dialog of 2020.09 shows all of it above all parameters, and is to fit a screen of 768
// rows.
QString help_of(Filter filter) {
  switch (filter) {
    case Filter::reconstruct:
      return "Makes a <b>watertight 2-manifold mesh whose vertices are exactly the points</b> of "
             "the current layer, as a new layer. <b>No normals are needed</b>; colours, qualities "
             "and custom attributes are kept (other vertices have those of the nearest point). For "
             "noisy points, stop at the parametric surface.<br>"
             "Most people need <b>none but the first four parameters</b>." +
             reference("(all sections)");
    case Filter::initial_mesh:
      return "First stage: a <b>closed 2-manifold mesh around the samples</b>, shrunk towards "
             "them. A new layer." +
             reference("section 2.2", {kShrinkWrapping, kWindingNumbers});
    case Filter::control_mesh:
      return "Second stage: <b>simplifies the initial mesh</b> to the number of vertices from "
             "which two subdivisions come nearest to the number of samples. Its topology is kept. "
             "A new layer." +
             reference("section 2.3", {kQuadrics});
    case Filter::parametric_surface:
      return "Third stage: <b>subdivides the control mesh</b> (Loop), twice or until it is as fine "
             "as the samples, and fits it to them: a smooth closed surface near them. A new "
             "layer." +
             reference("section 2.4", {kFitting});
    case Filter::complete_matching:
      return "Fourth stage: makes <b>every sample a vertex</b> of the parametric surface and "
             "removes every vertex that is no sample. The mesh stays a closed 2-manifold. A new "
             "layer, in which the faces that span openings of the scan are selected." +
             reference("section 2.5", {kRetiling});
    case Filter::edge_optimisation:
      return "Last stage: <b>re-chooses the edges</b> of the complete matching for the smoothest "
             "surface through the same vertices. Faces that span an opening (their face quality is "
             "their longest edge in spacings) stay; with <i>Leave open</i> they are taken away. A "
             "new layer." +
             reference("section 2.5", {kQuadrics});
    case Filter::matching_report:
      return "Measures a mesh against samples and writes to the log: vertices, borders, "
             "manifoldness, genus, components, orientation, self-intersections, and <b>how many "
             "samples are exactly one vertex</b>. Nothing is changed.<br>"
             "Use it on the mesh of any reconstruction filter." +
             reference("section 2.5");
    case Filter::distance_to_samples:
      return "Sets the <b>quality of every vertex to its exact distance from the nearest "
             "sample</b>, in the units of the layer, by voxel-based nearest-point search. Colour "
             "the layer by quality afterwards to see where a surface is far from the points." +
             reference("section 2.1");
  }
  return {};
}

bool needs_mesh(Filter filter) {
  return filter != Filter::reconstruct && filter != Filter::initial_mesh;
}

std::string label_of(const MeshModel& layer) {
  return layer.label().toStdString();
}

// What the layers of outliers are called, after that of the samples.
const char* const kOutliers = " outliers";

// The layer's name, without the ending of the file that it was read from: "scan(1)" where the host
// told a second layer of "scan.ply" from the first.
QString base_name(const MeshModel& layer) {
  const QString suffix = QFileInfo(layer.shortName()).suffix(), ending = "." + suffix;
  QString name = layer.label();
  if (!suffix.isEmpty() && name.endsWith(ending) && name != ending) name.chop(ending.size());
  return name;
}

bool is_of_outliers(const MeshModel& layer) {
  static const QRegularExpression name(QString(kOutliers) + "(\\(\\d+\\))?$");
  return name.match(layer.label()).hasMatch();
}

InvalidInput no_layer_for(const char* parameter) {
  return InvalidInput("there is no layer for the parameter " + std::string(parameter));
}

// The layers that a dialog starts with: the current one where it fits, else the first or last of
// its kind, or the first of all. Outliers are no samples.
template <class Layer>
Layer* proposed_layer(const std::vector<Layer*>& layers, Layer* current, bool with_faces) {
  const auto fits = [&](const Layer* layer) {
    return (layer->cm.fn > 0) == with_faces && !is_of_outliers(*layer);
  };
  if (current != nullptr && fits(current)) return current;
  Layer* proposed = nullptr;
  for (Layer* layer : layers)
    if (fits(layer) && (with_faces || proposed == nullptr)) proposed = layer;
  if (proposed != nullptr) return proposed;
  return layers.front();
}

// New layers, taken back unless the run succeeds.
class NewLayers {
 public:
  explicit NewLayers(MeshDocument& document) : document_(document), current_(document.mm()) {}
  NewLayers(const NewLayers&) = delete;
  NewLayers& operator=(const NewLayers&) = delete;
  ~NewLayers() {
    if (is_kept_) return;
    for (MeshModel* layer : layers_) remove_layer(document_, layer);
    if (current_ != nullptr) document_.setCurrentMesh(current_->id());
  }

  void add(const ResultMesh& mesh, const QString& name, const MeshModel& samples,
           const VcgPoints& points, const std::vector<Index>& marked_faces) {
    layers_.reserve(layers_.size() + 1);
    MeshModel* layer = document_.addNewMesh("", name, true);
    layers_.push_back(layer);
    layer->updateDataMask(samples.dataMask() & kCarriedData);
    mesh_to_vcg(mesh, samples.cm, points, layer->cm, marked_faces);
    show_qualities(mesh, samples, *layer);
    layer->cm.Tr = samples.cm.Tr;
    layer->updateDataMask(MeshModel::MM_VERTNORMAL | MeshModel::MM_FACENORMAL);
  }
  // Points of the samples' layer, selected. The layer before it stays the current one.
  void add_points(const ResultMesh& chosen, const QString& name, const MeshModel& samples,
                  const VcgPoints& points) {
    const MeshModel* const current = document_.mm();
    add(chosen, name, samples, points, {});
    for (auto& vertex : layers_.back()->cm.vert) vertex.SetS();
    document_.setCurrentMesh(current->id());
  }
  void keep() { is_kept_ = true; }

 private:
  // The quality that the samples brought is theirs to keep.
  static void show_qualities(const ResultMesh& mesh, const MeshModel& samples, MeshModel& layer) {
    const auto copy = [](const std::vector<float>& quality, auto& elements) {
      for (std::size_t i = 0; i < quality.size(); ++i)
        elements[i].Q() = static_cast<MESHLAB_SCALAR>(quality[i]);
    };
    if (!mesh.vertex_quality.empty() && !samples.hasDataMask(MeshModel::MM_VERTQUALITY)) {
      layer.updateDataMask(MeshModel::MM_VERTQUALITY);
      copy(mesh.vertex_quality, layer.cm.vert);
    }
    if (!mesh.face_quality.empty()) {
      layer.updateDataMask(MeshModel::MM_FACEQUALITY);
      copy(mesh.face_quality, layer.cm.face);
    }
  }

  MeshDocument& document_;
  MeshModel* current_;
  std::vector<MeshModel*> layers_;
  bool is_kept_ = false;
};

}  // namespace

ShrinkWrapReconPlugin::ShrinkWrapReconPlugin() {
  announce_filters(kFilterCount, this);
}

FilterDescription ShrinkWrapReconPlugin::describe(int id) const {
  const Filter filter = static_cast<Filter>(id);
  FilterDescription description;
  description.name = filter_name(filter);
  description.scripting_name = scripting_name(filter);
  description.help = help_of(filter);
  description.takes_layers_as_parameters = filter != Filter::reconstruct;
  switch (filter) {
    case Filter::matching_report:
      description.categories = FilterHost::Measure;
      description.changes = MeshModel::MM_NONE;
      break;
    case Filter::distance_to_samples:
      description.categories = FilterHost::Quality | FilterHost::Measure;
      description.changes = MeshModel::MM_VERTQUALITY;
      break;
    default:
      description.categories = FilterHost::Remeshing | FilterHost::PointSet;
      description.changes = MeshModel::MM_GEOMETRY_AND_TOPOLOGY_CHANGE;
  }
  return description;
}

void ShrinkWrapReconPlugin::declare_parameters(int id, DocumentOfDialog& document,
                                               RichParameterList& list) const {
  const auto layers = layers_of(document);
  for (const Parameter& parameter : parameters_of(static_cast<Filter>(id))) {
    if (parameter.kind != Parameter::Kind::layer)
      add_parameter(list, parameter);
    else if (!layers.empty())  // the host cannot show a choice among none
      add_layer_parameter(list, parameter, document,
                          proposed_layer(layers, document.mm(), parameter.name == kMeshLayer));
  }
}

// The one place where what went wrong becomes the host's message: for the dialog as errorMessage,
// for scripts, which never see that, as a line of the log.
FilterRun ShrinkWrapReconPlugin::run(int id, MeshDocument& document, const RichParameterList& list,
                                     vcg::CallBackPos* callback) {
  const Filter filter = static_cast<Filter>(id);
  std::string where, what;
  try {
    const bool is_one_shot = filter == Filter::reconstruct;
    MeshModel* const samples =
        is_one_shot ? document.mm() : chosen_layer(list, document, kSamplesLayer);
    MeshModel* const mesh = needs_mesh(filter) ? chosen_layer(list, document, kMeshLayer) : nullptr;
    if (samples != nullptr) where = "layer \"" + label_of(*samples) + "\": ";
    if (samples != nullptr && mesh != nullptr && mesh != samples)
      where = "layers \"" + label_of(*samples) + "\" and \"" + label_of(*mesh) + "\": ";
    if (samples == nullptr && (is_one_shot || layers_of(document).empty()))
      throw InvalidInput("there is no layer of samples: open a point cloud first");
    if (samples == nullptr) throw no_layer_for(kSamplesLayer);
    if (needs_mesh(filter) && mesh == nullptr) throw no_layer_for(kMeshLayer);
    return {{}, run_on_layers(filter, document, list, *samples, mesh, callback)};
  } catch (const Cancelled&) {
    what = "cancelled: the document is as it was";
  } catch (const Error& error) {
    what = error.what();
  } catch (const std::bad_alloc&) {
    what =
        "there is not enough memory: close other layers, or thin the cloud first (filter \"Point "
        "Cloud "
        "Simplification\")";
  } catch (const std::exception& error) {
    what = std::string("unexpected error, please report it: ") + error.what();
  } catch (...) {
    what = "unexpected error, please report it";
  }
  const std::string message = kFailed + where + what;
  log_line(GLLogStream::WARNING, message);
  return {QString::fromStdString(message), {}};
}

Figures ShrinkWrapReconPlugin::run_on_layers(Filter filter, MeshDocument& document,
                                             const RichParameterList& list, MeshModel& samples,
                                             MeshModel* mesh, vcg::CallBackPos* callback) {
  FilterRequest request = request_of(filter, values_of(list, parameters_of(filter)));
  request.carries_data = (samples.dataMask() & kCarriedData) != 0 || !samples.cm.vert_attr.empty();
  request.options.host_scalar =
      kHostIsSinglePrecision ? HostScalar::single_precision : HostScalar::double_precision;
  if (mesh != nullptr && !(mesh->cm.Tr == samples.cm.Tr))
    throw InvalidInput(
        "the layer \"" + label_of(*mesh) +
        "\" has another matrix: apply \"Matrix: Freeze Current Matrix\" to both first");

  VcgPoints points = points_from_vcg(samples.cm, request.selected_only);
  if (points.points.empty())
    throw InvalidInput(request.selected_only
                           ? "no point is selected: select some, or switch Selected points only "
                             "(SelectedOnly) off"
                           : "the layer has no points: open a point cloud, or choose its layer");
  FilterInput input;
  input.points = std::move(points.points);
  if (mesh != nullptr) input.mesh = triangles_from_vcg(mesh->cm);

  Progress progress(progress_from_vcg(callback), stages_of(filter, request));
  const FilterOutcome outcome = run_filter(filter, request, input, progress);

  NewLayers layers(document);
  for (const StageRecord& stage : outcome.stages)
    layers.add(stage.mesh, base_name(samples) + " " + QString::fromStdString(stage.name), samples,
               points, {});
  if (!outcome.mesh.position.empty())
    layers.add(outcome.mesh,
               base_name(samples) + " " + QString::fromStdString(outcome.layer_suffix), samples,
               points, outcome.marked_faces);
  if (!outcome.distance.empty()) {
    mesh->updateDataMask(MeshModel::MM_VERTQUALITY);
    std::size_t next = 0;
    for (auto& vertex : mesh->cm.vert)
      if (!vertex.IsD())
        vertex.Q() = static_cast<CMeshO::VertexType::QualityType>(outcome.distance[next++]);
  }
  // Last, so that the numbers of the other layers are those that scripts count on.
  if (!outcome.outliers.position.empty())
    layers.add_points(outcome.outliers, base_name(samples) + kOutliers, samples, points);
  layers.keep();

  for (const std::string& warning : outcome.warnings) log_line(GLLogStream::WARNING, warning);
  for (const std::string& line : outcome.log) log_line(line);
  return outcome.figures;
}
