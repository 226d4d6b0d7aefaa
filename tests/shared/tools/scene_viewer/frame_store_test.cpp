#include "shared/tools/scene_viewer/frame_store.hpp"

#include <catch2/catch.hpp>

namespace stillgrid::scene_viewer::frame_store_test {
namespace {

TEST_CASE("Frames are numbered from 1 on and the newest is the last", "[frame_store]") {
  FrameStore store;
  CHECK(store.get(std::nullopt) == nullptr);
  CHECK(store.last() + 1 == store.first());
  store.add("a", 0.0);
  store.add("b", 0.1);
  CHECK(store.first() == 1);
  CHECK(store.last() == 2);
  CHECK(*store.get(1) == "a");
  CHECK(*store.get(std::nullopt) == "b");
  CHECK(store.get(0) == nullptr);
  CHECK(store.get(3) == nullptr);
}

TEST_CASE("Frames of more than a minute ago are let go", "[frame_store]") {
  FrameStore store;
  for (int i = 0; i < 100; ++i) store.add("frame", static_cast<double>(i));
  CHECK(store.last() == 100);
  CHECK(store.first() == 40);
  CHECK(store.get(39) == nullptr);
  CHECK(store.get(40) != nullptr);
}

TEST_CASE("Large frames are held as far as memory goes, one of them always", "[frame_store]") {
  FrameStore store;
  const std::string large(FrameStore::kMaxBytes / 4, 'x');
  for (int i = 0; i < 10; ++i) store.add(large, 0.0);
  CHECK(store.last() - store.first() + 1 == 4);
  store.add(std::string(FrameStore::kMaxBytes + 1, 'y'), 0.0);
  CHECK(store.first() == 11);
  CHECK(store.get(std::nullopt)->front() == 'y');
}

}  // namespace
}  // namespace stillgrid::scene_viewer::frame_store_test
