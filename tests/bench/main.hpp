#pragma once

namespace smaservo::benchmarks {

/// What a program of this folder measures; its main() in main.cpp runs it.
void register_benchmarks();

}  // namespace smaservo::benchmarks
