// plugin_test PLUGIN: the plugin as the host sees it - loaded, asked and applied - without a
// screen.
#include <gtest/gtest.h>

#include <QApplication>
#include <QCheckBox>
#include <QDockWidget>
#include <QGridLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <cmath>

#include "filter_runs.h"
#include "plugin_calls.h"
#include "shapes.h"

namespace {

using namespace shrinkwrap;
using namespace shrinkwrap::testing;

HostInterface* plugin = nullptr;

RichParameterList parameters_for(Filter filter, MeshDocument& document) {
  return parameter_list(*plugin, action_of(*plugin, filter), document);
}

// Empty on success, else the error message.
std::string apply(Filter filter, MeshDocument& document, const RichParameterList& list,
                  vcg::CallBackPos* callback = nullptr) {
  return shrinkwrap::testing::apply(*plugin, action_of(*plugin, filter), document, list, callback)
      .error;
}

std::string apply(Filter filter, MeshDocument& document, vcg::CallBackPos* callback = nullptr) {
  return apply(filter, document, parameters_for(filter, document), callback);
}

MeshModel* add_cloud(MeshDocument& document, ShapeKind kind, int count,
                     const char* label = "scan.one.ply") {
  MeshModel* layer = document.addNewMesh(label, label, true);  // as if it came from a file
  const std::vector<Vec3> points = sample_shape(kind, count, 1);
  vcg::tri::Allocator<CMeshO>::AddVertices(layer->cm, points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    layer->cm.vert[i].P() = CMeshO::CoordType(points[i].x(), points[i].y(), points[i].z());
  vcg::tri::UpdateBounding<CMeshO>::Box(layer->cm);
  return layer;
}

std::size_t layer_count(MeshDocument& document) {
  return layers_of(document).size();
}

// Everything of a layer that a filter might change by mistake.
std::vector<double> state_of(const MeshModel& layer) {
  std::vector<double> state = {static_cast<double>(layer.cm.vn), static_cast<double>(layer.cm.fn),
                               static_cast<double>(layer.dataMask())};
  for (const auto& vertex : layer.cm.vert) {
    for (int axis = 0; axis < 3; ++axis) state.push_back(vertex.cP()[axis]);
    state.push_back(vertex.cQ());
    state.push_back(vertex.cFlags());
  }
  return state;
}

int last_percent = -1;
bool accept_progress(const int percent, const char* stage) {
  EXPECT_GE(percent, last_percent);
  EXPECT_LE(percent, 100);
  EXPECT_STRNE(stage, "");
  last_percent = percent;
  return true;
}
bool refuse_progress(const int, const char*) {
  return false;
}

TEST(Plugin, HasTheFiltersThatTheHostAccepts) {
  int count = 0;
  for (QAction* action : plugin->actions()) {
    EXPECT_EQ(action->text().toStdString(), filter_name(static_cast<Filter>(count++)));
    EXPECT_NE(plugin->getClass(action), HostInterface::Generic);
    EXPECT_NE(plugin->filterArity(action), HostInterface::UNKNOWN_ARITY);
    EXPECT_NE(plugin->postCondition(action), static_cast<int>(MeshModel::MM_UNKNOWN));
    EXPECT_NE(plugin->getRequirements(action), static_cast<int>(MeshModel::MM_UNKNOWN));
    EXPECT_NE(plugin->getPreConditions(action), static_cast<int>(MeshModel::MM_UNKNOWN));
    const QString help = plugin->filterInfo(plugin->ID(action));
    EXPECT_GT(help.size(), 200);
    EXPECT_TRUE(help.contains("<b>\"")) << "no reference";
  }
  EXPECT_EQ(count, kFilterCount);
}

TEST(Plugin, FailsWithAMessageOnAnEmptyDocument) {
  for (int i = 0; i < kFilterCount; ++i) {
    MeshDocument document;
    const std::string error = apply(static_cast<Filter>(i), document);
    EXPECT_EQ(error.rfind(kFailed, 0), 0u) << error;
    EXPECT_EQ(layer_count(document), 0u);
  }
}

TEST(Plugin, OneShotMakesANewCurrentLayerAndLeavesTheCloud) {
  MeshDocument document;
  MeshModel* cloud = add_cloud(document, ShapeKind::torus, 1500);
  cloud->cm.Tr.SetTranslate(1, 2, 3);
  cloud->updateDataMask(MeshModel::MM_VERTCOLOR | MeshModel::MM_VERTRADIUS);
  auto weight = vcg::tri::Allocator<CMeshO>::AddPerVertexAttribute<float>(cloud->cm, "weight");
  for (int i = 0; i < cloud->cm.vn; ++i) {
    cloud->cm.vert[i].C() = vcg::Color4b(i % 256, i / 256, 7, 255);
    cloud->cm.vert[i].R() = 0.5f * i;
    weight[i] = 0.25f * i;
  }
  const auto before = state_of(*cloud);
  last_percent = -1;
  ASSERT_EQ(apply(Filter::reconstruct, document, accept_progress), "");
  EXPECT_GT(last_percent, 50);
  EXPECT_EQ(state_of(*cloud), before);

  ASSERT_EQ(layer_count(document), 2u);
  MeshModel* mesh = document.mm();
  ASSERT_NE(mesh, cloud);
  EXPECT_EQ(mesh->label().toStdString(), "scan.one shrink wrap");
  EXPECT_EQ(mesh->cm.Tr, cloud->cm.Tr);
  EXPECT_EQ(mesh->cm.vn, 1500);
  EXPECT_EQ(mesh->cm.fn, 3000) << "genus 1: as many edges as give V - E + F = 0";
  EXPECT_TRUE(mesh->hasDataMask(MeshModel::MM_VERTCOLOR));
  EXPECT_TRUE(mesh->hasDataMask(MeshModel::MM_VERTRADIUS));
  EXPECT_FALSE(mesh->hasDataMask(MeshModel::MM_VERTQUALITY));
  auto copied = vcg::tri::Allocator<CMeshO>::FindPerVertexAttribute<float>(mesh->cm, "weight");
  ASSERT_TRUE(vcg::tri::Allocator<CMeshO>::IsValidHandle(mesh->cm, copied));
  for (int i = 0; i < 1500; i += 100) {  // without duplicates, vertex i is point i
    EXPECT_EQ(mesh->cm.vert[i].cP(), cloud->cm.vert[i].cP());
    EXPECT_TRUE(mesh->cm.vert[i].C() == cloud->cm.vert[i].C());
    EXPECT_EQ(mesh->cm.vert[i].R(), cloud->cm.vert[i].R());
    EXPECT_EQ(copied[i], weight[i]);
  }
  EXPECT_FALSE(mesh->cm.bbox.IsNull());
}

TEST(Plugin, CancelLeavesTheDocumentAsItWas) {
  MeshDocument document;
  MeshModel* cloud = add_cloud(document, ShapeKind::sphere, 1000);
  const auto before = state_of(*cloud);
  const std::string error = apply(Filter::reconstruct, document, refuse_progress);
  EXPECT_NE(error.find("cancelled"), std::string::npos) << error;
  EXPECT_EQ(layer_count(document), 1u);
  EXPECT_EQ(document.mm(), cloud);
  EXPECT_EQ(state_of(*cloud), before);
  EXPECT_EQ(apply(Filter::reconstruct, document), "")
      << "the next run must not remember the cancel";
}

TEST(Plugin, FailureNamesTheLayerAndLeavesTheDocument) {
  MeshDocument document;
  MeshModel* cloud = add_cloud(document, ShapeKind::sphere, 3, "tiny.ply");
  const std::string error = apply(Filter::reconstruct, document);
  EXPECT_NE(error.find("tiny.ply"), std::string::npos) << error;
  EXPECT_EQ(layer_count(document), 1u);
  EXPECT_EQ(document.mm(), cloud);
}

// A list without the parameter `name`: what the host makes of a layer that does not exist.
RichParameterList without(const RichParameterList& list, const char* name) {
  RichParameterList rest;
  for (const RichParameter& parameter : list)
    if (parameter.name() != name) rest.addParam(parameter);
  return rest;
}

TEST(Plugin, ALayerThatIsNotThereIsToldByTheNameOfItsParameter) {
  MeshDocument document;
  add_cloud(document, ShapeKind::sphere, 500);
  ASSERT_EQ(apply(Filter::reconstruct, document), "");
  for (const char* name : {kSamplesLayer, kMeshLayer}) {
    const RichParameterList list = without(parameters_for(Filter::matching_report, document), name);
    const std::string error = apply(Filter::matching_report, document, list);
    EXPECT_NE(error.find(std::string("no layer for the parameter ") + name), std::string::npos)
        << error;
    EXPECT_EQ(error.find("open a point cloud"), std::string::npos) << error;
  }
}

TEST(Plugin, SelectedPointsOnly) {
  MeshDocument document;
  MeshModel* cloud = add_cloud(document, ShapeKind::two_spheres, 2000);
  RichParameterList list = parameters_for(Filter::reconstruct, document);
  list.setValue("SelectedOnly", BoolValue(true));
  EXPECT_NE(apply(Filter::reconstruct, document, list).find("no point is selected"),
            std::string::npos);
  int selected = 0;
  for (auto& vertex : cloud->cm.vert)
    if (vertex.cP()[0] > 0) {
      vertex.SetS();
      ++selected;
    }
  ASSERT_EQ(apply(Filter::reconstruct, document, list), "");
  EXPECT_EQ(document.mm()->cm.vn, selected);
}

TEST(Plugin, KeptStagesBecomeLayersAndTheResultIsCurrent) {
  MeshDocument document;
  add_cloud(document, ShapeKind::sphere, 1000, "ball.ply");
  RichParameterList list = parameters_for(Filter::reconstruct, document);
  list.setValue("KeepStages", BoolValue(true));
  ASSERT_EQ(apply(Filter::reconstruct, document, list), "");
  std::vector<std::string> labels;
  for (MeshModel* layer : layers_of(document)) labels.push_back(layer->label().toStdString());
  EXPECT_EQ(labels, (std::vector<std::string>{"ball.ply", "ball initial mesh", "ball control mesh",
                                              "ball parametric surface", "ball complete matching",
                                              "ball shrink wrap"}));
  EXPECT_EQ(document.mm()->label().toStdString(), "ball shrink wrap");
}

TEST(Plugin, KeptStagesOfThePaperBeginWithTheBox) {
  MeshDocument document;
  add_cloud(document, ShapeKind::sphere, 1000, "ball.ply");
  RichParameterList list = parameters_for(Filter::reconstruct, document);
  list.setValue("KeepStages", BoolValue(true));
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  list.setValue("Method", EnumValue(1));
#else
  list.setValue("Method", IntValue(1));
#endif
  ASSERT_EQ(apply(Filter::reconstruct, document, list), "");
  const auto layers = layers_of(document);
  ASSERT_EQ(layers.size(), 7u);
  EXPECT_EQ(layers[1]->label().toStdString(), "ball bounding box");
  EXPECT_EQ(layers[1]->cm.vn, 8);
  EXPECT_EQ(layers[1]->cm.fn, 12);
}

// The highest quality among the vertices or faces of a layer.
template <class Elements>
double highest_quality(const Elements& elements) {
  double highest = -INFINITY;
  for (const auto& element : elements) highest = std::max<double>(highest, element.cQ());
  return highest;
}

TEST(Plugin, KeptStagesShowDistanceAndSpanningLength) {
  MeshDocument document;
  add_cloud(document, ShapeKind::hemisphere, 3000);
  RichParameterList list = parameters_for(Filter::reconstruct, document);
  list.setValue("KeepStages", BoolValue(true));
  ASSERT_EQ(apply(Filter::reconstruct, document, list), "");
  const auto layers = layers_of(document);
  const double spacing = 2.0 * std::sqrt(3.14159 / 3000);
  for (const MeshModel* layer : {layers[layers.size() - 2], layers.back()}) {
    ASSERT_TRUE(layer->hasDataMask(MeshModel::MM_VERTQUALITY));
    ASSERT_TRUE(layer->hasDataMask(MeshModel::MM_FACEQUALITY));
    EXPECT_GT(highest_quality(layer->cm.vert), 0.0);
    EXPECT_LT(highest_quality(layer->cm.vert), 3 * spacing);
    int spanning = 0;
    for (const auto& face : layer->cm.face) spanning += face.cQ() > 0;
    EXPECT_GT(spanning, 0);
    EXPECT_LT(spanning, layer->cm.fn / 2) << "only the opening is spanned";
    EXPECT_GT(highest_quality(layer->cm.face), 2.0) << "a spanned opening is wider than samples";
  }
}

TEST(Plugin, QualityOfTheSamplesIsTheirsToKeep) {
  MeshDocument document;
  MeshModel* cloud = add_cloud(document, ShapeKind::sphere, 1000);
  cloud->updateDataMask(MeshModel::MM_VERTQUALITY);
  for (int i = 0; i < cloud->cm.vn; ++i) cloud->cm.vert[i].Q() = 5.0f + i;
  RichParameterList list = parameters_for(Filter::reconstruct, document);
  list.setValue("KeepStages", BoolValue(true));
  ASSERT_EQ(apply(Filter::reconstruct, document, list), "");
  for (int i = 0; i < cloud->cm.vn; ++i)
    EXPECT_EQ(document.mm()->cm.vert[i].Q(), cloud->cm.vert[i].Q());
}

TEST(Plugin, ASurfaceHasTheColoursOfTheSamplesAroundEachVertex) {
  MeshDocument document;
  MeshModel* cloud = add_cloud(document, ShapeKind::sphere, 2000);
  cloud->updateDataMask(MeshModel::MM_VERTCOLOR);
  const vcg::Color4b left(255, 0, 0, 255), right(0, 0, 255, 255);
  for (auto& vertex : cloud->cm.vert) vertex.C() = vertex.cP()[0] < 0 ? left : right;
  RichParameterList list = parameters_for(Filter::reconstruct, document);
  list.setValue("StopAtParametricSurface", BoolValue(true));
  list.setValue("KeepStages", BoolValue(true));
  ASSERT_EQ(apply(Filter::reconstruct, document, list), "");
  ASSERT_GT(layer_count(document), 2u);
  for (const MeshModel* layer : layers_of(document)) {
    EXPECT_TRUE(layer->hasDataMask(MeshModel::MM_VERTCOLOR));
    for (const auto& vertex : layer->cm.vert) {
      if (std::abs(vertex.cP()[0]) < 0.2) continue;
      EXPECT_TRUE(vertex.cC() == (vertex.cP()[0] < 0 ? left : right))
          << layer->label().toStdString();
    }
  }
}

TEST(Plugin, OnlyTheEndingOfAFileIsLeftOutOfNames) {
  for (const auto& [label, name] : {std::pair("scan 1.1", "scan 1.1 shrink wrap"),
                                    std::pair("scan.one(1).ply", "scan.one(1) shrink wrap")}) {
    MeshDocument document;
    add_cloud(document, ShapeKind::sphere, 500)->setLabel(label);
    ASSERT_EQ(apply(Filter::reconstruct, document), "");
    EXPECT_EQ(document.mm()->label().toStdString(), name);
  }
}

// A cloud that came with faces, and its strays, which have none.
TEST(Plugin, OutliersAreNotProposedAsSamples) {
  MeshDocument document;
  MeshModel* cloud = add_cloud(document, ShapeKind::sphere, 1000);
  vcg::tri::Allocator<CMeshO>::AddVertices(cloud->cm, 1)->P() = CMeshO::CoordType(9, 9, 9);
  vcg::tri::Allocator<CMeshO>::AddFace(cloud->cm, 0, 1, 2);
  ASSERT_EQ(apply(Filter::initial_mesh, document, parameters_for(Filter::initial_mesh, document)),
            "");
  ASSERT_EQ(layer_count(document), 3u);
  for (MeshModel* layer : layers_of(document))
    if (layer->cm.fn == 0) {
      layer->setLabel(layer->label() + "(1)");  // as the host tells it from another
      document.setCurrentMesh(layer->id());
    }
  const RichParameterList list = parameters_for(Filter::control_mesh, document);
  EXPECT_EQ(chosen_layer(list, document, kSamplesLayer), cloud);
}

TEST(Plugin, DialogsOfTwoLayersProposeCloudAndMesh) {
  MeshDocument document;
  MeshModel* cloud = add_cloud(document, ShapeKind::sphere, 1000);
  ASSERT_EQ(apply(Filter::reconstruct, document), "");
  MeshModel* mesh = document.mm();
  const RichParameterList list = parameters_for(Filter::matching_report, document);
  EXPECT_EQ(chosen_layer(list, document, kSamplesLayer), cloud);
  EXPECT_EQ(chosen_layer(list, document, kMeshLayer), mesh);
}

TEST(Plugin, ReportChangesNothingAndDistanceOnlyTheQuality) {
  MeshDocument document;
  MeshModel* cloud = add_cloud(document, ShapeKind::sphere, 1000);
  RichParameterList list = parameters_for(Filter::reconstruct, document);
  list.setValue("StopAtParametricSurface", BoolValue(true));
  ASSERT_EQ(apply(Filter::reconstruct, document, list), "");
  MeshModel* mesh = document.mm();
  const auto cloud_before = state_of(*cloud), mesh_before = state_of(*mesh);
  ASSERT_EQ(apply(Filter::matching_report, document), "");
  EXPECT_EQ(state_of(*mesh), mesh_before);
  ASSERT_EQ(apply(Filter::distance_to_samples, document), "");
  EXPECT_EQ(state_of(*cloud), cloud_before);
  EXPECT_EQ(layer_count(document), 2u);
  EXPECT_TRUE(mesh->hasDataMask(MeshModel::MM_VERTQUALITY));
  for (std::size_t i = 0; i < mesh->cm.vert.size(); i += 97) {
    double nearest = INFINITY;
    for (const auto& sample : cloud->cm.vert)
      nearest = std::min<double>(nearest, vcg::Distance(sample.cP(), mesh->cm.vert[i].cP()));
    EXPECT_NEAR(mesh->cm.vert[i].Q(), nearest, 1e-6);
  }
}

TEST(Plugin, LayersOfDifferentMatricesAreRefused) {
  MeshDocument document;
  add_cloud(document, ShapeKind::sphere, 500);
  ASSERT_EQ(apply(Filter::reconstruct, document), "");
  document.mm()->cm.Tr.SetTranslate(1, 0, 0);
  EXPECT_NE(apply(Filter::matching_report, document).find("matrix"), std::string::npos);
}

TEST(Plugin, WrongValuesAndTypesAreRefusedByName) {
  MeshDocument document;
  add_cloud(document, ShapeKind::sphere, 500);
  RichParameterList list = parameters_for(Filter::reconstruct, document);
  list.setValue("VoxelSize", FloatValue(-3.0f));
  EXPECT_NE(apply(Filter::reconstruct, document, list).find("VoxelSize"), std::string::npos);
  RichParameterList other;
  for (const RichParameter& parameter : parameters_for(Filter::reconstruct, document))
    if (parameter.name() == "VoxelSize")
      other.addParam(RichString("VoxelSize", "large"));
    else
      other.addParam(parameter);
  EXPECT_NE(apply(Filter::reconstruct, document, other).find("VoxelSize"), std::string::npos);
  EXPECT_EQ(layer_count(document), 1u);
}

#if SHRINKWRAP_MESHLAB_GENERATION == 2020
// A dialog as 2020.09 makes it, of usual fonts: a title bar of its own, help, a row for each
// parameter, two rows of buttons. (Later generations scroll.)
class HostDialog : public QDockWidget {
 public:
  HostDialog(Filter filter, MeshDocument& document) {
    const RichParameterList list = parameters_for(filter, document);
    setWindowTitle(filter_name(filter));
    setFloating(true);
    QFont font;
    font.setPixelSize(12);
    setFont(font);
    auto* const title = new QLabel(filter_name(filter));
    title->setFixedHeight(21);
    setTitleBarWidget(title);
    auto* const content = new QFrame(this);
    setWidget(content);
    auto* const grid = new QGridLayout(content);
    auto* const help = new QLabel("<i>" + plugin->filterInfo(static_cast<int>(filter)) + "</i>");
    help->setTextFormat(Qt::RichText);
    help->setWordWrap(true);
    grid->addWidget(help, 0, 0, 1, 2, Qt::AlignTop);
    auto* const rows = new QFrame(content);
    auto* const of_rows = new QGridLayout(rows);
    of_rows->setAlignment(Qt::AlignTop);
    for (const RichParameter& parameter : list) {
      const int row = of_rows->rowCount();
      of_rows->addWidget(new QLabel(parameter.fieldDescription()), row, 0);
      if (parameter.value().isBool())
        last_row_ = new QCheckBox;
      else
        last_row_ = new QLineEdit;
      of_rows->addWidget(last_row_, row, 1);
    }
    rows->setMinimumSize(of_rows->sizeHint());
    grid->addWidget(rows, 1, 0, 1, 2);
    first_button_ = new QPushButton("Help");
    grid->addWidget(first_button_, 2, 0, Qt::AlignBottom);
    grid->addWidget(new QPushButton("Apply"), 3, 0, Qt::AlignBottom);
    content->showNormal();
    content->adjustSize();
    setMinimumSize(content->sizeHint());
    showNormal();
    adjustSize();
  }
  int end_of_rows() const { return last_row_->mapTo(this, last_row_->rect().bottomLeft()).y(); }
  int begin_of_buttons() const { return first_button_->mapTo(this, QPoint(0, 0)).y(); }

 private:
  QWidget *last_row_ = nullptr, *first_button_ = nullptr;
};

TEST(Plugin, DialogsShowEveryRowAboveTheirButtonsOnASmallScreen) {
  MeshDocument document;
  add_cloud(document, ShapeKind::sphere, 500);
  ASSERT_EQ(apply(Filter::reconstruct, document), "");
  for (int i = 0; i < kFilterCount; ++i) {
    const auto filter = static_cast<Filter>(i);
    HostDialog dialog(filter, document);
    QApplication::processEvents();
    EXPECT_LT(dialog.end_of_rows(), dialog.begin_of_buttons()) << filter_name(filter);
    // The real one is some 70 pixels higher where there are most rows.
    EXPECT_LE(dialog.height(), 690) << filter_name(filter);
  }
}
#endif

TEST(Plugin, NumbersAreThoseThatWereTyped) {
  EXPECT_EQ(typed_number(0.4f), 0.4);
  EXPECT_EQ(typed_number(static_cast<double>(0.4f)), 0.4) << "a script's, in a host of doubles";
  EXPECT_EQ(typed_number(0.1234567890123), 0.1234567890123);
  EXPECT_TRUE(std::isnan(typed_number(NAN)));
}

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  QApplication application(argc, argv);
  if (argc < 2) return 2;
  plugin = load_plugin(QString::fromLocal8Bit(argv[1]));
  return plugin == nullptr ? 1 : RUN_ALL_TESTS();
}
