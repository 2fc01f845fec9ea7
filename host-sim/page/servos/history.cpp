#include "host-sim/page/servos/history.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace smaservo::page {
namespace {

constexpr float absent = std::numeric_limits<float>::quiet_NaN();

/// The least and the greatest value of a signal in one part of the time span.
struct Extremes {
  float low = absent, high = absent;
  std::int64_t low_us = 0, high_us = 0;

  void add(float value, std::int64_t time_us) {
    if (!std::isfinite(value)) {
      return;
    }
    if (!(low <= value)) {
      low = value;
      low_us = time_us;
    }
    if (!(value <= high)) {
      high = value;
      high_us = time_us;
    }
  }
  float first() const { return low_us <= high_us ? low : high; }
  float second() const { return low_us <= high_us ? high : low; }
};

}  // namespace

std::size_t History::bytes_of(const Chunk& chunk) {
  return chunk_rows * (sizeof(std::int64_t) + sizeof(float) * chunk.has.count());
}

History::Chunk& History::open_chunk(const SignalSet& has) {
  // An open chunk is among the last few: there are as many as sets of signals.
  const std::size_t looked_at = std::min<std::size_t>(chunks_.size(), 8);
  for (std::size_t i = 1; i <= looked_at; ++i) {
    Chunk& chunk = chunks_[chunks_.size() - i];
    if (chunk.has == has && chunk.times_us.size() < chunk_rows) {
      return chunk;
    }
  }
  Chunk& chunk = chunks_.emplace_back();
  chunk.has = has;
  chunk.times_us.reserve(chunk_rows);
  chunk.values.reserve(chunk_rows * has.count());
  bytes_ += bytes_of(chunk);
  return chunk;
}

void History::drop_old(std::int64_t now_us) {
  while (chunks_.size() > 1 &&
         (bytes_ > max_bytes || chunks_.front().times_us.back() < now_us - longest_us)) {
    bytes_ -= bytes_of(chunks_.front());
    chunks_.pop_front();
  }
}

void History::add(const Sample& sample) {
  if (sample.has.none()) {
    return;
  }
  const std::scoped_lock lock(mutex_);
  Chunk& chunk = open_chunk(sample.has);
  chunk.times_us.push_back(sample.time_us);
  for (std::size_t i = 0; i < signal_count; ++i) {
    if (!sample.has[i]) {
      continue;
    }
    chunk.values.push_back(sample.values[i]);
    newest_.values[i] = sample.values[i];
  }
  newest_.has |= sample.has;
  newest_.time_us = sample.time_us;
  drop_old(sample.time_us);
}

std::size_t History::bytes() const {
  const std::scoped_lock lock(mutex_);
  return bytes_;
}

std::optional<Sample> History::newest() const {
  const std::scoped_lock lock(mutex_);
  return newest_.has.none() ? std::nullopt : std::optional(newest_);
}

/// Calls use(chunk, row) for all rows from this time on.
template <class Use>
void History::for_each_row(std::int64_t from_us, Use use) const {
  for (const Chunk& chunk : chunks_) {
    const auto first = std::ranges::lower_bound(chunk.times_us, from_us) - chunk.times_us.begin();
    for (auto row = static_cast<std::size_t>(first); row < chunk.times_us.size(); ++row) {
      use(chunk, row);
    }
  }
}

HistoryRows History::last(std::int64_t span_us, std::size_t points) const {
  const std::scoped_lock lock(mutex_);
  const std::int64_t from_us = newest_.time_us - span_us;
  std::size_t rows = 0;
  SignalSet has;
  for_each_row(from_us, [&](const Chunk& chunk, std::size_t) {
    ++rows;
    has |= chunk.has;
  });
  return rows <= points ? whole(from_us, has) : thinned(from_us, has, points);
}

HistoryRows History::whole(std::int64_t from_us, const SignalSet& has) const {
  const std::size_t width = has.count();
  std::vector<std::int64_t> times_us;
  std::vector<float> values;  // row by row
  for_each_row(from_us, [&](const Chunk& chunk, std::size_t row) {
    times_us.push_back(chunk.times_us[row]);
    std::size_t at = row * chunk.has.count();
    for (std::size_t i = 0; i < signal_count; ++i) {
      if (has[i]) {
        values.push_back(chunk.has[i] ? chunk.values[at] : absent);
      }
      at += chunk.has[i] ? 1U : 0U;
    }
  });
  // Chunks of different signal sets overlap in time.
  std::vector<std::size_t> order(times_us.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t row) { return std::pair(times_us[row], row); });
  HistoryRows all{{}, has, std::vector<std::vector<float>>(width)};
  for (const std::size_t row : order) {
    all.time_us.push_back(times_us[row]);
    for (std::size_t k = 0; k < width; ++k) {
      all.columns[k].push_back(values[row * width + k]);
    }
  }
  return all;
}

HistoryRows History::thinned(std::int64_t from_us, const SignalSet& has, std::size_t points) const {
  const std::size_t parts = std::max<std::size_t>(points / 2, 1);
  const std::size_t width = has.count();
  // The span that contains rows is divided, which may be shorter than the requested one.
  std::int64_t first_us = newest_.time_us;
  for_each_row(from_us, [&](const Chunk& chunk, std::size_t row) {
    first_us = std::min(first_us, chunk.times_us[row]);
  });
  const double part_us = std::max(
      static_cast<double>(newest_.time_us - first_us + 1) / static_cast<double>(parts), 1.0);
  std::vector<Extremes> extremes(parts * width);
  std::vector<char> filled(parts, 0);
  for_each_row(from_us, [&](const Chunk& chunk, std::size_t row) {
    const std::int64_t time_us = chunk.times_us[row];
    const std::size_t part = std::min(
        static_cast<std::size_t>(static_cast<double>(time_us - first_us) / part_us), parts - 1);
    filled[part] = 1;
    std::size_t at = row * chunk.has.count();
    std::size_t column = part * width;
    for (std::size_t i = 0; i < signal_count; ++i) {
      if (chunk.has[i]) {
        extremes[column].add(chunk.values[at++], time_us);
      }
      if (has[i]) {
        ++column;
      }
    }
  });
  HistoryRows all{{}, has, std::vector<std::vector<float>>(width)};
  for (std::size_t part = 0; part < parts; ++part) {
    if (filled[part] == 0) {
      continue;
    }
    const auto begin_us = first_us + static_cast<std::int64_t>(part_us * static_cast<double>(part));
    all.time_us.push_back(begin_us);
    all.time_us.push_back(begin_us + static_cast<std::int64_t>(part_us / 2));
    for (std::size_t k = 0; k < width; ++k) {
      const Extremes& e = extremes[part * width + k];
      all.columns[k].push_back(e.first());
      all.columns[k].push_back(e.second());
    }
  }
  return all;
}

}  // namespace smaservo::page
