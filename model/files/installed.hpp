#pragma once
// Where the files are that were installed with a program.

#include <filesystem>
#include <string>

namespace smaservo::files {

/// The place of this file or folder of lib/smaservo: in ../lib/smaservo beside the folder of the
/// running program, or, of tests, a folder further up; else, for programs of others, in
/// lib/smaservo of /usr/local or of /usr. Where none of them has it, it is the first.
std::filesystem::path installed(const std::string& name);

}  // namespace smaservo::files
