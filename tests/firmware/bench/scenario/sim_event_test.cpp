#include "firmware/bench/scenario/sim_event.hpp"

#include <gtest/gtest.h>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {
namespace {

/// A board at rest, and what events have made of it at a time.
class Eventful {
 public:
  explicit Eventful(const std::string& events)
      : scenario_(loaded(events)),
        board_(bench::make_plant(scenario_.plant), scenario_.board),
        events_(scenario_.events, scenario_.board.surroundings) {}
  hal::SimBoard& at(double time_s) {
    events_.apply(time_s, board_);
    return board_;
  }
  bool late() const { return events_.late(); }

 private:
  static bench::ClosedLoopScenario loaded(const std::string& events) {
    const TemporaryFolder folder;
    folder.write("d.toml", "wire = 'smartflex-76um'\n");
    return bench::load_closed_loop(
        folder.write("e.toml",
                     "note = 'n'\n[device]\nsettings = 'd.toml'\n[plant]\nfamily = "
                     "'lumped'\n[[command]]\nmode = "
                     "'off'\nfor_s = 9\n" +
                         events));
  }
  bench::ClosedLoopScenario scenario_;
  hal::SimBoard board_;
  bench::SimEvents events_;
};

TEST(SimEvents, ComeAndGo) {
  Eventful e(
      "[[event]]\nat_s = 1\nfor_s = 2\ndraught = 3\nload_MPa = 50\n"
      "[[event]]\nat_s = 2\nfor_s = 2\nload_MPa = -20\nambient_degC = 40\n"
      "[[event]]\nat_s = 5\nwire = 'broken'\n");
  EXPECT_EQ(e.at(0.999).surroundings.draught, 1);
  EXPECT_EQ(e.at(1).surroundings.draught, 3);
  EXPECT_EQ(e.at(1.5).surroundings.added_stress_Pa, 50e6);
  EXPECT_EQ(e.at(2).surroundings.added_stress_Pa, 30e6) << "loads add up";
  EXPECT_EQ(e.at(3).surroundings.added_stress_Pa, -20e6);
  EXPECT_EQ(e.at(3.5).surroundings.draught, 1);
  EXPECT_DOUBLE_EQ(e.at(3.5).surroundings.ambient_K, 313.15);
  EXPECT_DOUBLE_EQ(e.at(4).surroundings.ambient_K, room_K);
  EXPECT_EQ(e.at(4.9).faults().circuit, hal::Circuit::closed);
  EXPECT_EQ(e.at(8).faults().circuit, hal::Circuit::broken) << "for good";
}

TEST(SimEvents, SpoilSensorsAndFlags) {
  Eventful e(
      "[[event]]\nat_s = 1\nfor_s = 1\nsensor = 'load'\nfault = 'offset'\namount = 0.1\n"
      "[[event]]\nat_s = 1.5\nfor_s = 1\nemergency_stop = true\nlate = true\n"
      "lost_frames = 0.5\n");
  const auto load = [&](double time_s) {
    return e.at(time_s).faults().sensors[static_cast<std::size_t>(hal::Reading::load)];
  };
  EXPECT_EQ(load(0).fault, hal::SensorFault::none);
  EXPECT_EQ(load(1.2).fault, hal::SensorFault::offset);
  EXPECT_EQ(load(1.2).amount, 0.1);
  EXPECT_FALSE(e.late());
  EXPECT_TRUE(e.at(1.6).faults().emergency_stop);
  EXPECT_EQ(e.at(1.6).faults().lost_share, 0.5);
  EXPECT_TRUE(e.late());
  EXPECT_EQ(load(2.2).fault, hal::SensorFault::none);
  EXPECT_FALSE(e.at(2.6).faults().emergency_stop);
}

}  // namespace
}  // namespace smaservo::test
