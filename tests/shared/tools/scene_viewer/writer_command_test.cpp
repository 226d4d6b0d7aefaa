#include "shared/tools/scene_viewer/writer_command.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

namespace stillgrid::scene_viewer::writer_command_test {
namespace {

TEST_CASE("A shell takes a line as the words that it was made of", "[writer_command]") {
  CHECK(shell_line({"sim_server", "--scene", "a/b-1.toml"}) == "sim_server --scene a/b-1.toml");
  CHECK(shell_line({"a b", "", "$(rm)", "it's", "\xc3\xa4"}) ==
        "'a b' '' '$(rm)' 'it'\\''s' '\xc3\xa4'");
  CHECK(shell_line({"a", "b\x1b[2J"}).empty());
  CHECK(shell_line({"a\nb"}).empty());
  CHECK(shell_line({}).empty());
}

TEST_CASE("The command of a process is known where it names the session, and kept after its end",
          "[writer_command]") {
  const auto own = static_cast<std::uint32_t>(::getpid());
  std::ifstream in("/proc/self/cmdline");
  std::vector<std::string> words;
  for (std::string word; std::getline(in, word, '\0');) words.push_back(word);
  REQUIRE_FALSE(words.empty());

  WriterCommand command(words.front() + "+left");  // this test's program, as if it were a session
  CHECK(command.line().empty());
  command.look(1, own);
  CHECK(command.line() == shell_line(words));
  command.look(1, 0);  // the same writer, whose process is gone
  CHECK(command.line() == shell_line(words));
  command.look(2, 0);
  CHECK(command.line().empty());

  WriterCommand other("another-session");
  other.look(1, own);
  CHECK(other.line().empty());
}

}  // namespace
}  // namespace stillgrid::scene_viewer::writer_command_test
