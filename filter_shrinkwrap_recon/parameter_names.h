// Names of parameters, each used where it is declared and where it is read. Keys of scripts: never
// changed.
#pragma once

namespace shrinkwrap {

constexpr char kMethod[] = "Method";
constexpr char kStopAtSurface[] = "StopAtParametricSurface";
constexpr char kSmoothForNoise[] = "SmoothForNoise";
constexpr char kBacksAreOpenings[] = "BacksAreOpenings";
constexpr char kOpenings[] = "Openings";
constexpr char kSelectedOnly[] = "SelectedOnly";
constexpr char kExcludeOutliers[] = "ExcludeOutliers";
constexpr char kKeepStages[] = "KeepStages";
constexpr char kThreads[] = "Threads";
constexpr char kNeighbours[] = "Neighbours";
constexpr char kVoxelSize[] = "VoxelSize";
constexpr char kLevel[] = "Level";
constexpr char kWidestOpening[] = "WidestOpening";
constexpr char kMaximumGenus[] = "MaximumGenus";
constexpr char kCutFalseHandles[] = "CutFalseHandles";
constexpr char kMinComponent[] = "MinComponentSamples";
constexpr char kShrinkIterations[] = "ShrinkIterations";
constexpr char kBoxLevels[] = "BoxLevels";
constexpr char kProjection[] = "Projection";
constexpr char kBoxRelaxation[] = "BoxRelaxation";
constexpr char kControlVertices[] = "ControlVertices";
constexpr char kFitIterations[] = "FitIterations";
constexpr char kAttraction[] = "Attraction";
constexpr char kCreaseAngle[] = "CreaseAngle";
constexpr char kLeastGap[] = "LeastGap";
constexpr char kRepairIntersections[] = "RepairIntersections";
constexpr char kCountIntersections[] = "CountIntersections";
constexpr char kFailIfIncomplete[] = "FailIfIncomplete";

}  // namespace shrinkwrap
