// A wire by its header is the wire of the file, each number to the bit.

#include <cstdio>
#include <smaservo/model/files/wire/wire_file.hpp>
#include <smaservo/model/wire/wire_parameters.hpp>

#include "wire.hpp"

int main() {
  using namespace smaservo;
  const Wire<double> file = files::load_wire(WIRE).wire;
  const Wire<double> header = wire_every_number_of_its_own<double>();
  int differ = 0;
  for (const WireParameter<double>& row : wire_parameters<double>) {
    if (row.get(file) != row.get(header)) {
      const std::string path{row.path.text()};
      std::printf("%s: %.17g in the file, %.17g in the header\n", path.c_str(), row.get(file),
                  row.get(header));
      ++differ;
    }
  }
  return differ == 0 ? 0 : 1;
}
