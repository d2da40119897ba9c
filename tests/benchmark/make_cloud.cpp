// make_cloud (--shape NAME --samples N | --cloud FILE.ply [--samples N]) OUTPUT.ply
//
// Writes a cloud to measure with, so that every program is given the same bytes.
#include <cstdio>
#include <exception>

#include "clouds.h"

int main(int argc, char** argv) {
  using namespace shrinkwrap::benchmarking;
  try {
    CloudChoice choice;
    std::string output;
    for (int i = 1; i < argc; ++i) {
      if (i + 1 < argc && choice.take(argv[i], argv[i + 1]))
        ++i;
      else
        output = argv[i];
    }
    if (output.empty() || output[0] == '-' || choice.name().empty()) {
      std::fprintf(stderr,
                   "usage: make_cloud (--shape NAME --samples N | --cloud FILE.ply [--samples N]) "
                   "OUTPUT.ply\n");
      return 2;
    }
    write_ply(output, make_cloud(choice));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_cloud: %s\n", error.what());
    return 1;
  }
  return 0;
}
