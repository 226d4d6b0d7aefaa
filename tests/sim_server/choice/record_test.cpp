#include "sim_server/choice/record.hpp"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

namespace stillgrid::choice::record_test {
namespace {

std::vector<Record> four() {
  return {{.name = "exact", .work_per_ms = 90.0, .error_share = 0.01},
          {.name = "good", .work_per_ms = 50.0, .error_share = 0.06},
          {.name = "cheap", .work_per_ms = 10.0, .error_share = 0.3},
          {.name = "broken", .work_per_ms = 1.0, .error_share = 0.0, .refusal = "unstable"}};
}

TEST_CASE("The cheapest record that keeps the error is chosen, and others say why not",
          "[record]") {
  std::vector<Record> records = four();
  CHECK(choose_record(records, 0.07) == 1);
  CHECK(records[0].refusal == "costs more");
  CHECK(records[1].refusal.empty());
  CHECK(records[2].refusal == "misses the error");
  CHECK(records[3].refusal == "unstable");
}

TEST_CASE("Among works that are equal within their weights the most exact is chosen", "[record]") {
  std::vector<Record> records = {{.work_per_ms = 109.0, .error_share = 0.01},
                                 {.work_per_ms = 100.0, .error_share = 0.05},
                                 {.work_per_ms = 111.0, .error_share = 0.001},
                                 {.work_per_ms = 100.0, .error_share = 0.002, .bytes = 1.0}};
  CHECK(choose_record(records, 0.07) == 0);
  CHECK(records[1].refusal == "errs more");
  CHECK(records[2].refusal == "costs more");
}

TEST_CASE("Where none keeps the error the most accurate is chosen", "[record]") {
  std::vector<Record> records = four();
  CHECK(choose_record(records, 0.001) == 0);
  CHECK(records[1].refusal == "misses the error");
}

TEST_CASE("Where no error is known the first is chosen", "[record]") {
  std::vector<Record> records = {{.name = "a", .work_per_ms = 9.0},
                                 {.name = "b", .work_per_ms = 2.0}};
  CHECK(choose_record(records, 0.07) == 0);
  CHECK(records[1].refusal == "its error is unknown");
}

TEST_CASE("Of records of one work the smallest is chosen; where all are broken one is",
          "[record]") {
  std::vector<Record> records = {{.work_per_ms = 1.0, .error_share = 0.01, .bytes = 9.0},
                                 {.work_per_ms = 1.0, .error_share = 0.05, .bytes = 3.0}};
  CHECK(choose_record(records, 0.07) == 1);
  for (Record& record : records) record.refusal = "unstable";
  CHECK(choose_record(records, 0.07) == 1);
  CHECK(records[1].refusal.empty());
}

TEST_CASE("A record is one line of JSON, an unknown error null", "[record]") {
  CHECK(
      json_line({.name = "a \"b\"", .work_per_ms = 1.5}) ==
      R"({"name":"a \"b\"","work_per_ms":1.5,)"
      R"("error_share":null,"truth_error_share":0.0,"latency_share":0.0,"spheres":0,"refusal":""})");
}

TEST_CASE("A table marks the chosen record with a star", "[record]") {
  std::vector<Record> records = four();
  (void)choose_record(records, 0.07);
  const std::string table = table_of(records, 1000.0);
  CHECK(table.find("* good") != std::string::npos);
  CHECK(table.find("  exact") != std::string::npos);
  CHECK(table.find("unstable") != std::string::npos);
}

}  // namespace
}  // namespace stillgrid::choice::record_test
