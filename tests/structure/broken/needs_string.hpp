#pragma once

/// A deliberate fault for the test of the header check: std::string is used, but <string> is not included.
[[nodiscard]] inline std::string greeting() { return "hello"; }
