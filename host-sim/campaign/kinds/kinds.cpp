#include "host-sim/campaign/kinds/kinds.hpp"

#include <array>

namespace smaservo::campaign {

std::span<const Kind> all_kinds() {
  static constexpr std::array kinds{Kind{"scenarios", read_scenarios}, Kind{"gains", read_gains},
                                    Kind{"evaluate", read_evaluate}, Kind{"lot", read_lot}};
  return kinds;
}

}  // namespace smaservo::campaign
