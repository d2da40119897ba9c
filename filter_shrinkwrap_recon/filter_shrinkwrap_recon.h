// The MeshLab plugin: names, texts, and one call for each filter.
#pragma once

#include "host_api.h"

class ShrinkWrapReconPlugin : public QObject, public shrinkwrap::FilterHost {
  Q_OBJECT
#if SHRINKWRAP_MESHLAB_GENERATION == 2020
  MESHLAB_PLUGIN_IID_EXPORTER(MESH_FILTER_INTERFACE_IID)
  Q_INTERFACES(MeshFilterInterface)
#else
  MESHLAB_PLUGIN_IID_EXPORTER(FILTER_PLUGIN_IID)
  Q_INTERFACES(FilterPlugin)
#endif

 public:
  ShrinkWrapReconPlugin();

 protected:
  shrinkwrap::FilterDescription describe(int filter) const override;
  void declare_parameters(int filter, shrinkwrap::DocumentOfDialog& document,
                          RichParameterList& list) const override;
  shrinkwrap::FilterRun run(int filter, MeshDocument& document, const RichParameterList& list,
                            vcg::CallBackPos* callback) override;

 private:
  shrinkwrap::Figures run_on_layers(shrinkwrap::Filter filter, MeshDocument& document,
                                    const RichParameterList& list, MeshModel& samples,
                                    MeshModel* mesh, vcg::CallBackPos* callback);
};
