#include "shared/tools/scene_viewer/recorded_view.hpp"

#include <catch2/catch.hpp>

#include "shared/files/old_names.hpp"
#include "tests/shared/tools/scene_viewer/refusal_line.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::scene_viewer::recorded_view_test {
namespace {

const std::string kHead = "# scene: wall\ntime_s,x_m,y_m,z_m,fz_N,age_s,flags,future_column\n";

TEST_CASE("A recording's rows are its ticks, with what it tells of them", "[recorded_view]") {
  const tests::TestFolder folder;
  const auto rows = read_recording(folder.write(
      "run.csv", kHead + "0,1,2,3,0.5,0.01,,x\n\n0.001,1,2,4,-0.5,0.02,faded|slewed,y\n0.002,1,2"));
  REQUIRE(rows.size() == 2);  // the cut line is left out
  CHECK(rows[0].sample.position_m == std::array{1.0, 2.0, 3.0});
  CHECK(rows[1].sample.tick == 2);
  CHECK(rows[1].sample.force_N[2] == -0.5);
  CHECK(rows[1].sample.age_s == 0.02);
  CHECK(rows[1].sample.flags == (proto::kFlagFaded | proto::kFlagSlewed));
  CHECK(rows[1].orientation_xyzw == std::array{0.0, 0.0, 0.0, 1.0});
}

TEST_CASE("A recording of the old names of columns and flags is read alike", "[recorded_view]") {
  const tests::TestFolder folder;
  const auto read = [&](bool is_old) {
    std::string names = "time_s,x_m,y_m,z_m,flags", row = "0,1,2,3,faded|";
    row += is_old ? files::kOldFlags[0].before : files::kOldFlags[0].now;
    for (std::size_t i = 0; i < files::kOldColumns.size(); ++i) {
      names.append(",").append(is_old ? files::kOldColumns[i].before : files::kOldColumns[i].now);
      row += "," + std::to_string(7 + i);
    }
    return read_recording(folder.write("run.csv", names + "\n" + row + "\n"));
  };
  for (const auto& rows : {read(true), read(false)}) {
    CHECK(rows[0].sample.snapshot_id == 7);
    CHECK(rows[0].torque_N_m == std::array{8.0, 9.0, 10.0});
    CHECK(rows[0].sample.flags == (proto::kFlagFaded | proto::kFlagTruncated));
  }
}

TEST_CASE("A recording with a column under its old name and today's is refused in one line",
          "[recorded_view]") {
  const tests::TestFolder folder;
  for (const auto& [before, now] : files::kOldColumns) {
    const auto file = folder.write("run.csv", "time_s,x_m,y_m,z_m," + std::string(before) + "," +
                                                  std::string(now) + "\n0,1,2,3,4,5\n");
    CHECK(refusal_line([&] { (void)read_recording(file); })
              .ends_with("run.csv:1: column " + std::string(now) +
                         ": given twice, by this name or an earlier one"));
  }
}

TEST_CASE("A last row without the end of its line is kept if all of it is there",
          "[recorded_view]") {
  const tests::TestFolder folder;
  const auto count = [&](const std::string& last) {
    return read_recording(folder.write("run.csv", kHead + "0,1,2,3,0,0,,x\n" + last)).size();
  };
  CHECK(count("0.001,1,2,4,0,0,faded,y") == 2);
  CHECK(count("0.001,1,2,4,0,0,fad") == 1);
  CHECK(count("0.001,1,2,4,0,0,fad,") == 1);
  CHECK(count("0.001,1,2,-") == 1);
}

TEST_CASE("A recording is shown in 30 frames a second, each the row of its time",
          "[recorded_view]") {
  const tests::TestFolder folder;
  std::string text = "time_s,x_m,y_m,z_m\n";
  for (int i = 0; i <= 1000; ++i)
    text += std::to_string(5.0 + 1e-3 * i) + "," + std::to_string(i) + ",0,0\n";
  const RecordedView view(folder.write("run.csv", text));
  CHECK(view.status().first_frame == 1);
  CHECK(view.status().last_frame == 31);
  CHECK(view.frame(1)->find(R"("position_m":[0.0,)") != std::string::npos);
  CHECK(view.frame(16)->find(R"("position_m":[500.0,)") != std::string::npos);
  CHECK(view.frame(std::nullopt)->find(R"("position_m":[1000.0,)") != std::string::npos);
  CHECK(view.frame(32) == nullptr);
  CHECK(view.scene(std::nullopt)->find(R"("source":"recording")") != std::string::npos);
}

TEST_CASE("A recording that is none is refused by line, column and value", "[recorded_view]") {
  const tests::TestFolder folder;
  const auto refusal = [&](const std::string& text) {
    const auto file = folder.write("bad.csv", text);
    return refusal_line([&] { static_cast<void>(read_recording(file)); });
  };
  const auto names = [](const std::string& line, const std::string& what) {
    INFO(line);
    return line.find(what) != std::string::npos && line.find('\n') == std::string::npos;
  };
  CHECK(names(refusal("time_s,x_m,y_m\n0,1,2\n"), "bad.csv:1: column z_m: expected once"));
  CHECK(names(refusal(kHead + "0,1,2,nan,0,0,,\n"), "bad.csv:3: column z_m: value 'nan'"));
  CHECK(names(refusal(kHead + "0,1,2,3,0,0,brave,\n"), "column flags: value 'brave'"));
  CHECK(names(refusal(kHead + "0,1,2,3\n"), "value 4 columns: expected 8"));
  CHECK(names(refusal(kHead + "0,1,2,3,0,0,,\n0,1,2,3,0,0,,\n"), "bad.csv:4: column time_s"));
  CHECK(names(refusal("x_m,y_m,z_m,time_s\n0,1,2,5\n7,1,2,4\n"), "time_s: value '4'"));
  CHECK(names(refusal(kHead + "1e300,1,2,3,0,0,,\n"), "value '1e300': expected seconds from 0 to"));
  CHECK(names(refusal(kHead + "-1,1,2,3,0,0,,\n"), "value '-1': expected seconds from 0 to"));
  CHECK(names(refusal(kHead), "expected a row at least"));
  CHECK(names(refusal("\x1f\x8b\x08"), "bad.csv: compressed by gzip: expected text"));
  CHECK(names(refusal_line([&] { RecordedView{folder.path / "none.csv"}; }), "cannot be read"));
  CHECK(names(refusal_line([&] { RecordedView{folder.path}; }), "cannot be read"));
}

}  // namespace
}  // namespace stillgrid::scene_viewer::recorded_view_test
