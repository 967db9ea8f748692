#include <tapestry/core/instruction_set.hpp>

#include "../support/catch.hpp"

using namespace tapestry;

TEST_CASE("an instruction set is found by its name", "[core][instruction_set]") {
  const auto best = InstructionSet::avx512;
  CHECK(instruction_set_named("portable", best) == InstructionSet::portable);
  CHECK(instruction_set_named("avx2", best) == InstructionSet::avx2);
  CHECK(instruction_set_named("avx512", best) == InstructionSet::avx512);
  CHECK(instruction_set_named("avx2", InstructionSet::avx2) == InstructionSet::avx2);
  CHECK(instruction_set_named("neon", InstructionSet::neon) == InstructionSet::neon);
}

TEST_CASE("an instruction set that is unknown, or that the processor lacks, is refused",
          "[core][instruction_set]") {
  CHECK_THROWS_AS(instruction_set_named("AVX2", InstructionSet::avx512), DomainError);
  CHECK_THROWS_AS(instruction_set_named("", InstructionSet::avx512), DomainError);
  CHECK_THROWS_WITH(
      instruction_set_named("sse", InstructionSet::avx512),
      "TAPESTRY_INSTRUCTION_SET: found 'sse', expected portable, avx2 or avx512 by this program on this "
      "processor");
  CHECK_THROWS_WITH(instruction_set_named("avx2", InstructionSet::neon),
                    contains("found 'avx2', expected portable or neon by"));
  CHECK_THROWS_WITH(instruction_set_named("avx512", InstructionSet::avx2),
                    contains("found 'avx512', expected portable or avx2 by"));
}
