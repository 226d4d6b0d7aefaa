#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

namespace stillgrid::devices {

/// A file in the temporary folder that lives as long as the test.
class RecordingFile {
 public:
  explicit RecordingFile(std::string_view content)
      : path_(std::filesystem::temp_directory_path() /
              ("stillgrid_recording_" + std::to_string(getpid()) + "_" + std::to_string(++files) +
               ".csv")) {
    std::ofstream(path_, std::ios::binary) << content;
  }
  ~RecordingFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;

  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  static inline int files = 0;
  std::filesystem::path path_;
};

/// The folder of recordings made by others, in $STILLGRID_DATA or beside the source tree.
/// May be absent: they are not part of the project.
inline std::filesystem::path real_recordings() {
  const char* const data = std::getenv("STILLGRID_DATA");
  const std::filesystem::path root =
      data == nullptr ? std::filesystem::path(STILLGRID_SOURCE_DIR) / ".." / "shared" / "data"
                      : std::filesystem::path(data);
  return root / "trajectories";
}

}  // namespace stillgrid::devices
