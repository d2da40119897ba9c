#include "common/available_memory.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace shrinkwrap {
namespace {

// A machine with 8,000 KiB available, as files tell of it.
class AvailableMemory : public ::testing::Test {
 protected:
  void SetUp() override {
    const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
    root_ = std::filesystem::path(::testing::TempDir()) /
            ("shrinkwrap_" + std::to_string(getpid()) + "_" + test->name());
    std::filesystem::remove_all(root_);
    write("proc/meminfo", "MemTotal:  16000 kB\nMemAvailable:   8000 kB\nSwapFree: 1 kB\n");
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  void write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  void write_group(const std::string& folder, const std::string& limit,
                   const std::string& usage) const {
    write(folder + "/memory.max", limit + "\n");
    write(folder + "/memory.current", usage + "\n");
  }
  std::uint64_t available() const { return available_bytes(root_.string()); }

  std::filesystem::path root_;
};

TEST_F(AvailableMemory, IsTheMachinesWithoutGroups) {
  EXPECT_EQ(available(), 8000u * 1024);
  write("proc/self/cgroup", "0::/\n");
  EXPECT_EQ(available(), 8000u * 1024);
  write_group("sys/fs/cgroup", "max", "1000");
  EXPECT_EQ(available(), 8000u * 1024);
}

TEST_F(AvailableMemory, IsUnknownWhereNothingTells) {
  std::filesystem::remove_all(root_);
  EXPECT_EQ(available(), 0u);
}

TEST_F(AvailableMemory, IsLimitedByTheGroup) {
  write("proc/self/cgroup", "0::/a/b\n");
  write_group("sys/fs/cgroup/a/b", "3000000", "500000");
  EXPECT_EQ(available(), 2500000u);
  // Files can be given up, whatever holds them.
  write("sys/fs/cgroup/a/b/memory.stat",
        "anon 200000\nfile 300000\ninactive_file 150000\nactive_file 50000\n"
        "slab_reclaimable 1000\n");
  EXPECT_EQ(available(), 2701000u);
  write_group("sys/fs/cgroup/a/b", "3000000", "4000000");
  EXPECT_EQ(available(), 1u) << "nothing, but that is known";
}

TEST_F(AvailableMemory, IsLimitedByGroupsAroundIt) {
  write("proc/self/cgroup", "0::/a/b\n");
  write_group("sys/fs/cgroup/a/b", "max", "500000");
  write_group("sys/fs/cgroup/a", "2000000", "500000");
  EXPECT_EQ(available(), 1500000u);
}

// Whose files are those at the root, whatever its name outside.
TEST_F(AvailableMemory, IsLimitedByTheContainer) {
  write("proc/self/cgroup", "4:cpu,memory:/docker/0123\n3:cpuset:/\n0::/\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "4000000\n");
  write("sys/fs/cgroup/memory/memory.usage_in_bytes", "1000000\n");
  write("sys/fs/cgroup/memory/memory.stat", "inactive_file 7\ntotal_inactive_file 200000\n");
  EXPECT_EQ(available(), 3200000u);
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");  // none
  EXPECT_EQ(available(), 8000u * 1024);
}

}  // namespace
}  // namespace shrinkwrap
