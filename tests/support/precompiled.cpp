// What the precompiled headers are made for: a file that takes them, beside paths.cpp, which does not.
