// Reason for the precompiled headers: a file that takes them, beside paths.cpp, which does not.
