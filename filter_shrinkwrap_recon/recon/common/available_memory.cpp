#include "common/available_memory.h"

#include <algorithm>
#include <fstream>
#include <limits>

namespace shrinkwrap {
namespace {

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

// Where a generation of control groups tells of memory.
struct GroupFiles {
  const char* folder;
  const char* limit;
  const char* usage;
  const char* of_all_below;  // before the names of figures
};
constexpr GroupFiles kFirstGeneration = {"/sys/fs/cgroup/memory", "/memory.limit_in_bytes",
                                         "/memory.usage_in_bytes", "total_"};
constexpr GroupFiles kSecondGeneration = {"/sys/fs/cgroup", "/memory.max", "/memory.current", ""};

// The number that a file begins with; `otherwise` if there is none.
std::uint64_t number_in(const std::string& file, std::uint64_t otherwise) {
  std::ifstream in(file);
  std::uint64_t number = 0;
  return in >> number ? number : otherwise;
}

// The number after a word that begins a line of a file; `otherwise` if there is none.
std::uint64_t number_after(const std::string& word, const std::string& file,
                           std::uint64_t otherwise) {
  std::ifstream in(file);
  for (std::string key; in >> key;) {
    std::uint64_t number = 0;
    if (key == word && in >> number) return number;
    std::string rest_of_line;
    std::getline(in, rest_of_line);
  }
  return otherwise;
}

// What a group may still take.
std::uint64_t left_to_group(const std::string& folder, const GroupFiles& files) {
  const std::uint64_t limit = number_in(folder + files.limit, kUnlimited);
  if (limit == kUnlimited) return kUnlimited;
  const std::uint64_t usage = number_in(folder + files.usage, 0);
  const auto given_up = [&](const char* kind) {
    return number_after(files.of_all_below + std::string(kind), folder + "/memory.stat", 0);
  };
  const std::uint64_t held =
      usage - std::min(usage, given_up("inactive_file") + given_up("active_file") +
                                  given_up("slab_reclaimable"));
  return limit - std::min(limit, held);
}

// The same of the groups of this process and of all those around them. In a container, the folders
// may be named as the machine sees them: what is not there says nothing.
std::uint64_t left_to_groups(const std::string& root) {
  std::uint64_t least = kUnlimited;
  std::ifstream groups(root + "/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {  // number:controllers:path
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool is_second = controllers == ",,";
    if (!is_second && controllers.find(",memory,") == std::string::npos) continue;
    const GroupFiles& files = is_second ? kSecondGeneration : kFirstGeneration;
    for (std::string path = line.substr(second + 1);; path.erase(path.find_last_of('/'))) {
      least = std::min(least, left_to_group(root + files.folder + path, files));
      if (path.find('/') == std::string::npos) break;
    }
  }
  return least;
}

}  // namespace

std::uint64_t available_bytes(const std::string& root) {
  const std::uint64_t kibibytes = number_after("MemAvailable:", root + "/proc/meminfo", 0);
  const std::uint64_t of_machine = kibibytes > 0 ? kibibytes << 10 : kUnlimited;
  const std::uint64_t least = std::min(of_machine, left_to_groups(root));
  return least == kUnlimited ? 0 : std::max<std::uint64_t>(least, 1);
}

}  // namespace shrinkwrap
