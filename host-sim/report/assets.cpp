#include "host-sim/report/assets.hpp"

namespace smaservo::report {

std::string_view page_html() {
  return {};
}

}  // namespace smaservo::report
