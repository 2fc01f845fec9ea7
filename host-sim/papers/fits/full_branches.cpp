#include "host-sim/papers/fits/full_branches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace smaservo::fits {
namespace {

constexpr double outer = 0.9;
constexpr double inner_share = 0.1;
constexpr double max_back = 0.05;

/// The position of a row between the shortest and the longest wire, as a share of the stroke.
class Stroke {
 public:
  explicit Stroke(const std::vector<double>& strain)
      : strain_(strain),
        shortest_(*std::ranges::min_element(strain)),
        span_(*std::ranges::max_element(strain) - shortest_) {}
  double share(std::size_t row) const { return (strain_[row] - shortest_) / span_; }

 private:
  const std::vector<double>& strain_;
  double shortest_, span_;
};

/// Means over bins of the stroke.
class Bins {
 public:
  void add(double share, const papers::ResistancePoint<double>& point) {
    const double place = (share - inner_share) / (outer - inner_share) * static_cast<double>(count);
    const auto bin =
        static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(count) - 1));
    sum_[bin].strain += point.strain;
    sum_[bin].resistance += point.resistance;
    ++rows_[bin];
  }
  void append_to(std::vector<papers::ResistancePoint<double>>& points) const {
    for (std::size_t i = 0; i < count; ++i) {
      if (rows_[i] > 0) {
        points.push_back({sum_[i].strain / rows_[i], sum_[i].resistance / rows_[i]});
      }
    }
  }

 private:
  static constexpr std::size_t count = 40;
  std::array<papers::ResistancePoint<double>, count> sum_{};
  std::array<double, count> rows_{};
};

/// Follows one direction through the rows and returns each full branch in it.
class Follower {
 public:
  Follower(bool heats, const identify::Run& run, double ohm)
      : heats_(heats), run_(run), ohm_(ohm) {}

  void visit(const Stroke& stroke, std::size_t row,
             std::vector<papers::ResistancePoint<double>>& points) {
    const double share = stroke.share(row);
    const double done = heats_ ? 1 - share : share;
    if (done <= 1 - outer) {
      begin_ = row;
      farthest_ = 0;
      on_the_way_ = true;
    } else if (on_the_way_) {
      farthest_ = std::max(farthest_, done);
      if (done < farthest_ - max_back) {
        on_the_way_ = false;
      } else if (done >= 1 - inner_share) {
        add(stroke, begin_ + 1, row, points);
        on_the_way_ = false;
      }
    }
  }

 private:
  void add(const Stroke& stroke, std::size_t from, std::size_t to,
           std::vector<papers::ResistancePoint<double>>& points) const {
    Bins bins;
    for (std::size_t row = from; row < to; ++row) {
      if (std::isfinite(run_.resistance_ohm[row])) {
        bins.add(stroke.share(row), {run_.strain[row], run_.resistance_ohm[row] / ohm_});
      }
    }
    bins.append_to(points);
  }

  bool heats_;
  const identify::Run& run_;
  double ohm_;
  bool on_the_way_ = false;
  std::size_t begin_ = 0;
  double farthest_ = 0;
};

}  // namespace

FullBranches full_branches(const identify::Run& run, double ohm) {
  const Stroke stroke(run.strain);
  Follower heating(true, run, ohm);
  Follower cooling(false, run, ohm);
  FullBranches found;
  for (std::size_t row = 0; row < run.strain.size(); ++row) {
    heating.visit(stroke, row, found.heating);
    cooling.visit(stroke, row, found.cooling);
  }
  return found;
}

identify::Run averaged(const identify::Run& run, double seconds) {
  if (run.time_s.empty()) {
    return run;
  }
  identify::Run thin{};
  thin.name = run.name;
  thin.kind = run.kind;
  std::size_t begin = 0;
  for (std::size_t end = 1; end <= run.time_s.size(); ++end) {
    if (end < run.time_s.size() && run.time_s[end] - run.time_s[begin] < seconds) {
      continue;
    }
    const auto mean = [&](const std::vector<double>& column) {
      double sum = 0;
      for (std::size_t i = begin; i < end; ++i) {
        sum += column[i];
      }
      return sum / static_cast<double>(end - begin);
    };
    thin.time_s.push_back(mean(run.time_s));
    thin.stress_Pa.push_back(mean(run.stress_Pa));
    thin.strain.push_back(mean(run.strain));
    thin.resistance_ohm.push_back(mean(run.resistance_ohm));
    begin = end;
  }
  return thin;
}

}  // namespace smaservo::fits
