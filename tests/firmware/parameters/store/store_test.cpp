#include "firmware/parameters/store/store.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/firmware/parameters/random_settings.hpp"
#include "tests/firmware/parameters/store/memory_storage.hpp"

namespace smaservo::store_test {
namespace {

struct TwoSets {
  Settings<float> before, after;
};

TwoSets two_sets() {
  std::mt19937 random(3);
  return {random_settings<float>(random), random_settings<float>(random)};
}

/// A storage that has been saved to several times, so that both slots hold something.
MemoryStorage used_storage(const Settings<float>& last) {
  MemoryStorage storage;
  std::mt19937 random(4);
  EXPECT_TRUE(save_settings(storage, random_settings<float>(random)).ok());
  EXPECT_TRUE(save_settings(storage, random_settings<float>(random)).ok());
  EXPECT_TRUE(save_settings(storage, last).ok());
  return storage;
}

std::size_t image_size(const StoreSchema<float>& schema = own_schema<float>) {
  return image::header_size + image::entry_size * (schema.rows.size() + schema.moved.size()) +
         image::crc_size;
}

/// Writes an image past the checks of save_settings().
void forge(MemoryStorage& storage, unsigned slot, const Settings<float>& settings,
           std::uint32_t sequence) {
  std::size_t at = 0;
  image::write(own_schema<float>, settings, sequence, [&](std::span<const std::byte> chunk) {
    const bool ok = storage.write(slot, at, chunk);
    at += chunk.size();
    return ok;
  });
}

TEST(Store, CrcIsTheOneOfIeee8023) {
  Crc32 crc;
  for (const char letter : {'1', '2', '3', '4', '5', '6', '7', '8', '9'}) {
    const std::byte byte{static_cast<unsigned char>(letter)};
    crc.add({&byte, 1});
  }
  EXPECT_EQ(crc.value(), 0xCBF43926U);
}

TEST(Store, GivesBackEveryBit) {
  std::mt19937 random(1);
  MemoryStorage storage;
  for (std::uint32_t i = 1; i <= 50; ++i) {
    const Settings<float> settings = random_settings<float>(random);
    const Saved saved = save_settings(storage, settings);
    ASSERT_TRUE(saved.ok());
    EXPECT_EQ(saved.sequence, i + 1) << "the first save writes two";
    EXPECT_EQ(saved.slot, i % 2);
    const Loaded<float> loaded = load_settings<float>(storage);
    EXPECT_TRUE(same_settings(loaded.settings, settings));
    EXPECT_EQ(loaded.slot, saved.slot);
    EXPECT_EQ(loaded.reason, LoadReason::newer);
    const SlotReport& report = loaded.slots[loaded.slot];
    EXPECT_EQ(report.sequence, i + 1);
    EXPECT_EQ(report.entries, parameter_count);
    EXPECT_EQ(report.unknown + report.moved + report.missing, 0);
    EXPECT_EQ(schema_version(report.schema_hash), released_schemas.back().version);
  }
}

TEST(Store, FloatAndDoubleReadEachOther) {
  const Settings<double> settings = reference_settings();
  MemoryStorage storage;
  ASSERT_TRUE(save_settings(storage, settings).ok());
  EXPECT_TRUE(
      same_settings(load_settings<float>(storage).settings, stored_settings<float>(settings)));
}

TEST(Store, ADeviceWithoutWireKeepsTheRest) {
  Settings<float> settings = default_settings<float>();
  settings.identity.node_id = 17;
  MemoryStorage storage;
  ASSERT_TRUE(save_settings(storage, settings).ok());
  const Loaded<float> loaded = load_settings<float>(storage);
  EXPECT_EQ(loaded.settings.identity.node_id, 17U);
  EXPECT_EQ(first_missing(loaded.settings), first_missing(settings));
}

TEST(Store, AnEmptyOneSaysSo) {
  MemoryStorage storage;
  const Loaded<float> loaded = load_settings<float>(storage);
  EXPECT_EQ(loaded.reason, LoadReason::none);
  EXPECT_EQ(loaded.slots[0].state, SlotState::empty);
  EXPECT_EQ(loaded.slots[1].state, SlotState::empty);
}

/// The one test that this file is for: power fails at every byte that save_settings() changes.
TEST(Store, APowerCutLeavesTheOldOrTheNewSet) {
  const TwoSets sets = two_sets();
  const MemoryStorage start = used_storage(sets.before);
  MemoryStorage whole = start;
  const std::size_t before = whole.changed();
  ASSERT_TRUE(save_settings(whole, sets.after).ok());
  const std::size_t bytes = whole.changed() - before;
  ASSERT_EQ(bytes, MemoryStorage::slot_size + image_size());
  for (const Rest rest : {Rest::kept, Rest::erased, Rest::garbage}) {
    std::size_t olds = 0;
    for (std::size_t cut = 0; cut <= bytes; ++cut) {
      MemoryStorage storage = start;
      storage.cut_after(cut, rest);
      const Saved saved = save_settings(storage, sets.after);
      storage.power_on();
      const Loaded<float> loaded = load_settings<float>(storage);
      ASSERT_NE(loaded.reason, LoadReason::none) << cut;
      const bool is_new = same_settings(loaded.settings, sets.after);
      ASSERT_TRUE(is_new || same_settings(loaded.settings, sets.before)) << cut;
      ASSERT_EQ(is_new, loaded.slots[loaded.slot].sequence == 5) << cut;
      ASSERT_TRUE(is_new || !saved.ok()) << cut << ": it said that it had saved them";
      olds += is_new ? 0 : 1;
      if (cut % 500 == 0) {
        EXPECT_TRUE(save_settings(storage, sets.after).ok()) << "it goes on afterwards";
        EXPECT_TRUE(same_settings(load_settings<float>(storage).settings, sets.after));
      }
    }
    EXPECT_GE(olds, bytes - 1);
  }
}

TEST(Store, TheFirstSaveIsCutToNothingOrAll) {
  const TwoSets sets = two_sets();
  const std::size_t bytes = MemoryStorage::slot_size + image_size();
  for (std::size_t cut = 0; cut <= 2 * bytes; cut += cut % bytes < bytes - 300 ? 100 : 1) {
    MemoryStorage storage;
    storage.cut_after(cut, Rest::garbage);
    const bool saved = save_settings(storage, sets.after).ok();
    storage.power_on();
    const Loaded<float> loaded = load_settings<float>(storage);
    EXPECT_EQ(loaded.reason == LoadReason::none, cut < bytes) << cut;
    EXPECT_TRUE(cut < bytes || same_settings(loaded.settings, sets.after)) << cut;
    EXPECT_EQ(saved, cut == 2 * bytes);
  }
}

TEST(Store, EveryFlippedBitIsSeen) {
  const TwoSets sets = two_sets();
  MemoryStorage storage = used_storage(sets.before);
  const unsigned newest = load_settings<float>(storage).slot;
  for (std::size_t i = 0; i < image_size(); ++i) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      storage.slots[newest][i] ^= std::byte{1} << bit;
      const Loaded<float> loaded = load_settings<float>(storage);
      ASSERT_EQ(loaded.slots[newest].state, SlotState::damaged) << i << " " << bit;
      ASSERT_EQ(loaded.reason, LoadReason::other_bad);
      ASSERT_EQ(loaded.slot, 1 - newest);
      ASSERT_TRUE(loaded.may_be_older);
      storage.slots[newest][i] ^= std::byte{1} << bit;
    }
  }
}

/// Nobody may take older values for those that were stored last.
TEST(Store, SaysWhenWhatWasStoredLastMayBeLost) {
  std::mt19937 random(12);
  MemoryStorage storage;
  EXPECT_FALSE(load_settings<float>(storage).may_be_older) << "nothing was ever stored";
  ASSERT_TRUE(save_settings(storage, random_settings<float>(random)).ok());
  EXPECT_FALSE(load_settings<float>(storage).may_be_older) << "stored once";
  const Settings<float> older = random_settings<float>(random);
  ASSERT_TRUE(save_settings(storage, older).ok());
  ASSERT_TRUE(save_settings(storage, random_settings<float>(random)).ok());
  EXPECT_FALSE(load_settings<float>(storage).may_be_older);
  const unsigned newest = load_settings<float>(storage).slot;
  MemoryStorage missing = storage;
  ASSERT_TRUE(missing.erase(newest));
  const Loaded<float> loaded = load_settings<float>(missing);
  EXPECT_EQ(loaded.reason, LoadReason::only_one);
  EXPECT_TRUE(same_settings(loaded.settings, older));
  EXPECT_TRUE(loaded.may_be_older) << "it was stored more than once, and one slot is gone";
  ASSERT_TRUE(save_settings(missing, older).ok());
  EXPECT_FALSE(load_settings<float>(missing).may_be_older) << "stored anew";
}

/// After any number of saves: a slot that is gone never gives other settings back without a word.
/// Also in a store whose only slot is of a release that wrote one at its first save.
TEST(Store, ALostSlotIsEitherACopyOrSaid) {
  std::mt19937 random(14);
  for (const bool has_one : {false, true}) {
    MemoryStorage storage;
    if (has_one) {
      forge(storage, 0, random_settings<float>(random), 1);
    }
    for (int saves = 1; saves <= 5; ++saves) {
      const Settings<float> last = random_settings<float>(random);
      ASSERT_TRUE(save_settings(storage, last).ok());
      EXPECT_FALSE(load_settings<float>(storage).may_be_older);
      for (unsigned slot = 0; slot < slot_count; ++slot) {
        for (const std::byte rest : {std::byte{0xFF}, std::byte{0}}) {
          MemoryStorage lost = storage;
          std::ranges::fill(lost.slots[slot], rest);
          const Loaded<float> loaded = load_settings<float>(lost);
          EXPECT_EQ(loaded.reason, LoadReason::only_one);
          EXPECT_TRUE(loaded.may_be_older || same_settings(loaded.settings, last))
              << saves << " saves, slot " << slot;
        }
      }
    }
  }
}

TEST(Store, ABadSlotStillTellsWhatDiffers) {
  const TwoSets sets = two_sets();
  Settings<float> lower = sets.before;
  lower.limits.current_A *= 0.5F;
  MemoryStorage storage = used_storage(sets.before);
  ASSERT_TRUE(save_settings(storage, lower).ok());
  const unsigned newest = load_settings<float>(storage).slot;
  storage.slots[newest][4] ^= std::byte{1};  // its head is not needed
  std::vector<Key> differing;
  salvage<float>(storage, newest, [&](const ParameterRow<float>& row, Value value) {
    if (row.get(load_settings<float>(storage).settings) != value) {
      differing.push_back(row.key);
      EXPECT_EQ(value.real(), lower.limits.current_A);
    }
  });
  ASSERT_EQ(differing.size(), 1U);
  EXPECT_EQ(differing[0], (Key{0x2020, 2}));
  // Whatever lies there: only values that are possible.
  std::mt19937 random(13);
  for (int i = 0; i < 200; ++i) {
    std::ranges::generate(storage.slots[0], [&] { return static_cast<std::byte>(random()); });
    salvage<float>(storage, 0, [&](const ParameterRow<float>& row, Value value) {
      EXPECT_EQ(fit(row, value), Fit::inside);
    });
  }
}

TEST(Store, TwoBadSlotsAreNoSettings) {
  MemoryStorage storage = used_storage(two_sets().before);
  storage.slots[0][40] ^= std::byte{1};
  storage.slots[1][60] ^= std::byte{1};
  const Loaded<float> loaded = load_settings<float>(storage);
  EXPECT_EQ(loaded.reason, LoadReason::none);
  EXPECT_EQ(loaded.slots[0].state, SlotState::damaged);
  EXPECT_EQ(loaded.slots[1].state, SlotState::damaged);
  storage.fail_reads = true;
  EXPECT_EQ(load_settings<float>(storage).slots[0].state, SlotState::unreadable);
  EXPECT_EQ(load_settings<float>(storage).reason, LoadReason::none);
}

TEST(Store, RandomBytesAreNoSettings) {
  std::mt19937 random(6);
  MemoryStorage storage;
  for (int i = 0; i < 1000; ++i) {
    for (auto& slot : storage.slots) {
      for (std::byte& byte : slot) {
        byte = static_cast<std::byte>(random());
      }
      image::put<std::uint32_t>(slot, image::magic);
    }
    EXPECT_EQ(load_settings<float>(storage).reason, LoadReason::none);
  }
}

/// Numbers go on after the greatest one: what is saved last is what the next start takes.
TEST(Store, TheNumberMayWrapAndTheNewestStaysTheNewest) {
  std::mt19937 random(9);
  for (const std::uint32_t start : {0U, 1U, 0x7FFF'FFFEU, 0x7FFF'FFFFU, 0x8000'0000U, 0xFFFF'FFFDU,
                                    0xFFFF'FFFEU, 0xFFFF'FFFFU}) {
    for (const unsigned slot : {0U, 1U}) {
      MemoryStorage storage;
      forge(storage, slot, random_settings<float>(random), start);
      for (int i = 0; i < 4; ++i) {
        const Settings<float> last = random_settings<float>(random);
        ASSERT_TRUE(save_settings(storage, last).ok());
        const Loaded<float> loaded = load_settings<float>(storage);
        EXPECT_TRUE(same_settings(loaded.settings, last)) << start << ' ' << i;
      }
    }
  }
}

/// Whatever two intact slots hold: the save is the one that counts, and it spares the one that
/// counted before.
TEST(Store, ASaveCountsAfterAnyTwoNumbers) {
  std::mt19937 random(10);
  const Settings<float> a = random_settings<float>(random);
  const Settings<float> b = random_settings<float>(random);
  const Settings<float> last = random_settings<float>(random);
  const std::uint32_t numbers[] = {0, 1, 2, 0x7FFF'FFFF, 0x8000'0000, 0x8000'0001, 0xFFFF'FFFF};
  for (const std::uint32_t first : numbers) {
    for (const std::uint32_t second : numbers) {
      MemoryStorage storage;
      forge(storage, 0, a, first);
      forge(storage, 1, b, second);
      const unsigned counted = load_settings<float>(storage).slot;
      const Saved saved = save_settings(storage, last);
      ASSERT_TRUE(saved.ok());
      // Number 0 or 1 would be taken for that of a first save: it is overwritten as well.
      const bool both = (counted == 0 ? first : second) < 2;
      EXPECT_EQ(saved.slot, both ? counted : 1 - counted) << first << ' ' << second;
      EXPECT_TRUE(same_settings(load_settings<float>(storage).settings, last))
          << first << ' ' << second;
    }
  }
}

TEST(Store, AnIntactImageOfImpossibleSettingsIsRefused) {
  const TwoSets sets = two_sets();
  const auto loaded_with = [&](Settings<float> settings) {
    MemoryStorage storage;
    forge(storage, 0, sets.before, 7);
    forge(storage, 1, settings, 8);
    const Loaded<float> loaded = load_settings<float>(storage);
    EXPECT_EQ(loaded.reason, LoadReason::other_bad);
    EXPECT_TRUE(same_settings(loaded.settings, sets.before));
    EXPECT_EQ(loaded.slots[1].state, SlotState::refused);
    EXPECT_EQ(loaded.slots[1].sequence, 8U);
    EXPECT_TRUE(loaded.may_be_older);
    forge(storage, 0, sets.before, 9);
    EXPECT_FALSE(load_settings<float>(storage).may_be_older) << "the refused one is the older";
    forge(storage, 0, sets.before, 7);
    EXPECT_EQ(save_settings(storage, sets.after).slot, 1U) << "the good one is kept";
    EXPECT_EQ(load_settings<float>(storage).slots[1].sequence, 8U) << "after the one that stays";
    return loaded.slots[1].finding;
  };
  Settings<float> settings = sets.after;
  settings.limits.current_A = 1000;
  EXPECT_EQ(loaded_with(settings).problem, Problem::above);
  settings = sets.after;
  settings.limits.current_A = std::nanf("");
  EXPECT_EQ(loaded_with(settings).problem, Problem::not_finite);
  settings = sets.after;
  settings.limits.temperature_K = settings.trips.temperature_K;
  EXPECT_EQ(loaded_with(settings).problem, Problem::contradiction);
  settings = sets.after;
  settings.identity.node_id = 128;
  EXPECT_EQ(loaded_with(settings).parameter, find_parameter("identity.node_id"));
}

TEST(Store, ImpossibleSettingsAreNotSaved) {
  const TwoSets sets = two_sets();
  MemoryStorage storage = used_storage(sets.before);
  const std::size_t changed = storage.changed();
  Settings<float> settings = sets.after;
  settings.trips.stress_Pa = settings.limits.stress_Pa;
  const Saved saved = save_settings(storage, settings);
  EXPECT_EQ(saved.problem, SaveProblem::refused);
  EXPECT_EQ(saved.finding.problem, Problem::contradiction);
  EXPECT_EQ(storage.changed(), changed);
}

TEST(Store, AFailingStorageIsNoticed) {
  const TwoSets sets = two_sets();
  const MemoryStorage start = used_storage(sets.before);
  const auto problem_with = [&](auto prepare) {
    MemoryStorage storage = start;
    prepare(storage);
    const SaveProblem problem = save_settings(storage, sets.after).problem;
    storage.power_on();
    storage.fail_reads = false;
    EXPECT_TRUE(same_settings(load_settings<float>(storage).settings, sets.before) ||
                problem == SaveProblem::sync);
    return problem;
  };
  EXPECT_EQ(problem_with([](MemoryStorage& s) { s.cut_after(10, Rest::kept); }),
            SaveProblem::erase);
  EXPECT_EQ(problem_with(
                [](MemoryStorage& s) { s.cut_after(MemoryStorage::slot_size + 300, Rest::kept); }),
            SaveProblem::write);
  EXPECT_EQ(problem_with([](MemoryStorage& s) { s.fail_sync = true; }), SaveProblem::sync);
  EXPECT_EQ(problem_with([](MemoryStorage& s) { s.stuck_bit = true; }), SaveProblem::differs);
}

// Two made-up releases: in the newer one the load's gain has moved to another key, where the older
// one had half of it; one parameter is gone and two are new.

constexpr Key old_key{0x2010, 4};
constexpr Key new_key{0x2010, 20};

std::vector<ParameterRow<float>> older_rows() {
  std::vector<ParameterRow<float>> rows;
  for (const Parameter<float>& row : parameters<float>) {
    const std::string_view path = row.path.text();
    if (path != "trips.following_s" && path != "drive.integral_1_s") {
      rows.push_back(row);
    }
  }
  return rows;
}

std::vector<ParameterRow<float>> newer_rows() {
  std::vector<ParameterRow<float>> rows;
  for (Parameter<float> row : parameters<float>) {
    if (row.path.text() == "axis.zero_strain") {
      continue;
    }
    if (row.key == old_key) {
      row.key = new_key;
    }
    rows.push_back(row);
  }
  std::ranges::sort(rows, {}, &ParameterRow<float>::key);
  return rows;
}

constexpr Moved doubled[] = {{old_key, new_key, 2}};

struct Releases {
  std::vector<ParameterRow<float>> older = older_rows(), newer = newer_rows();
  StoreSchema<float> old_schema{older, {}}, new_schema{newer, doubled};
};

Settings<float> example() {
  Settings<float> settings = reference_settings<float>();
  settings.measurement.load_gain = 0.75F;
  settings.axis.zero_strain = 0.03F;
  settings.trips.following_s = 5;
  settings.drive.integral_1_s = 70;
  return settings;
}

TEST(Store, AnOlderImageIsTakenOver) {
  const Releases r;
  MemoryStorage storage;
  ASSERT_TRUE(save_settings(storage, example(), r.old_schema).ok());
  const Loaded<float> loaded = load_settings(storage, r.new_schema);
  const SlotReport& report = loaded.slots[loaded.slot];
  EXPECT_EQ(report.state, SlotState::valid);
  EXPECT_EQ(report.moved, 1);
  EXPECT_EQ(report.unknown, 1) << "the zero";
  EXPECT_EQ(report.missing, 2) << "the new ones";
  EXPECT_EQ(report.schema_hash, schema_hash<float>(r.older));
  EXPECT_EQ(loaded.settings.measurement.load_gain, 1.5F);
  EXPECT_EQ(loaded.settings.trips.following_s, default_settings<float>().trips.following_s);
}

TEST(Store, ANewerImageServesAnOlderRelease) {
  const Releases r;
  MemoryStorage storage;
  ASSERT_TRUE(save_settings(storage, example(), r.new_schema).ok());
  const Loaded<float> loaded = load_settings(storage, r.old_schema);
  const SlotReport& report = loaded.slots[loaded.slot];
  EXPECT_EQ(report.state, SlotState::valid);
  EXPECT_EQ(report.unknown, 3) << "the new key and two new parameters";
  EXPECT_EQ(report.missing, 1) << "the zero";
  EXPECT_EQ(report.moved, 0);
  EXPECT_EQ(loaded.settings.measurement.load_gain, 0.375F) << "written under its old key, too";
}

TEST(Store, ThereAndBackLosesNothingThatBothKnow) {
  const Releases r;
  std::mt19937 random(8);
  for (int i = 0; i < 20; ++i) {
    const Settings<float> start = random_settings<float>(random);
    MemoryStorage storage;
    ASSERT_TRUE(save_settings(storage, start, r.new_schema).ok());
    Settings<float> settings = load_settings(storage, r.old_schema).settings;
    settings.limits.power_W = 1.5F;
    ASSERT_TRUE(save_settings(storage, settings, r.old_schema).ok());
    const Loaded<float> back = load_settings(storage, r.new_schema);
    EXPECT_EQ(back.settings.limits.power_W, 1.5F) << "the older release saved last";
    EXPECT_EQ(back.settings.measurement.load_gain, start.measurement.load_gain);
    EXPECT_EQ(back.settings.wire.geometry.length_m, start.wire.geometry.length_m);
  }
}

TEST(Store, AChangeThatIsOutOfRangeForTheOtherReleaseIsRefused) {
  Releases r;
  Settings<float> settings = example();
  settings.limits.current_A = 0.2F;
  settings.trips.current_A = 0.25F;
  MemoryStorage storage;
  forge(storage, 0, settings, 2);
  const auto narrow = std::ranges::find(r.older, Key{0x2022, 1}, &ParameterRow<float>::key);
  settings.safe.state = SafeState::release;
  ASSERT_TRUE(save_settings(storage, settings, r.new_schema).ok());
  narrow->max = Value::number(1);
  const Loaded<float> loaded = load_settings(storage, r.old_schema);
  EXPECT_EQ(loaded.slots[1].state, SlotState::refused);
  EXPECT_EQ(loaded.slots[1].finding.problem, Problem::above);
  EXPECT_EQ(loaded.slot, 0U);
  EXPECT_EQ(loaded.reason, LoadReason::other_bad);
}

}  // namespace
}  // namespace smaservo::store_test
