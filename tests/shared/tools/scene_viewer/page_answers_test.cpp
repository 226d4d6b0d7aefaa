#include "shared/tools/scene_viewer/page_answers.hpp"

#include <catch2/catch.hpp>
#include <fstream>
#include <memory>
#include <random>

#include "tests/test_folder.hpp"

namespace stillgrid::scene_viewer::page_answers_test {
namespace {

/// A view of one frame and one scene, the latter under the empty key.
class SmallView final : public ViewSource {
 public:
  [[nodiscard]] ViewStatus status() const override { return {}; }
  [[nodiscard]] Message scene(std::optional<std::string_view> key) const override {
    return !key || key->empty() || *key == "a b" ? text_ : nullptr;
  }
  [[nodiscard]] Message frame(std::optional<std::uint64_t> number) const override {
    if (number == 2) throw std::runtime_error("damaged");
    return number.value_or(1) == 1 ? text_ : nullptr;
  }
  [[nodiscard]] std::string ticks(std::uint64_t, std::size_t most) const override {
    return std::to_string(most);
  }

 private:
  Message text_ = std::make_shared<const std::string>("text");
};

TEST_CASE("A query's value is decoded once, and a broken code stands", "[page_answers]") {
  CHECK_FALSE(query_value("", "a"));
  CHECK_FALSE(query_value("ab=1&b=2", "a"));
  CHECK(query_value("a", "a") == "");
  CHECK(query_value("b=2&a=1=2&a=3", "a") == "1=2");
  CHECK(query_value("a=%41%2541%", "a") == "A%41%");
  CHECK(query_value("a=%4&b", "a") == "%4");
  CHECK(query_value("a=%zz%+1%-1", "a") == "%zz%+1%-1");
}

TEST_CASE("Only the key opens, and only this machine's name", "[page_answers]") {
  const tests::TestFolder folder;
  std::ofstream(folder.path / "index.html") << "page";
  std::ofstream(folder.path / "secret.txt") << "secret";
  Views views(std::make_unique<SmallView>());
  PageAnswers answers(views, "key", folder.path);
  const auto status = [&](std::string_view target, std::string_view host = "localhost:1",
                          std::string_view method = "GET") {
    const PageAnswer answer = answers.to({.method = method, .target = target, .host = host});
    CHECK(answer.is_to_stranger == (answer.status == 403));
    return answer.status;
  };
  CHECK(status("/key/") == 200);
  CHECK(status("/key/", "127.0.0.1") == 200);
  for (const char* target : {"", "/", "key/", "/key", "/ke/", "/keyy/", "//key/", "/?/key/", "*",
                             "http://localhost/key/"})
    CHECK(status(target) == 403);
  for (const char* host : {"", "localhost.", "evil", "127.0.0.1.evil", "[::1]", "a@localhost"})
    CHECK(status("/key/", host) == 403);
  CHECK(status("/key/", "localhost", "POST") == 405);
  for (const char* target :
       {"/key/index.html", "/key/secret.txt", "/key//", "/key/../key/", "/key/api", "/key/api/",
        "/key/api/frame?number=2", "/key/api/frame?number=3", "/key/api/scene?key=b",
        "/key/api/status?session=other"})
    CHECK(status(target) == 404);
  for (const char* target :
       {"/key/?x", "/key/api/status", "/key/api/frame?number=latest", "/key/api/frame?number=1",
        "/key/api/scene", "/key/api/scene?key=", "/key/api/scene?key=a%20b",
        "/key/api/ticks?most=1&from=0", "/key/api/sessions", "/key/api/status?session="})
    CHECK(status(target) == 200);
  CHECK(*answers.to({"GET", "/key/api/ticks?from=0&most=99999999", "localhost"}).body == "65536");
}

TEST_CASE("The mouse is for the viewer's own page, and for a session that runs", "[page_answers]") {
  Views views(std::make_unique<SmallView>());
  PageAnswers answers(views, "key", "no such folder");
  const std::string body =
      R"({"holder":"a","position_m":[0,0,0],"orientation_xyzw":[0,0,0,1],"buttons":0})";
  const auto status = [&](std::string_view method, std::string_view origin, std::string_view text,
                          std::string_view target = "/key/api/mouse") {
    return answers
        .to({.method = method,
             .target = target,
             .host = "localhost",
             .origin = origin,
             .body = text})
        .status;
  };
  CHECK(status("POST", "", body) == 404);  // what was kept is moved by no mouse
  CHECK(status("POST", "http://127.0.0.1:8642", body) == 404);
  CHECK(status("POST", "", body, "/key/api/mouse?session=other") == 404);
  for (const char* origin : {"null", "http://evil.example", "https://localhost", "localhost"})
    CHECK(status("POST", origin, body) == 403);
  CHECK(status("POST", "", body, "/kez/api/mouse") == 403);
  CHECK(status("POST", "", "{}") == 400);
  CHECK(status("GET", "", "") == 405);
}

TEST_CASE("Whatever is asked, there is an answer", "[page_answers]") {
  Views views(std::make_unique<SmallView>());
  PageAnswers answers(views, "key", "no such folder");
  std::mt19937 random(1);
  for (int i = 0; i < 20'000; ++i) {
    std::string target = "/key/api/frame?number=%31&from=1&most=%";
    for (std::uint32_t spoilt = random() % 8; spoilt > 0; --spoilt)
      target[random() % target.size()] = static_cast<char>(random());
    target.resize(random() % (target.size() + 1));
    const PageAnswer answer = answers.to({"GET", target, "localhost"});
    REQUIRE(answer.body);
    REQUIRE((answer.status == 200 || answer.body->back() == '\n'));
  }
}

}  // namespace
}  // namespace stillgrid::scene_viewer::page_answers_test
