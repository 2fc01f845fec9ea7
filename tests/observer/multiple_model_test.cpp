#include "observer/multiple_model.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <gmock/gmock.h>
#include <limits>
#include <memory>
#include <vector>

#include "observer/measurement.hpp"
#include "tests/observer/simulated_wire.hpp"

namespace smaservo::multiple_model_test {
namespace {

using MultipleModel = MultipleModelFilter<double>;

static_assert(StrainObserver<MultipleModelFilter<double>>);
static_assert(StrainObserver<MultipleModelFilter<float>>);
static_assert(std::is_trivially_copyable_v<MultipleModel::State>);

MultipleModel::Params tuned() {
  return {plant_params(bench_wire()), {}};
}

enum class Place { cold, half, r_phase, hot };
constexpr Place places[] = {Place::cold, Place::half, Place::r_phase, Place::hot};

/// Puts the wire somewhere in its loop, where a newly started observer does not expect it.
double place(LumpedWire& wire, Place where, double stress_Pa, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform;
  const auto& k = bench_wire().kinetics;
  const double heats_K = isobar(k.m2a, stress_Pa).start_K;
  const double cools_K = isobar(k.a2m_a2r, Pair<double>(stress_Pa)).start_K.first();
  const double between_K = cools_K + (heats_K - cools_K) * (0.3 + 0.5 * uniform(random));
  switch (where) {
    case Place::cold:
      return told_ambient_K;
    case Place::half:
      wire.place(between_K, {0.3 + 0.4 * uniform(random), 0.02});
      return between_K;
    case Place::r_phase:
      wire.place(between_K, {0.1, 0.25 + 0.35 * uniform(random)});
      return between_K;
    case Place::hot:
      wire.place(heats_K + 30, {0.01, 0.0});
      return heats_K + 30;
  }
  return told_ambient_K;
}

struct Search {
  /// Time after the end of the heating from which on the error stays within 6 % of the stroke.
  double found_s = 0;
  double late = 0;  ///< mean error of the last five seconds, share of the stroke
  double worst_late = 0;
  bool decided = false;
};

/// Holds the wire where it is for half a second, heats it through once, then moves it.
Search search(Place where, double stress_Pa, std::uint64_t seed, int blind_ms = 0) {
  const MultipleModel::Params p = tuned();
  std::mt19937_64 random(seed);
  LumpedWire wire(random_deviations(random), stress_Pa, seed);
  const double hold_W = holding_W(place(wire, where, stress_Pa, random)) + 1e-3;
  const double full_W = holding_W(hot_K(stress_Pa));
  Measurement<double> m = wire.step(hold_W);
  m.resistance_valid = blind_ms == 0;
  MultipleModel::State s = MultipleModel::start(p, m, told_ambient_K);
  std::uniform_real_distribution<double> uniform;
  double level = 0;
  Search result;
  for (int i = 0; i < 15000; ++i) {
    if (i > 3500 && i % 700 == 0) {
      level = uniform(random);
    }
    m = wire.step(i < 500 ? hold_W : i < 3500 ? full_W : level * full_W);
    m.resistance_valid = i >= blind_ms;
    MultipleModel::advance(p, s, m, sample_s);
    const double error = std::abs(MultipleModel::estimate(p, s).strain - wire.strain()) / 0.04;
    if (error > 0.06) {
      result.found_s = std::max(0.0, (i - 3500) * sample_s);
    }
    if (i >= 10000) {
      result.late += error / 5000;
      result.worst_late = std::max(result.worst_late, error);
    }
  }
  result.decided = MultipleModel::estimate(p, s).health == Health::good;
  return result;
}

struct Searches {
  std::vector<double> found_s, late, worst_late;
  int undecided = 0;
};

Searches search_all(Place where, int blind_ms = 0) {
  Searches all;
  for (const double stress_Pa : {100e6, 150e6, 200e6, 300e6}) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const Search r = search(where, stress_Pa, seed, blind_ms);
      all.found_s.push_back(r.found_s);
      all.late.push_back(r.late);
      all.worst_late.push_back(r.worst_late);
      all.undecided += r.decided ? 0 : 1;
    }
  }
  return all;
}

/// Nearly every start is found within a second or two of the heating's end, and none is ever lost.
void expect_found(const Searches& all) {
  EXPECT_LE(quantile(all.found_s, 0.5), 0.5);
  EXPECT_LE(quantile(all.found_s, 0.9), 1.5);
  EXPECT_LE(quantile(all.found_s, 0.95), 4);
  // Half of the cases were measured as 0.2 to 0.4 %, the worst as 3 %. Much smaller errors would
  // show that the wires do not test the filter.
  EXPECT_GE(quantile(all.late, 0.5), 0.0005);
  EXPECT_LE(quantile(all.late, 0.5), 0.01);
  EXPECT_LE(quantile(all.late, 0.9), 0.025);
  EXPECT_LE(quantile(all.late, 1), 0.06);
  EXPECT_LE(quantile(all.worst_late, 1), 0.15);
  // At most 4 of 48 searches may be undecided at the end; until it is decided, the filter costs
  // more.
  EXPECT_LE(all.undecided, 4);
}

class MultipleModelPlaces : public testing::TestWithParam<Place> {};

std::string name_of(const testing::TestParamInfo<Place>& place) {
  static constexpr const char* all[] = {"Cold", "Half", "RPhase", "Hot"};
  return all[static_cast<int>(place.param)];
}
INSTANTIATE_TEST_SUITE_P(Unknown, MultipleModelPlaces, testing::ValuesIn(places), name_of);

TEST_P(MultipleModelPlaces, IsFoundOnceHeated) {
  expect_found(search_all(GetParam()));
}

// Missing first readings, from a front end that is slow to start, must not decide in which state
// the wire is assumed.
TEST_P(MultipleModelPlaces, IsFoundWhereTheFirstReadingsAreMissing) {
  expect_found(search_all(GetParam(), 200));
}

/// All numbers of an estimate, as bits.
std::vector<std::uint64_t> bits(const Estimate<double>& e) {
  std::vector<std::uint64_t> all;
  for (const double x :
       {e.strain, e.strain_sd, e.temperature_K, e.martensite, e.r_phase, e.resistance_model_ohm}) {
    all.push_back(std::bit_cast<std::uint64_t>(x));
  }
  all.push_back(static_cast<std::uint64_t>(e.health));
  return all;
}

TEST(MultipleModel, TheStateIsAllThereIs) {
  const MultipleModel::Params p = tuned();
  LumpedWire wire({}, 150e6, 1);
  Profile profile(150e6, 2);
  MultipleModel::State s = MultipleModel::start(p, wire.step(0.01), told_ambient_K);
  std::vector<Measurement<double>> later;
  for (int i = 0; i < 4000; ++i) {
    const Measurement<double> m = wire.step(profile.power_W(i * sample_s));
    if (i < 20) {
      MultipleModel::advance(p, s, m, sample_s);
    } else {
      later.push_back(m);
    }
  }
  ASSERT_GT(MultipleModel::alive(s), 1);
  MultipleModel::State copy;
  std::memcpy(&copy, &s, sizeof s);
  std::vector<std::vector<std::uint64_t>> first;
  for (const Measurement<double>& m : later) {
    MultipleModel::advance(p, s, m, sample_s);
    first.push_back(bits(MultipleModel::estimate(p, s)));
  }
  // The copies, one on the stack and one on the heap, are advanced in turn with another filter, and
  // must not depend on it.
  MultipleModel::State other = MultipleModel::start(p, later.back(), 320.0);
  const auto heap = std::make_unique<MultipleModel::State>(copy);
  for (std::size_t i = 0; i < later.size(); ++i) {
    MultipleModel::advance(p, other, later[later.size() - 1 - i], sample_s);
    MultipleModel::advance(p, copy, later[i], sample_s);
    MultipleModel::advance(p, *heap, later[i], sample_s);
    ASSERT_EQ(bits(MultipleModel::estimate(p, copy)), first[i]) << "step " << i;
    ASSERT_EQ(bits(MultipleModel::estimate(p, *heap)), first[i]) << "step " << i;
  }
}

TEST(MultipleModel, AStartInPlaceLeavesNothingOfWhatWasThere) {
  const MultipleModel::Params p = tuned();
  LumpedWire wire({}, 150e6, 1);
  Profile profile(150e6, 2);
  MultipleModel::State used = MultipleModel::start(p, wire.step(0.01), 320.0);
  for (int i = 0; i < 1000; ++i) {
    MultipleModel::advance(p, used, wire.step(profile.power_W(i * sample_s)), sample_s);
  }
  const Measurement<double> first = wire.step(0.01);
  MultipleModel::State fresh = MultipleModel::start(p, first, told_ambient_K);
  ASSERT_NE(bits(MultipleModel::estimate(p, used)), bits(MultipleModel::estimate(p, fresh)));
  MultipleModel::start(p, used, first, told_ambient_K);
  for (int i = 0; i < 1000; ++i) {
    const Measurement<double> m = wire.step(profile.power_W(i * sample_s));
    MultipleModel::advance(p, used, m, sample_s);
    MultipleModel::advance(p, fresh, m, sample_s);
    ASSERT_EQ(bits(MultipleModel::estimate(p, used)), bits(MultipleModel::estimate(p, fresh)))
        << "step " << i;
    ASSERT_EQ(MultipleModel::alive(used), MultipleModel::alive(fresh)) << "step " << i;
  }
}

/// Whether this filter has neither made a step nor been started; both would change its covariance.
bool untouched(const MultipleModel::State& before, const MultipleModel::State& after,
               std::size_t i) {
  const auto& a = before.filter[i].covariance;
  const auto& b = after.filter[i].covariance;
  for (int j = 0; j < MultipleModel::Filter::size; ++j) {
    for (int k = 0; k < MultipleModel::Filter::size; ++k) {
      if (a.at(j, k) != b.at(j, k)) {
        return false;
      }
    }
  }
  return true;
}

/// Calls `f` with the filter before and after each of many steps on wires in motion. Every few
/// seconds the wire is replaced by another one somewhere in its loop, with a resistance of its own,
/// which starts searches anew; readings fail now and then.
template <class F>
void through_searches(std::uint64_t seed, F f) {
  const MultipleModel::Params p = tuned();
  std::mt19937_64 random(seed);
  MultipleModel::State s{};
  for (int wire_count = 0; wire_count < 12; ++wire_count) {
    const double stress_Pa = 100e6 + 1e6 * static_cast<double>(random() % 200);
    Deviations deviations = random_deviations(random);
    deviations.resistance *= wire_count % 2 == 0 ? 1 : 1.1;  // what no filter can believe
    LumpedWire wire(deviations, stress_Pa, random());
    const double at_K = place(wire, places[random() % 4], stress_Pa, random);
    const double full_W = holding_W(hot_K(stress_Pa));
    double power_W = holding_W(at_K) + 1e-3;
    for (int i = 0; i < 4000; ++i) {
      if (i % 500 == 499) {
        power_W = full_W * static_cast<double>(random() % 100) / 100;
      }
      Measurement<double> m = wire.step(power_W);
      m.resistance_valid = random() % 50 > 0;
      if (wire_count == 0 && i == 0) {
        s = MultipleModel::start(p, m, told_ambient_K);
        continue;
      }
      MultipleModel::State before;
      std::memcpy(&before, &s, sizeof s);
      MultipleModel::advance(p, s, m, sample_s);
      f(before, s);
    }
  }
}

/// The pieces of work that a call has done beside the leader's step: other filters that it changed,
/// and parts of the preparation of a new hypothesis.
int pieces_beside_the_leader(const MultipleModel::State& before,
                             const MultipleModel::State& after) {
  int pieces = 0;
  for (std::size_t i = 0; i < MultipleModel::hypotheses; ++i) {
    pieces += i == before.leader || untouched(before, after, i) ? 0 : 1;
  }
  if (before.unopened > 0) {
    pieces += before.places == after.places ? 0 : 1;
    pieces += before.rest_slope_known == after.rest_slope_known ? 0 : 1;
  }
  if (before.paths > 0 && before.paths == after.paths && before.places > 0) {
    pieces += (after.places - before.places + 3) / 4;
  }
  return pieces;
}

/// Whether the leader's step went from heating to cooling or back. A replacement of the leader at
/// the end of a search's opening does not count.
bool leader_turned(const MultipleModel::State& before, const MultipleModel::State& after) {
  const std::size_t i = before.leader;
  const bool replaced = before.unopened == 1 && after.unopened == 0;
  return !replaced && before.filter[i].kinetics.heading != after.filter[i].kinetics.heading;
}

/// Each call makes a step of the leader. Beside it, it makes a step of one other filter, opens one,
/// or does a part of what an opening needs, which all cost about the same; it does nothing beside a
/// step of the leader that is expensive.
TEST(MultipleModel, ACallDoesOnePieceOfWorkBesideTheLeaders) {
  int searches = 0, together = 0, turns = 0, walks = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    through_searches(seed,
                     [&](const MultipleModel::State& before, const MultipleModel::State& after) {
                       const bool turned = leader_turned(before, after);
                       ASSERT_FALSE(untouched(before, after, before.leader));
                       ASSERT_LE(pieces_beside_the_leader(before, after), turned ? 0 : 1);
                       searches += before.unopened == 0 && after.unopened > 0 ? 1 : 0;
                       turns += turned && MultipleModel::alive(before) > 1 ? 1 : 0;
                       walks += before.paths == 0 && after.paths > 0 ? 1 : 0;
                       together = std::max(together, MultipleModel::alive(after));
                     });
  }
  EXPECT_GE(searches, 10);
  EXPECT_GE(turns, 3);
  EXPECT_GE(walks, 10);
  EXPECT_EQ(together, static_cast<int>(MultipleModel::hypotheses));
}

/// Each of the 5 other hypotheses makes a step in every fifth call, or some calls later if a search
/// opens or the leader turns meanwhile; on a wire that none of them can believe the leader may
/// swing to and fro for 30 calls. That step covers the whole time since its last one.
TEST(MultipleModel, NoHypothesisWaitsLong) {
  int opening = 0, longest_opening = 0;
  double longest_s = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    through_searches(seed,
                     [&](const MultipleModel::State& before, const MultipleModel::State& after) {
                       opening = after.unopened > 0 ? opening + 1 : 0;
                       longest_opening = std::max(longest_opening, opening);
                       for (std::size_t i = 0; i < MultipleModel::hypotheses; ++i) {
                         if ((after.alive >> i & 1) == 0) {
                           continue;
                         }
                         longest_s = std::max(longest_s, after.missed[i].time_s);
                         if (!untouched(before, after, i)) {
                           ASSERT_EQ(after.missed[i].time_s, 0);
                           ASSERT_EQ(after.missed[i].energy_J, 0);
                         }
                       }
                     });
  }
  EXPECT_LE(longest_opening, 14);
  EXPECT_LE(longest_s, 32e-3);
}

/// Neither the state of a filter before a search nor what a filter that was given up has left
/// behind has any influence.
TEST(MultipleModel, WhatIsGivenUpHasNoInfluence) {
  const MultipleModel::Params p = tuned();
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    std::mt19937_64 random(seed);
    LumpedWire wire(random_deviations(random), 150e6, seed);
    Profile profile(150e6, seed);
    MultipleModel::State s = MultipleModel::start(p, wire.step(0.01), told_ambient_K);
    MultipleModel::State spoilt = s;
    for (int i = 0; i < 3000; ++i) {
      for (std::size_t k = 0; k < MultipleModel::hypotheses; ++k) {
        const std::size_t from_leader = (k + MultipleModel::hypotheses - spoilt.leader) % 6;
        const bool walker = spoilt.paths > 0 && (from_leader == 1 || from_leader == 2);
        if ((spoilt.alive >> k & 1) == 0 && !walker) {
          std::memset(static_cast<void*>(&spoilt.filter[k]), 0xff,
                      sizeof spoilt.filter[k]);  // not a number
          spoilt.log_weight[k] = spoilt.log_likelihood[k] = std::nan("");
          spoilt.missed[k] = {std::nan(""), std::nan("")};
        }
      }
      const Measurement<double> m = wire.step(profile.power_W(i * sample_s));
      MultipleModel::advance(p, s, m, sample_s);
      MultipleModel::advance(p, spoilt, m, sample_s);
      ASSERT_EQ(bits(MultipleModel::estimate(p, spoilt)), bits(MultipleModel::estimate(p, s)))
          << "step " << i;
    }
  }
}

/// While a search opens, the old filter goes on, and its estimate says that the wire may be in any
/// state.
TEST(MultipleModel, GoesOnAsBeforeWhileASearchOpens) {
  const MultipleModel::Params p = tuned();
  int openings = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    through_searches(seed,
                     [&](const MultipleModel::State& before, const MultipleModel::State& after) {
                       if (after.unopened == 0) {
                         return;
                       }
                       const Estimate<double> was = MultipleModel::estimate(p, before);
                       const Estimate<double> now = MultipleModel::estimate(p, after);
                       openings += before.unopened == 0 ? 1 : 0;
                       ASSERT_EQ(now.health, Health::searching);
                       ASSERT_GE(now.strain_sd, 0.0115);
                       // The call that begins a search may first have ended another one.
                       ASSERT_TRUE(before.unopened == 0 || before.leader == after.leader);
                       ASSERT_LT(std::abs(now.strain - was.strain), 0.1 * 0.04);
                     });
  }
  EXPECT_GE(openings, 10);
}

/// A search that starts anew while the wire is hot opens the hypothesis of a cold wire at rest,
/// too. Every control that follows the estimate would take fright if that led until its first step.
TEST(MultipleModel, AHotWireIsNeverTakenForACold) {
  const MultipleModel::Params p = tuned();
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    std::mt19937_64 random(seed);
    const double stress_Pa = std::uniform_real_distribution<double>(100e6, 300e6)(random);
    LumpedWire wire(random_deviations(random), stress_Pa, seed);
    const double full_W = holding_W(hot_K(stress_Pa));
    MultipleModel::State s = MultipleModel::start(p, wire.step(1e-3), told_ambient_K);
    int searched = 0;
    for (int i = 0; i < 6000; ++i) {
      if (i == 5000) {
        s.filter[s.leader].mismatch = s.doubt_s = 2;
      }
      const Measurement<double> m = wire.step(i < 1000 ? 1e-3 : full_W);
      MultipleModel::advance(p, s, m, sample_s);
      if (i < 5000) {
        continue;
      }
      searched += s.unopened > 0 ? 1 : 0;
      const Estimate<double> e = MultipleModel::estimate(p, s);
      ASSERT_LT(std::abs(e.strain - wire.strain()), 0.1 * 0.04) << seed << ", " << i;
      ASSERT_GT(MultipleModel::likeliest(s).kinetics.drive.temperature_K, told_ambient_K + 20)
          << seed << ", " << i;
    }
    EXPECT_GT(searched, 0) << seed;
  }
}

/// How the filter follows a wire that is held halfway while the air moves, or is shut off, for 8 s.
struct Gust {
  double late = 0;      ///< greatest error of the gust's last second, share of the stroke
  double untold_s = 0;  ///< time with an error above 3 % that neither health nor deviation tells
};

/// A full cycle, then a constant power; the loss is this many times as large from 16 to 24 s.
template <class HeldWire>
Gust gust(double loss, double stress_Pa, std::uint64_t seed) {
  const MultipleModel::Params p = tuned();
  std::mt19937_64 random(seed);
  HeldWire wire(random_deviations(random), stress_Pa, seed);
  const double full_W = holding_W(hot_K(stress_Pa));
  const double hold_W = std::uniform_real_distribution<double>(0.62, 0.74)(random) * full_W;
  MultipleModel::State s = MultipleModel::start(p, wire.step(1e-3), told_ambient_K);
  Gust result;
  for (int i = 0; i < 34000; ++i) {
    if (i == 16000 || i == 24000) {
      wire.move_air(i == 16000 ? loss : 1 / loss);
    }
    const double power_W = i < 4000 ? full_W : i < 8000 ? 1e-3 : hold_W;
    MultipleModel::advance(p, s, wire.step(power_W), sample_s);
    const Estimate<double> e = MultipleModel::estimate(p, s);
    const double error = std::abs(e.strain - wire.strain()) / 0.04;
    const bool told = e.health != Health::good || error < 2 * e.strain_sd / 0.04;
    // For half a second after each change nobody can know.
    if (i >= 16000 && (i - 16000) % 8000 >= 500 && error > 0.03 && !told) {
      result.untold_s += sample_s;
    }
    if (i >= 23000 && i < 24000) {
      result.late = std::max(result.late, error);
    }
  }
  return result;
}

/// Without walkers the median error was 2 to 5 % of the
/// stroke, the worst 12 %, and 10 to 16 of 16 were not told.
template <class HeldWire>
void expect_followed_through_gusts() {
  for (const double loss : {0.5, 2.0, 3.0}) {
    std::vector<double> late;
    int untold = 0;
    for (const double stress_Pa : {100e6, 250e6}) {
      for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const Gust one = gust<HeldWire>(loss, stress_Pa, seed);
        late.push_back(one.late);
        untold += one.untold_s > 0.5 ? 1 : 0;
      }
    }
    EXPECT_LE(quantile(late, 0.5), 0.015) << loss;
    EXPECT_LE(quantile(late, 0.9), 0.03) << loss;
    EXPECT_LE(quantile(late, 1), 0.08) << loss;
    EXPECT_LE(untold, 2) << loss << ": of 16";
  }
}

TEST(MultipleModel, FollowsAHeldWireThroughMovingAir) {
  expect_followed_through_gusts<LumpedWire>();
}

/// A wire is held where two hypotheses fit it, by readings that are too coarse to tell them apart.
struct Undecided {
  MultipleModel::Params p = tuned();
  LumpedWire wire{{}, 150e6, 1};
  double hold_W = 0;
  MultipleModel::State s{};

  Undecided() {
    const double cools_K =
        isobar(bench_wire().kinetics.a2m_a2r, Pair<double>(150e6)).start_K.first();
    wire.place(cools_K + 5, {0.5, 0.02});
    hold_W = holding_W(cools_K + 5);
    s = MultipleModel::start(p, read(hold_W), told_ambient_K);
  }
  Measurement<double> read(double power_W) {
    Measurement<double> m = wire.step(power_W);
    m.resistance_sd_ohm *= 1000;
    return m;
  }
  void advance(const Measurement<double>& m) { MultipleModel::advance(p, s, m, sample_s); }
  bool searching() const { return MultipleModel::estimate(p, s).health == Health::searching; }
  double heat_needed_J() const {
    return 2 * (80 * p.model.body.capacity_J_K + p.model.body.latent_m2a_J);
  }
};

TEST(MultipleModel, HeatEndsASearchThatTheResistanceDoesNotDecide) {
  Undecided held;
  const auto& body = held.p.model.body;
  const double counted_W = held.hold_W - body.loss_W(10);
  double heat_J = 0;
  double strain = MultipleModel::estimate(held.p, held.s).strain;
  double greatest_step = 0;
  double ended_s = 0;
  for (int i = 0; i < 60000; ++i) {
    held.advance(held.read(held.hold_W));
    if (held.s.unopened > 0) {
      continue;
    }
    heat_J += counted_W * sample_s;
    const double now = MultipleModel::estimate(held.p, held.s).strain;
    if (heat_J > held.heat_needed_J()) {
      greatest_step = std::max(greatest_step, std::abs(now - strain));
      ended_s += held.searching() ? sample_s : 0;
    } else {
      ASSERT_TRUE(held.searching()) << "at " << i << " ms; nothing is left to decide";
    }
    strain = now;
  }
  EXPECT_FALSE(held.searching());
  // A tenth of a second takes exp(1) from the weight of the others, of which exp(-10) is none.
  EXPECT_GT(ended_s, 0.02);
  EXPECT_LT(ended_s, 1);
  EXPECT_LT(greatest_step, 2e-4) << "the estimate jumps";
}

/// A fan that stops again: one hypothesis takes the wire for cooled as it was calibrated, the
/// others for cooled much less, and the resistance does not decide.
TEST(MultipleModel, WhereAirHasMovedHeatKeepsTheUsualLoss) {
  for (const bool leads : {true, false}) {
    Undecided held;
    while (held.s.unopened > 0) {
      held.advance(held.read(held.hold_W));
    }
    MultipleModel::State& s = held.s;
    ASSERT_GE(MultipleModel::alive(s), 3);
    s.air_moved = true;
    s.heat_J = 10 * held.heat_needed_J();
    std::size_t usual = 0;
    for (std::size_t i = 0; i < s.filter.size(); ++i) {
      usual = (s.alive >> i & 1U) != 0 ? i : usual;
    }
    ASSERT_NE(usual, std::size_t{s.leader});
    s.leader = leads ? static_cast<std::uint8_t>(usual) : s.leader;
    for (std::size_t i = 0; i < s.filter.size(); ++i) {
      s.filter[i].loss_range = 3;
      s.filter[i].loss = i == usual ? 1.05 : 0.4;
      s.log_likelihood[i] = i == usual && !leads ? -0.5 : 0;
      s.log_weight[i] = s.log_likelihood[i];
    }
    for (int i = 0; i < 600; ++i) {
      held.advance(held.read(held.hold_W));
    }
    EXPECT_EQ(std::size_t{s.leader}, usual) << leads;
    EXPECT_FALSE(held.searching()) << leads;
  }
}

TEST(MultipleModel, NeitherColdNorBlindTimeEndsASearch) {
  Undecided cold;
  Undecided blind;
  const double cold_W = cold.p.model.body.loss_W(9.9);
  for (int i = 0; i < 60000; ++i) {
    Measurement<double> m = cold.read(cold.hold_W);
    m.power_W = cold_W;
    cold.advance(m);
    m = blind.read(blind.hold_W);
    m.resistance_valid = i < 100;
    blind.advance(m);
  }
  EXPECT_EQ(cold.s.unopened, 0);
  EXPECT_EQ(cold.s.heat_J, 0);
  EXPECT_EQ(blind.s.unopened, 0);
  EXPECT_TRUE(blind.searching());
  EXPECT_LT(blind.s.heat_J, 0.1 * blind.hold_W);
}

TEST(MultipleModel, AWalkThatReadingsInterruptBeginsAnew) {
  const MultipleModel::Params p = tuned();
  int interrupted = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    LumpedWire wire({}, 150e6, seed);
    const double full_W = holding_W(hot_K(150e6));
    MultipleModel::State s = MultipleModel::start(p, wire.step(1e-3), told_ambient_K);
    int blind_until = 0;
    double error = 0;
    for (int i = 0; i < 24000; ++i) {
      if (i == 14000) {
        wire.move_air(2.5);
      }
      Measurement<double> m = wire.step(i < 4000 ? full_W : i < 8000 ? 1e-3 : 0.68 * full_W);
      m.resistance_valid = i >= blind_until;
      MultipleModel::advance(p, s, m, sample_s);
      if (s.paths > 0 && blind_until == 0) {
        blind_until = i + 1000;
        ++interrupted;
      }
      ASSERT_TRUE(m.resistance_valid || s.paths == 0 || i + 1000 == blind_until) << i;
      error = std::abs(MultipleModel::estimate(p, s).strain - wire.strain()) / 0.04;
    }
    EXPECT_LE(error, 0.03) << seed;
  }
  EXPECT_EQ(interrupted, 6);
}

TEST(MultipleModel, FollowsAHeldWireWithColdEndsThroughMovingAir) {
  expect_followed_through_gusts<DistributedWire>();
}

template <class S>
bool sound(const Estimate<S>& e) {
  const S slack = S(1e-5);
  return std::isfinite(e.strain) && std::isfinite(e.strain_sd) && e.strain_sd >= 0 &&
         std::isfinite(e.temperature_K) && std::isfinite(e.resistance_model_ohm) &&
         e.martensite >= -slack && e.r_phase >= -slack && e.martensite + e.r_phase <= 1 + slack;
}

/// Readings as broken leads, shorts and a spoilt converter give them.
double rubbish(double good, std::mt19937_64& random) {
  switch (random() % 12) {
    case 0:
      return std::numeric_limits<double>::quiet_NaN();
    case 1:
      return std::numeric_limits<double>::infinity();
    case 2:
      return 0;
    case 3:
      return -good;
    case 4:
      return 40 * good;
    case 5:
      return 0.03 * good;
    default:
      return good;
  }
}

TEST(MultipleModel, RubbishNeverMakesItSayNaN) {
  const Wire<double>& w = bench_wire();
  const MeasurementParams<double> front_end{
      w.geometry.area_m2(), 0, 0, 1e-5, 1e-3, 0, 0.01, 1, 1000};
  constexpr int wires = 200;
  int lost = 0;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= wires; ++seed) {
    const MultipleModel::Params p = tuned();
    std::mt19937_64 random(seed);
    const double stress_Pa = 150e6;
    LumpedWire wire({}, stress_Pa, seed);
    Profile profile(stress_Pa, seed);
    MultipleModel::State s = MultipleModel::start(p, wire.step(0.01), told_ambient_K);
    double late = 0;
    for (int i = 0; i < 20000; ++i) {
      const double power_W = profile.power_W((i % 12000) * sample_s);
      Measurement<double> m = wire.step(power_W);
      if (i < 5000) {
        const double I = std::sqrt(power_W / m.resistance_ohm);
        m = measure<double>(front_end, {rubbish(I, random), rubbish(I * m.resistance_ohm, random),
                                        rubbish(stress_Pa * w.geometry.area_m2(), random)});
      }
      MultipleModel::advance(p, s, m, sample_s);
      const Estimate<double> e = MultipleModel::estimate(p, s);
      ASSERT_TRUE(sound(e)) << "seed " << seed << ", step " << i;
      late += i < 15000 ? 0 : std::abs(e.strain - wire.strain()) / 0.04 / 5000;
    }
    lost += late < 0.06 ? 0 : 1;
    sum += late;
  }
  // Of 2000 wires 6.8 % do not come back: such readings drive the slow states to their bounds, and
  // what is left of the contradiction may be too little for a new search. Of 200 wires that is 13.6
  // on average, with a standard deviation of 3.6; two of these above the average are allowed.
  EXPECT_LE(lost, 20) << "of " << wires;
  EXPECT_LE(sum / wires, 0.025);
}

TEST(MultipleModel, ResistanceJumpsNeverMakeItSayNaN) {
  const MultipleModel::Params p = tuned();
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> uniform;
  for (int run = 0; run < 20; ++run) {
    Measurement<double> m{20, 0.01, 0, 150e6, true, true, true};
    MultipleModel::State s = MultipleModel::start(p, m, told_ambient_K);
    for (int i = 0; i < 1000; ++i) {
      m.resistance_ohm = std::pow(10, 3 * uniform(random));
      m.power_W = 2 * uniform(random);
      m.stress_Pa = 600e6 * uniform(random);
      MultipleModel::advance(p, s, m, 0.02 * uniform(random) + 1e-5);
      ASSERT_TRUE(sound(MultipleModel::estimate(p, s))) << "run " << run << ", step " << i;
      ASSERT_GE(MultipleModel::alive(s), 1);
    }
  }
}

}  // namespace
}  // namespace smaservo::multiple_model_test
