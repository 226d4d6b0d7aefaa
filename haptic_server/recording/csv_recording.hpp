#pragma once

#include <filesystem>
#include <string>

#include "haptic_server/recording/block_file.hpp"
#include "haptic_server/recording/recording_format.hpp"

namespace stillgrid::recording {

/// A row as a line of the CSV, without its end; numbers in the shortest form that reads back the
/// same.
void append_row(const TickRow& row, std::string& line);

/// Where the metadata of a CSV stand, as CSV on the Web has it: FILE.csv-metadata.json.
[[nodiscard]] std::filesystem::path metadata_file(const std::filesystem::path& csv);

/// Comma-separated values: the names of the columns, then a row a tick. The head stands in a file
/// of its own, so that what reads tables reads this one.
class CsvRecording : public RecordingFormat {
 public:
  /// Throws std::runtime_error, one line, if the metadata could not be written; there are none
  /// beside what is no file, as a pipe.
  CsvRecording(BlockFile& file, const std::filesystem::path& path, const RecordingHead& head);

  void begin() override;
  void add_row(const TickRow& row) override;

 private:
  BlockFile& file_;
  std::filesystem::path path_;
  RecordingHead head_;  // empty: no metadata
  std::string line_;
};

}  // namespace stillgrid::recording
