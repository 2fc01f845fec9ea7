// What a client without the key of set-up can do to a wire: random writes of every object, against
// the physical wire. Labels prove nothing here; the wire's own current, power and temperature do.

#include <gtest/gtest.h>
#include <random>

#include "firmware/canopen/node/communication.hpp"
#include "tests/can/simulated_servo.hpp"

namespace smaservo::canopen::access_test {
namespace {

constexpr std::uint32_t tune_key = 1111, set_up_key = 2222;

struct Target {
  Key key;
  Type type;
  std::uint32_t min, max, standard;
};

/// Every object that can be written with one expedited request.
std::vector<Target> targets() {
  std::vector<Target> all;
  const auto add = [&](const Object& o) {
    const bool fits = size_of(o.type) != 0 && size_of(o.type) <= 4;
    if ((o.access & writable) != 0 && fits) {
      all.push_back({o.key, o.type, o.min, o.max, o.standard});
    }
  };
  for (const DescribedObject& row : communication_rows) {
    add(row.object);
  }
  for (const DescribedObject& row : drive_object_rows) {
    add(row.object);
  }
  for (const ParameterRow<double>& row : parameter_rows<double>) {
    const bool real = row.type == ValueType::real;
    const bool whole = row.type == ValueType::number;
    all.push_back({row.key,
                   real    ? Type::real
                   : whole ? Type::u32
                           : Type::u8,
                   row.min.bits, row.max.bits, row.standard.bits});
  }
  return all;
}

/// Limits of what the wire itself has seen.
struct Seen {
  double current_A = 0, power_W = 0, hottest_K = 0;
  int heated = 0;  ///< steps with current
};

class Client {
 public:
  Client(std::uint64_t seed, std::uint32_t key)
      : random_(seed),
        settings_(limited()),
        servo_(settings_, with_keys()),
        all_(targets()),
        key_(key) {}

  static Settings<double> limited() {
    Settings<double> s = test::SimulatedServo::usual_settings(1);
    s.limits.power_W = 1.5;
    return s;
  }

  /// Enables now and then, and otherwise writes anything anywhere.
  Seen run(int writes) {
    for (int i = 0; i < writes; ++i) {
      if (i % 60 == 0) {
        enable();
      }
      write_any();
      step(static_cast<int>(random_() % 40));
    }
    return seen_;
  }

 private:
  static ServoConfig with_keys() {
    ServoConfig config;
    config.keys = {.tune = tune_key, .set_up = set_up_key};
    return config;
  }
  void step(int ms) {
    for (int i = 0; i < ms; ++i) {
      servo_.step();
      hal::CanFrame f;
      while (servo_.take(f)) {
      }
      const Rig& rig = servo_.rig();
      const double A = rig.out.drive_current_A;
      seen_.current_A = std::max(seen_.current_A, A);
      seen_.power_W = std::max(seen_.power_W, A * A * rig.wire->resistance_ohm());
      seen_.hottest_K = std::max(seen_.hottest_K, rig.wire->hottest_K());
      seen_.heated += A > 0 ? 1 : 0;
    }
  }
  void write(Key key, std::uint32_t value, std::size_t size) {
    hal::CanFrame f;
    f.id = 0x601;
    f.length = 8;
    f.data[0] = static_cast<std::uint8_t>(0x23U | (4U - size) << 2U);
    put_number(std::span(f.data).subspan(1, 2), key.index);
    f.data[3] = key.sub;
    put_number(std::span(f.data).subspan(4, 4), value);
    servo_.receive(f);
    step(2);
  }
  void enable() {
    hal::CanFrame start;
    start.length = 2;
    start.data = {1, 1};
    servo_.receive(start);
    write({0x2003, 2}, key_, 4);
    const std::int8_t modes[] = {1, 8, 10, -1, -2, -3, -4};
    write({0x6060, 0}, static_cast<std::uint8_t>(modes[random_() % 7]), 1);
    for (const std::uint32_t word : {0x80U, 6U, 7U, 15U}) {
      write({0x6040, 0}, word, 2);
      step(60);
    }
    write({0x607A, 0}, 1'000'000, 4);
    write({0x6071, 0}, 3000, 2);
    for (std::uint8_t i = 1; i <= 3; ++i) {
      write({0x2201, i}, as_bits(i == 3 ? 600.F : 20.F), 4);
    }
    write({0x6040, 0}, 0x3F, 2);
  }
  void write_any() {
    const Target& t = all_[random_() % all_.size()];
    if (t.key == Key{0x2003, 2}) {
      return;
    }
    // Resets forget the key; what ends the heat is written rarely, or nothing would be heated.
    const bool ends = t.key.index == 0x6040 || t.key.index == 0x6060;
    if (ends && random_() % 8 != 0) {
      return;
    }
    write(t.key, value_for(t), size_of(t.type));
  }
  std::uint32_t value_for(const Target& t) {
    switch (random_() % 6) {
      case 0:
        return t.min;
      case 1:
        return t.max;
      case 2:
        return t.standard;
      case 3:
        return t.key.index == 0x1010 ? store_signature : restore_signature;
      case 4:
        return static_cast<std::uint32_t>(random_());
      default:
        break;
    }
    if (t.type != Type::real) {
      return static_cast<std::uint32_t>(random_() % 256);
    }
    // Many limits are found near their present values only.
    const double share = std::uniform_real_distribution<>(0, 1)(random_);
    const auto low = static_cast<double>(as_real(t.min)),
               high = static_cast<double>(as_real(t.max));
    return as_bits(static_cast<float>(low + share * share * share * (high - low)));
  }

  std::mt19937_64 random_;
  Settings<double> settings_;
  test::SimulatedServo servo_;
  std::vector<Target> all_;
  std::uint32_t key_;
  Seen seen_;
};

Seen worst(std::uint32_t key) {
  Seen all;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Seen seen = Client(seed, key).run(1500);
    all.current_A = std::max(all.current_A, seen.current_A);
    all.power_W = std::max(all.power_W, seen.power_W);
    all.hottest_K = std::max(all.hottest_K, seen.hottest_K);
    all.heated += seen.heated;
  }
  return all;
}

TEST(Access, NoWritesBelowSetUpRaiseWhatTheWireGets) {
  const SoftLimits<double> q = Client::limited().limits;
  for (const std::uint32_t key : {tune_key, 0U}) {
    const Seen seen = worst(key);
    EXPECT_LE(seen.current_A, 1.001 * q.current_A) << key;
    EXPECT_LE(seen.power_W, 1.05 * q.power_W) << key;
    EXPECT_LE(seen.hottest_K, q.temperature_K + 3) << key;
    EXPECT_LT(10'000, seen.heated) << "or nothing was tried";
  }
  const Seen free = worst(set_up_key);
  EXPECT_TRUE(free.current_A > 1.001 * q.current_A || free.power_W > 1.05 * q.power_W ||
              free.hottest_K > q.temperature_K + 3)
      << "with the key the same writes do raise something, or this test sees nothing";
}

}  // namespace
}  // namespace smaservo::canopen::access_test
