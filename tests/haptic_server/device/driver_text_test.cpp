#include "haptic_server/device/driver_text.hpp"

#include <catch2/catch.hpp>

namespace stillgrid::device::driver_text_test {
namespace {

TEST_CASE("What is one line of UTF-8 stays as it is", "[driver_text]") {
  for (const std::string text : {"", "phantom 1.0", "M\xC3\xBChle \xE2\x82\xAC \xF0\x9F\x96\x90"})
    CHECK(line_of(text.c_str(), 100) == text);
  CHECK(line_of(nullptr, 100).empty());
}

TEST_CASE("A text is cut at its zero or its size, and never into half a character",
          "[driver_text]") {
  CHECK(line_of("phantom", 4) == "phan");
  CHECK(line_of("ab\0cd", 5) == "ab");
  CHECK(line_of("M\xC3\xBChle", 2) == "M?");
}

TEST_CASE("What no line of UTF-8 may hold is taken out of it", "[driver_text]") {
  CHECK(line_of("a\nb\r\x1B\x7F"
                "c",
                100) == "a b   c");
  CHECK(line_of("\xC0\xAF", 100) == "??");                      // '/', overlong
  CHECK(line_of("\xE0\x80\xAF", 100) == "???");                 // so too
  CHECK(line_of("\xED\xA0\x80", 100) == "???");                 // half a pair of UTF-16
  CHECK(line_of("\xF4\x90\x80\x80\xFF\x80", 100) == "??????");  // beyond the last, and never
  CHECK(line_of("\xC3(", 100) == "?(");
}

}  // namespace
}  // namespace stillgrid::device::driver_text_test
