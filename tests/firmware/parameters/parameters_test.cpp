#include "firmware/parameters/parameters.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <set>

#include "firmware/parameters/schemas.hpp"
#include "tests/firmware/device/test_device.hpp"
#include "tests/firmware/parameters/random_settings.hpp"

namespace smaservo::parameters_test {
namespace {

/// Another value of the row's range.
template <class S>
Value other_value(const Parameter<S>& row, Value value) {
  if (row.type != ValueType::real) {
    return Value::number(value.number() == row.min.number() ? row.max.number() : row.min.number());
  }
  const float middle = 0.5F * (row.min.real() + row.max.real());
  return Value::real(value.real() == middle ? row.min.real() : middle);
}

TEST(Parameters, EachIsAMemberOfItsOwn) {
  Settings<double> settings = reference_settings();
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const Settings<double> before = settings;
    const Value value = other_value(parameters<double>[i], parameters<double>[i].get(settings));
    parameters<double>[i].set(settings, value);
    EXPECT_EQ(parameters<double>[i].get(settings), value);
    for (std::size_t j = 0; j < parameter_count; ++j) {
      if (j != i) {
        EXPECT_EQ(parameters<double>[j].get(settings), parameters<double>[j].get(before))
            << parameters<double>[i].path.text() << " changes "
            << parameters<double>[j].path.text();
      }
    }
  }
}

// clang++ 19 does not have it.
#if __has_builtin(__builtin_clear_padding)
/// A member without a row keeps the bytes that it was filled with.
TEST(Parameters, NoMemberIsLeftOut) {
  using Bytes = std::array<unsigned char, sizeof(Settings<float>)>;
  const auto filled = [](unsigned char byte) {
    Settings<float> settings;
    std::memset(static_cast<void*>(&settings), byte, sizeof settings);
    for (const Parameter<float>& row : parameters<float>) {
      row.set(settings, row.min);
    }
    __builtin_clear_padding(&settings);
    return std::bit_cast<Bytes>(settings);
  };
  EXPECT_EQ(filled(0x55), filled(0xAA));
}
#endif

TEST(Parameters, KeysAndPathsAreFound) {
  std::set<std::string_view> groups;
  for (std::size_t i = 0; i < parameter_count; ++i) {
    EXPECT_EQ(find_parameter(parameters<float>[i].key), i);
    EXPECT_EQ(find_parameter(parameters<float>[i].path.text()), i);
    EXPECT_EQ(parameters<double>[i].key, parameters<float>[i].key);
    EXPECT_FALSE(parameters<float>[i].meaning.empty());
    const std::string_view path = parameters<float>[i].path.text();
    groups.insert(path.substr(0, path.find('.')));
  }
  EXPECT_EQ(groups.size(), 16U);
  EXPECT_EQ(find_parameter(Key{0x2000, 0}), no_parameter);
  EXPECT_EQ(find_parameter(Key{0x5FFF, 255}), no_parameter);
  EXPECT_EQ(find_parameter("limits.current"), no_parameter);
}

/// What a file may say of a table is one table: rows of one are neighbours.
TEST(Parameters, RowsOfOneTableStandTogether) {
  std::set<std::string_view> closed;
  std::string_view open;
  for (const Parameter<float>& row : parameters<float>) {
    const std::string_view path = row.path.text();
    const std::string_view table = path.substr(0, path.rfind('.'));
    if (table != open) {
      EXPECT_TRUE(closed.insert(table).second) << table;
      open = table;
    }
  }
}

TEST(Parameters, TheWireHasNoDefaultAndAllElseHasOne) {
  const Settings<float> settings = default_settings<float>();
  for (const Parameter<float>& row : parameters<float>) {
    const std::string_view path = row.path.text();
    const bool as_paper_000 = path.ends_with(".taper") || path == "wire.loops.odds";
    const bool of_wire = path.starts_with("wire.") && row.type == ValueType::real && !as_paper_000;
    EXPECT_EQ(row.has_default(), !of_wire) << path;
  }
  EXPECT_TRUE(std::isnan(settings.wire.geometry.length_m));
  EXPECT_TRUE(std::isnan(settings.wire.kinetics.a2m_a2r.finish_K[1].second()));
  EXPECT_EQ(settings.limits.current_A, 0.1F);
  EXPECT_EQ(settings.wire.kinetics.loop_odds, 1);
  EXPECT_EQ(settings.wire.kinetics.a2m_a2r.taper.second(), 0);
}

TEST(Parameters, AreTheSameInFloatAndDouble) {
  const Settings<double> settings = reference_settings();
  const Settings<float> small = stored_settings<float>(settings);
  for (std::size_t i = 0; i < parameter_count; ++i) {
    if (parameters<double>[i].is_used(settings)) {
      EXPECT_EQ(parameters<double>[i].get(settings), parameters<float>[i].get(small));
    }
  }
  EXPECT_TRUE(same_settings(stored_settings<double>(small), settings));
  EXPECT_EQ(settings.trips.temperature_K, static_cast<double>(403.15F));
}

TEST(Parameters, ValuesOutsideOfTheRangeAreTold) {
  const Parameter<float>& row = parameters<float>[find_parameter("limits.current_A")];
  EXPECT_EQ(fit(row, row.min), Fit::inside);
  EXPECT_EQ(fit(row, row.max), Fit::inside);
  EXPECT_EQ(fit(row, Value::real(std::nextafter(row.min.real(), -1.F))), Fit::below);
  EXPECT_EQ(fit(row, Value::real(std::nextafter(row.max.real(), 1e9F))), Fit::above);
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(fit(row, Value::real(bad)), Fit::not_finite);
  }
  const Parameter<float>& choice = parameters<float>[find_parameter("safe.state")];
  EXPECT_EQ(fit(choice, Value::number(2)), Fit::inside);
  EXPECT_EQ(fit(choice, Value::number(3)), Fit::above);
}

std::string objects_of(std::span<const Parameter<float>> rows) {
  std::string text;
  std::uint16_t index = 0;
  unsigned sub = 0;
  for (const Parameter<float>& row : rows) {
    if (row.key.index != index) {
      text += text.empty() ? "" : "\"},\n";
      constexpr std::string_view digits = "0123456789ABCDEF";
      text += "{0x";
      for (const int shift : {12, 8, 4, 0}) {
        text += digits[(static_cast<unsigned>(row.key.index) >> shift) & 15U];
      }
      text += ", \"";
      index = row.key.index;
      sub = 0;
    }
    for (++sub; sub < row.key.sub; ++sub) {
      text += '-';
    }
    text += letter(row.type);
  }
  return text + "\"},\n";
}

TEST(Schemas, LastOneIsTheTable) {
  EXPECT_EQ(schema_hash<float>(parameter_rows<float>), schema_hash(released_schemas.back().objects))
      << "The parameter table has changed. If release " << released_schemas.back().version
      << " is out, add a schema with the next version to firmware/parameters/schemas.hpp; its "
         "objects are\n"
      << objects_of(parameters<float>);
  EXPECT_EQ(schema_version(schema_hash<float>(parameter_rows<float>)),
            released_schemas.back().version);
  EXPECT_EQ(schema_version(1), "");
}

TEST(Schemas, HashTellsKeysAndTypesApart) {
  std::set<std::uint32_t> hashes;
  auto rows = parameter_rows<float>;
  hashes.insert(schema_hash<float>(rows));
  for (ParameterRow<float>& row : rows) {
    const ParameterRow<float> before = row;
    row.key.sub = static_cast<std::uint8_t>(row.key.sub + 100);
    hashes.insert(schema_hash<float>(rows));
    row = before;
    row.key.index = static_cast<std::uint16_t>(row.key.index + 0x1000);
    hashes.insert(schema_hash<float>(rows));
    row = before;
    row.type = static_cast<ValueType>(3 - static_cast<int>(row.type));
    hashes.insert(schema_hash<float>(rows));
    row = before;
  }
  EXPECT_EQ(hashes.size(), 1 + 3 * parameter_count);
}

TEST(Schemas, WhatHasMovedHasLeftItsKey) {
  for (const Moved& row : moved_parameters) {
    EXPECT_EQ(find_parameter(row.from), no_parameter);
    EXPECT_NE(find_parameter(row.to), no_parameter);
  }
}

}  // namespace
}  // namespace smaservo::parameters_test
