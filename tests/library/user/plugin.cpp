// A shared object that holds a part of the archive.

#include <smaservo/model/files/wire/wire_file.hpp>
#include <smaservo/observer/measurement.hpp>

extern "C" double plugin_length_m() {
  return smaservo::files::load_wire("smartflex-76um").wire.geometry.length_m;
}
