#include "host-sim/identify/fit/cost/all_runs_cost.hpp"

#include <atomic>
#include <thread>

namespace smaservo::identify {

std::vector<double> values(const std::vector<Active>& active) {
  std::vector<double> x;
  x.reserve(active.size());
  for (const Active& one : active) {
    x.push_back(*one.value);
  }
  return x;
}

AllRunsCost::AllRunsCost(std::vector<One> runs, const std::vector<Active>& active, int threads)
    : runs_(std::move(runs)),
      active_(active),
      threads_(std::min(runs_.size(), static_cast<std::size_t>(std::max(threads, 1)))) {
  for (const One& one : runs_) {
    first_row_.push_back(prior_row_);
    prior_row_ += one.cost.residuals();
  }
  set_num_residuals(static_cast<int>(prior_row_ + active_.size()));
  mutable_parameter_block_sizes()->push_back(static_cast<int>(active_.size()));
}

std::vector<AllRunsCost::Column> AllRunsCost::columns(std::size_t run) const {
  std::vector<Column> all;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    if (active_[i].run.value_or(run) == run) {
      all.push_back({i, active_[i].index});
    }
  }
  return all;
}

void AllRunsCost::evaluate(std::size_t i, const double* x, double* residuals,
                           double* jacobian) const {
  const One& one = runs_[i];
  const std::vector<Column> columns = this->columns(one.run);
  std::vector<double> u = one.fixed;
  for (const Column& column : columns) {
    u[column.index] = x[column.column];
  }
  double* own = residuals + first_row_[i];
  if (jacobian == nullptr) {
    one.cost(u.data(), own);
    return;
  }
  const std::size_t rows = one.cost.residuals();
  const std::size_t width = active_.size();
  std::vector<Jet> out(rows);
  for (std::size_t first = 0; first < columns.size(); first += jet_width) {
    const std::size_t last = std::min(first + jet_width, columns.size());
    std::vector<Jet> in(u.begin(), u.end());
    for (std::size_t k = first; k < last; ++k) {
      in[columns[k].index].v[static_cast<int>(k - first)] = 1;
    }
    one.cost(in.data(), out.data());
    for (std::size_t row = 0; row < rows; ++row) {
      own[row] = out[row].a;
      double* slopes = jacobian + (first_row_[i] + row) * width;
      for (std::size_t k = first; k < last; ++k) {
        slopes[columns[k].column] = out[row].v[static_cast<int>(k - first)];
      }
    }
  }
}

bool AllRunsCost::Evaluate(double const* const* parameters, double* residuals,
                           double** jacobians) const {
  const double* x = parameters[0];
  double* jacobian = jacobians == nullptr ? nullptr : jacobians[0];
  const std::size_t width = active_.size();
  if (jacobian != nullptr) {
    std::fill(jacobian, jacobian + static_cast<std::size_t>(num_residuals()) * width, 0.0);
  }
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < runs_.size(); i = next++) {
      evaluate(i, x, residuals, jacobian);
    }
  };
  std::vector<std::jthread> others;
  for (std::size_t i = 1; i < threads_; ++i) {
    others.emplace_back(work);
  }
  work();
  others.clear();
  // The prior: every deviation is 0 ± 1.
  for (std::size_t i = 0; i < width; ++i) {
    residuals[prior_row_ + i] = x[i];
    if (jacobian != nullptr) {
      jacobian[(prior_row_ + i) * width + i] = 1;
    }
  }
  return true;
}

}  // namespace smaservo::identify
