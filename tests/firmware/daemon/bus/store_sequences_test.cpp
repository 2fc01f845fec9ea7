// Random sequences of what can meet while something is being stored: SDO, NMT, LSS, files that are
// read anew, a loop that takes or refuses settings, a disk that ends when it likes. Beside them
// runs a small model of what was promised to whom.

#include <gtest/gtest.h>
#include <map>
#include <random>

#include "firmware/daemon/bus/request_desk.hpp"
#include "firmware/daemon/bus/settings_link.hpp"
#include "firmware/daemon/loop/prepared_device.hpp"
#include "tests/firmware/canopen/servo/servo_rig.hpp"

namespace smaservo::test::store_sequences_test {
namespace {

using canopen::Bytes;
using canopen::Nmt;
using canopen::Request;

#ifdef SMASERVO_SANITIZED
constexpr int sequences = 10;
#else
constexpr int sequences = 60;
#endif
constexpr int steps = 400;

constexpr Key limit_key{0x2020, 2}, trip_key{0x2021, 2}, inhibit_key{0x1015, 0};

/// What is durable.
struct Disk {
  std::optional<Settings<double>> settings;
  daemon::Image image;
};

/// Stores when the test says so.
class SlowStore {
 public:
  explicit SlowStore(Disk& disk) : disk_(disk) {}
  void start(daemon::StoreJob job) {
    ASSERT_FALSE(busy_) << "one at a time";
    job_ = std::move(job);
    busy_ = true;
  }
  bool take(daemon::StoreResult& result) {
    if (!ended_) {
      return false;
    }
    result = {job_.request, job_.number, works_ ? "" : "the disk fails"};
    busy_ = ended_ = false;
    return true;
  }
  void end(bool works) {
    if (!busy_ || ended_) {
      return;
    }
    ended_ = true;
    works_ = works;
    if (works) {
      write();
    }
  }

 private:
  void write() {
    using enum Request;
    const Request r = job_.request;
    if (r == store_all || r == store_application) {
      disk_.settings = stored_settings<double>(job_.settings);
    }
    if (r == store_all || r == store_communication || r == store_lss) {
      disk_.image = job_.image;
    }
    if (r == restore_all || r == restore_application) {
      disk_.settings.reset();
    }
    if (r == restore_all || r == restore_communication) {
      disk_.image.clear();
    }
  }

  Disk& disk_;
  daemon::StoreJob job_;
  bool busy_ = false, ended_ = false, works_ = true;
};

/// 1015h by default, in 100 us.
constexpr std::uint64_t usual_inhibit = 100;

/// Value of 1015h in an image; its default, if it has none.
std::uint64_t inhibit_in(const daemon::Image& image) {
  for (std::size_t at = 6; at + 9 <= image.size(); at += 7) {
    if (canopen::take_number(std::span(image).subspan(at, 2)) == inhibit_key.index) {
      return canopen::take_number(std::span(image).subspan(at + 3, 4));
    }
  }
  return usual_inhibit;
}
std::uint8_t node_id_in(const daemon::Image& image) {
  return image.size() < 4 ? std::uint8_t{0} : image[3];
}

/// From one start of the node to the next: what a daemon makes anew.
struct Run {
  explicit Run(const Settings<double>& from)
      : desk(from, links), device(desk.first()), given{{0, from}} {
    desk.reloads().set_bus(true);
  }
  void connect(canopen::ServoRig& rig) { settings.emplace(rig.servo, rig.staging, desk, links); }
  daemon::LoopLinks links;
  daemon::ParameterDesk desk;
  daemon::PreparedDevice device;
  std::optional<daemon::SettingsLink> settings;
  std::map<std::uint32_t, Settings<double>> given;  ///< to the loop, by number
  std::uint32_t adopted = 0;                        ///< number of those that the loop has
};

/// The desk of the present run, for the node, which outlives the runs of this test.
struct DeskOfTheRun final : SettingsOwner<double> {
  const Settings<double>& settings() const override { return run->desk.settings(); }
  bool has_room() const override { return run->desk.has_room(); }
  void put(const Settings<double>& settings) override { run->desk.put(settings); }
  std::unique_ptr<Run> run = std::make_unique<Run>(reference_settings());
};

class World {
 public:
  /// With refusals the loop is heated now and then, and takes back what needs a wire without
  /// current. With that goes what was promised beside it: then the log has to say so.
  World(unsigned seed, bool refusals) : random_(seed), refusals_(refusals) {
    run_->connect(rig_);
    rig_.answers = false;
    rig_.steps_device = false;
    model_.limit_A = logged_A_ = default_A_ = limit_in(rig_.staging.active());
  }

  void act() {
    switch (random_() % 16) {
      case 0:
      case 1:
        write_limit();
        break;
      case 2:
        write_inhibit();
        break;
      case 3:
      case 4:
        ask(0x1010, canopen::store_signature);
        break;
      case 5:
        ask(0x1011, canopen::restore_signature);
        break;
      case 6:
        nmt();
        break;
      case 7:
      case 8:
        lss();
        break;
      case 9:
      case 15:
        store_.end(random_() % 4 != 0);
        break;
      case 10:
        abort_transfer();
        break;
      case 11:
        reload();
        break;
      case 12:
      case 13:
        take_set();
        break;
      case 14:
        write_trip();
        break;
      default:
        break;
    }
    hear();
    step();
  }

  /// The disk ends what it does, the loop takes everything: nothing may be open any more.
  void settle() {
    for (int i = 0; i < 40; ++i) {
      store_.end(true);
      take_set(false);
      run_->desk.tidy();
      step();
    }
    EXPECT_FALSE(awaits_) << "a request without an answer";
    EXPECT_FALSE(lss_awaits_) << "an LSS store without an answer";
    EXPECT_TRUE(same_settings(rig_.staging.active(), run_->given.at(run_->adopted)))
        << "node and loop";
    EXPECT_EQ(limit_in(rig_.staging.configured()), limit_in(rig_.staging.active()));
    EXPECT_EQ(limit_in(rig_.staging.active()), logged_A_) << "as the log says";
    if (!refusals_) {
      EXPECT_EQ(limit_in(rig_.staging.active()), model_.limit_A);
      EXPECT_EQ(refused_, 0);
    }
    refused_ += static_cast<int>(run_->desk.take_refused().size());
    EXPECT_EQ(rig_.servo.node().objects().emergency_inhibit_100us, model_.inhibit);
  }
  int promised() const { return promised_; }
  int refused() const { return refused_; }

 private:
  struct Awaited {
    Request request;
    /// All that have been in force since it was asked for: any of them may be stored.
    std::vector<float> limits_A;
    std::vector<std::uint64_t> inhibits;
  };
  struct Model {
    float limit_A = 0;
    std::uint64_t inhibit = usual_inhibit;
  };

  static float limit_in(const Settings<double>& settings) {
    return static_cast<float>(settings.limits.current_A);
  }
  bool talks() const {
    const Nmt state = rig_.servo.node().state();
    return state == Nmt::operational || state == Nmt::pre_operational;
  }
  std::uint32_t answer_id() const { return 0x580U + rig_.node_id(); }

  void set_limit(float limit_A) {
    model_.limit_A = limit_A;
    if (awaits_) {
      awaits_->limits_A.push_back(limit_A);
    }
  }
  void write_limit() {
    const float limit_A = default_A_ * (0.5F + 0.001F * static_cast<float>(random_() % 500));
    if (talks() && !awaits_ && sets(limit_key, canopen::as_bits(limit_A), 4)) {
      set_limit(limit_A);
    }
  }
  void write_trip() {
    const auto trip_K = static_cast<float>(420 + random_() % 20);
    if (refusals_ && talks() && !awaits_) {
      sets(trip_key, canopen::as_bits(trip_K), 4);
    }
  }
  void write_inhibit() {
    const std::uint64_t inhibit = random_() % 100;
    if (talks() && !awaits_ && sets(inhibit_key, inhibit, 2)) {
      model_.inhibit = inhibit;
    }
  }
  /// A write that is answered at once; it may be refused while the loop has no room.
  bool sets(Key key, std::uint64_t value, std::size_t size) {
    Bytes request =
        canopen::ServoRig::named(static_cast<std::uint8_t>(0x23U | (4U - size) << 2U), key);
    const Bytes data = canopen::little(value, 4);
    request.insert(request.end(), data.begin(), data.end());
    rig_.send(0x600U + rig_.node_id(), request);
    const auto answers = rig_.take(answer_id());
    EXPECT_EQ(answers.size(), 1U);
    return answers.size() == 1 && answers[0].data[0] == 0x60;
  }

  void ask(std::uint16_t index, std::uint32_t signature) {
    if (!talks() || awaits_) {
      return;
    }
    using enum Request;
    constexpr Request stores[] = {store_all, store_communication, store_application};
    constexpr Request restores[] = {restore_all, restore_communication, restore_application};
    const auto sub = static_cast<std::uint8_t>(1 + random_() % 3);
    awaits_ = {(index == 0x1010 ? stores : restores)[sub - 1U], {logged_A_}, {model_.inhibit}};
    Bytes request = canopen::ServoRig::named(0x23, {index, sub});
    const Bytes data = canopen::little(signature, 4);
    request.insert(request.end(), data.begin(), data.end());
    rig_.send(0x600U + rig_.node_id(), request);
  }
  void abort_transfer() {
    if (talks() && awaits_) {
      rig_.send(0x600U + rig_.node_id(), {0x80, 0, 0, 0, 0, 0, 0, 0});
      awaits_.reset();
    }
  }

  void nmt() {
    constexpr std::uint8_t commands[] = {1, 2, 128, 129, 130};
    const std::uint8_t command = commands[random_() % 5];
    hear();
    rig_.send(0, {command, 0});
    if (!talks()) {
      awaits_.reset();
    }
    if (command >= 129) {
      lss_awaits_.reset();
    }
  }

  void lss() {
    const auto say = [&](Bytes request) {
      request.resize(8);
      rig_.send(canopen::lss_request_id, request);
    };
    const auto id = static_cast<std::uint8_t>(1 + random_() % 3);
    const bool silent = rig_.servo.node().state() == Nmt::initialising;
    hear();
    say({4, 1});
    say({0x11, id});
    rig_.take(canopen::lss_answer_id);
    lss_awaits_ = silent ? std::nullopt : std::optional(id);
    say({0x17});
  }

  /// Whoever reads a file looks first whether something is stored.
  void reload() {
    if (disk_.settings) {
      return;
    }
    Settings<double> settings = reference_settings();
    const float limit_A = default_A_ * (0.5F + 0.001F * static_cast<float>(random_() % 500));
    settings.limits.current_A = static_cast<double>(limit_A);
    run_->desk.reloads().put({"file", settings, nullptr});
    file_A_ = limit_A;
  }
  void take_set(bool may_be_heated = true) {
    daemon::ParameterSet* set = nullptr;
    if (run_->links.new_sets.pop(set)) {
      // What may change at any time is never refused.
      const daemon::ParameterSet* const asked = set;
      set = run_->device.adopt(set, may_be_heated && random_() % 2 == 0);
      run_->adopted = set == asked ? run_->adopted : daemon::number_of(*asked);
      run_->links.old_sets.push(set);
    }
  }
  /// What the log says of the limit.
  void read_log() {
    canopen::LoggedChange change{};
    while (rig_.servo.take_change(change)) {
      if (change.key == limit_key && change.result == canopen::Abort::none) {
        EXPECT_EQ(canopen::as_real(change.before), logged_A_) << "nothing is left out";
        logged_A_ = canopen::as_real(change.value);
        if (awaits_) {
          awaits_->limits_A.push_back(logged_A_);
        }
      }
    }
  }

  void hear() {
    for (const hal::CanFrame& f : rig_.take(answer_id())) {
      ASSERT_TRUE(awaits_) << "an answer that nobody waits for";
      const bool done = f.data[0] == 0x60;
      const Awaited awaited = *std::exchange(awaits_, std::nullopt);
      if (done) {
        ++promised_;
        holds(awaited);
      }
    }
    for (const hal::CanFrame& f : rig_.take(canopen::lss_answer_id)) {
      ASSERT_TRUE(lss_awaits_) << "an LSS answer that nobody waits for";
      ASSERT_EQ(f.data[0], 0x17);
      const std::uint8_t id = *std::exchange(lss_awaits_, std::nullopt);
      if (f.data[1] == 0) {
        ++promised_;
        EXPECT_EQ(node_id_in(disk_.image), id);
      }
    }
  }
  /// What was promised is on the disk.
  void holds(const Awaited& awaited) const {
    using enum Request;
    const Request r = awaited.request;
    const auto has = [](const auto& all, auto value) {
      return std::ranges::find(all, value) != all.end();
    };
    if (r == store_all || r == store_application) {
      ASSERT_TRUE(disk_.settings);
      EXPECT_TRUE(has(awaited.limits_A, limit_in(*disk_.settings)))
          << limit_in(*disk_.settings) << " is stored, " << awaited.limits_A.back()
          << " was promised";
    }
    if (r == store_all || r == store_communication) {
      EXPECT_TRUE(has(awaited.inhibits, inhibit_in(disk_.image)));
    }
    if (r == restore_all || r == restore_application) {
      EXPECT_FALSE(disk_.settings);
    }
    if (r == restore_all || r == restore_communication) {
      EXPECT_TRUE(disk_.image.empty());
    }
  }

  void note(const daemon::StoreResult& result) {
    using enum Request;
    const Request r = result.request;
    const bool stores = r == store_all || r == store_application;
    if (result.problem.empty() && (stores || r == restore_all || r == restore_application)) {
      run_->settings->note_stored(stores);
    }
  }

  /// A round of the bus's thread.
  void step() {
    run_->settings->before_round(requests_.is_busy());
    for (const std::string& said : run_->desk.reloads().take_said()) {
      if (said.find("were stored meanwhile") != std::string::npos) {
        EXPECT_TRUE(disk_.settings);
      } else if (said.find("read once more") == std::string::npos) {
        EXPECT_FALSE(disk_.settings) << "the store goes first";
        EXPECT_EQ(said.find("nothing is changed"), std::string::npos) << said;
        set_limit(file_A_);
      }
    }
    rig_.step();
    run_->settings->give();
    run_->given.emplace(run_->desk.changes(), run_->desk.settings());
    read_log();
    refused_ += static_cast<int>(run_->desk.take_refused().size());
    const Request reset = requests_.round([&] { return rig_.staging.configured(); },
                                          [&](const daemon::StoreResult& result) { note(result); });
    rig_.send(0x7FF, {});  // nobody's: what is to be sent is collected
    hear();
    if (reset == Request::reset_node) {
      const Settings<double> settings = disk_.settings.value_or(reference_settings());
      run_ = std::make_unique<Run>(settings);
      rig_.staging.restart(settings);
      run_->connect(rig_);
      model_.limit_A = logged_A_ = limit_in(settings);
    }
    if (reset != Request::none) {
      rig_.servo.start(disk_.image, rig_.now_us);
      rig_.step();
      model_.inhibit = inhibit_in(disk_.image);
      EXPECT_EQ(rig_.servo.node().objects().emergency_inhibit_100us, model_.inhibit);
      rig_.sent.clear();
    }
  }

  std::mt19937 random_;
  bool refusals_;
  DeskOfTheRun owner_;
  std::unique_ptr<Run>& run_ = owner_.run;
  canopen::ServoRig rig_{{}, reference_settings(), &owner_};
  Disk disk_;
  SlowStore store_{disk_};
  daemon::RequestDesk<canopen::Servo<double>, SlowStore> requests_{rig_.servo, store_};
  Model model_;
  float default_A_ = 0, file_A_ = 0;
  float logged_A_ = 0;
  int refused_ = 0;
  std::optional<Awaited> awaits_;
  std::optional<std::uint8_t> lss_awaits_;  ///< node-id that is to be stored
  int promised_ = 0;
};

class StoreSequences : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Loop, StoreSequences, ::testing::Bool(),
                         [](const auto& with) { return with.param ? "Refuses" : "TakesAll"; });

TEST_P(StoreSequences, WhatIsPromisedHolds) {
  int promised = 0;
  int refused = 0;
  for (unsigned seed = 1; seed <= sequences; ++seed) {
    World world(seed, GetParam());
    for (int i = 0; i < steps && !::testing::Test::HasFailure(); ++i) {
      world.act();
    }
    world.settle();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "seed " << seed;
    promised += world.promised();
    refused += world.refused();
  }
  EXPECT_EQ(0 < refused, GetParam());
  EXPECT_LT(5 * sequences, promised) << "or little was tried";
}

}  // namespace
}  // namespace smaservo::test::store_sequences_test
