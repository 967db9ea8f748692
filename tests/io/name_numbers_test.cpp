#include <tapestry/io/detail/name_numbers.hpp>

#include <map>

#include "../support/catch.hpp"

using tapestry::io::NameNumbers;

TEST_CASE("names are numbered as std::map numbers them", "[io][name_numbers]") {
  std::mt19937_64 random(1);
  std::vector<std::string> names;
  std::map<std::string, std::size_t> expected;
  NameNumbers numbers;
  const auto name_of = [&](std::size_t i) -> std::string_view { return names[i]; };
  CHECK(numbers.find("", name_of) == NameNumbers::none);
  for (int i = 0; i < 20000; ++i) {
    std::string name(random() % 20, '\0');  // of two bytes, so that many come again; often beyond two chunks
    for (char& byte : name) byte = static_cast<char>(random() % 2);
    const auto [known, is_new] = expected.try_emplace(name, names.size());
    REQUIRE(numbers.find(name, name_of) == (is_new ? NameNumbers::none : known->second));
    REQUIRE(numbers.add(name, name_of) == known->second);
    if (is_new) names.push_back(name);
  }
  CHECK(numbers.size() == expected.size());
  CHECK(names.size() > 10000);
  for (std::size_t i = 0; i < names.size(); ++i) REQUIRE(numbers.find(names[i], name_of) == i);
}

TEST_CASE("names that differ by zero bytes alone have numbers of their own", "[io][name_numbers]") {
  std::vector<std::string> names;
  NameNumbers numbers;
  for (std::size_t size = 0; size < 40; ++size) {
    CHECK(numbers.add(std::string(size, '\0'), [&](std::size_t i) -> std::string_view { return names[i]; }) ==
          size);
    names.emplace_back(size, '\0');
  }
}

TEST_CASE("a table that was moved from finds nothing", "[io][name_numbers]") {
  NameNumbers numbers;
  const auto name_of = [](std::size_t) { return std::string_view("a"); };
  CHECK(numbers.add("a", name_of) == 0);
  const auto moved = std::move(numbers);
  CHECK(moved.find("a", name_of) == 0);
  CHECK(numbers.find("a", name_of) == NameNumbers::none);
}

TEST_CASE("few names are compared with one that is looked up", "[io][name_numbers]") {
  constexpr std::size_t count = 100000;
  std::vector<std::string> names;
  std::size_t compared = 0;
  const auto name_of = [&](std::size_t i) -> std::string_view {
    ++compared;
    return names[i];
  };
  NameNumbers numbers;
  const std::string stem = GENERATE(std::string(), std::string(7, 'x'), std::string(100, 'x'));
  for (std::size_t i = 0; i < count; ++i) {
    names.push_back(stem + std::to_string(i));
    REQUIRE(numbers.add(names.back(), name_of) == i);
  }
  CHECK(compared < 50);  // two hashes of 32 bits agree for about one pair in 2^32: 1.2 of these pairs
  for (std::size_t i = 0; i < count; ++i) REQUIRE(numbers.find(names[i], name_of) == i);
  CHECK(compared < count + 100);
}
