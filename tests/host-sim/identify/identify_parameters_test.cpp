// What a fit may change about a wire.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>

#include "host-sim/identify/fit/parameters.hpp"
#include "model/files/wire/wire_fields.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::test {
namespace {

constexpr identify::FitVariant variants[] = {
    {},
    {.separate_r2a = true, .separate_r2m = true},
    {.separate_r2a = true, .taper = true, .loop_order = true}};

/// A wire from which a fit of any of these variants may start.
Wire<double> start_of(const identify::FitVariant& variant) {
  Wire<double> wire = files::load_wire("smartflex-76um").wire;
  if (variant.taper) {
    wire.kinetics = identify::ordered_before(wire.kinetics, Memory::return_point);
  }
  return wire;
}

template <class F>
Wire<double> varied(const Wire<double>& from, const identify::FitVariant& variant, F deviation) {
  return identify::vary_wire<double>(from, variant, [&](const identify::FitParameter& parameter) {
    return parameter.value(deviation());
  });
}

TEST(FitParameters, WithoutDeviationTheWireIsWhatItWas) {
  for (const char* name : {"smartflex-76um", "flexinol-lt-0.15mm", "flexinol-ht-0.38mm"}) {
    const Wire<double> from = files::load_wire(name).wire;
    const Wire<double> after = varied(from, {}, [] { return 0.0; });
    ASSERT_EQ(files::written_fields(from), files::written_fields(after));
    for (const files::Field* field : files::written_fields(from)) {
      SCOPED_TRACE(fmt::format("{} {}", name, field->path));
      const std::vector<double> numbers = files::wire_numbers(*field, from);
      const std::vector<double> other = files::wire_numbers(*field, after);
      // Each coefficient is compared by its contribution at 500 MPa.
      double scale = 1;
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        EXPECT_NEAR(scale * numbers[i], scale * other[i],
                    1e-9 * (1e-6 + std::abs(numbers.front())));
        scale *= 500e6;
      }
    }
  }
}

TEST(FitParameters, AWireThatIsOffIsStillOne) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (const identify::FitVariant& variant : variants) {
    for (int i = 0; i < 300; ++i) {
      files::WireDescription description = files::load_wire("smartflex-76um");
      description.wire = varied(start_of(variant), variant, [&] { return 0.6 * normal(random); });
      EXPECT_NO_THROW(files::parse_wire(files::to_toml(description), "varied.toml"))
          << files::to_toml(description);
    }
  }
}

TEST(FitParameters, EachChangesTheWireByItself) {
  const auto text = [&](const Wire<double>& wire) { return files::to_toml({"", wire, {}}); };
  for (const identify::FitVariant& variant : variants) {
    const Wire<double> from = start_of(variant);
    const std::vector<identify::FitParameter> all = identify::fit_parameters(from, variant);
    const std::string unchanged = text(varied(from, variant, [] { return 0.0; }));
    for (std::size_t i = 0; i < all.size(); ++i) {
      std::size_t at = 0;
      EXPECT_NE(text(varied(from, variant, [&] { return at++ == i ? 0.5 : 0.0; })), unchanged)
          << all[i].key;
    }
  }
}

}  // namespace
}  // namespace smaservo::test
