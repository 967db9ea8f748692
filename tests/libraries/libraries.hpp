#pragma once

// Two shared libraries that each use Tapestry for themselves: one hides its symbols, the other does not.
extern "C" {
/// Records x² on the library's own tape, and calls `meanwhile` in the middle of it.
[[gnu::visibility("default")]] void quadratic_record(double x, void (*meanwhile)());
/// The derivative of the last recording on this thread.
[[gnu::visibility("default")]] double quadratic_slope();
/// How many statements that is.
[[gnu::visibility("default")]] int quadratic_statements();

/// The same for x³.
[[gnu::visibility("default")]] void cubic_record(double x, void (*meanwhile)());
[[gnu::visibility("default")]] double cubic_slope();
[[gnu::visibility("default")]] int cubic_statements();
}
