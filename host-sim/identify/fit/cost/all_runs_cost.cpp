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

AllRunsCost::AllRunsCost(std::vector<One> runs, const RiseCost& rise,
                         const std::vector<Active>& active, int threads)
    : runs_(std::move(runs)),
      rise_(rise),
      active_(active),
      threads_(std::min(runs_.size(), static_cast<std::size_t>(std::max(threads, 1)))) {
  for (const One& one : runs_) {
    first_row_.push_back(prior_row_);
    prior_row_ += one.cost.residuals();
  }
  set_num_residuals(static_cast<int>(rise_row() + rise_.residuals()));
  mutable_parameter_block_sizes()->push_back(static_cast<int>(active_.size()));
}

/// The active deviations that belong to all runs, and those that belong to one run.
std::vector<AllRunsCost::Column> AllRunsCost::columns(std::optional<std::size_t> run) const {
  std::vector<Column> all;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    if (!active_[i].run || active_[i].run == run) {
      all.push_back({i, active_[i].index});
    }
  }
  return all;
}

template <class Cost>
void AllRunsCost::evaluate(const Cost& cost, const std::vector<Column>& columns,
                           std::vector<double> u, const double* x, double* residuals,
                           double* jacobian) const {
  for (const Column& column : columns) {
    u[column.index] = x[column.column];
  }
  const Path path = cost.path(u.data());
  if (jacobian == nullptr || columns.empty()) {
    cost(u.data(), path, residuals);
    return;
  }
  const std::size_t rows = cost.residuals();
  const std::size_t width = active_.size();
  std::vector<Jet> out(rows);
  for (std::size_t first = 0; first < columns.size(); first += jet_width) {
    const std::size_t last = std::min(first + jet_width, columns.size());
    std::vector<Jet> in(u.begin(), u.end());
    for (std::size_t k = first; k < last; ++k) {
      in[columns[k].index].v[static_cast<int>(k - first)] = 1;
    }
    cost(in.data(), path, out.data());
    for (std::size_t row = 0; row < rows; ++row) {
      residuals[row] = out[row].a;
      double* slopes = jacobian + row * width;
      for (std::size_t k = first; k < last; ++k) {
        slopes[columns[k].column] = out[row].v[static_cast<int>(k - first)];
      }
    }
  }
}

Eigen::MatrixXd AllRunsCost::information(const std::vector<double>& x) const {
  std::vector<double> residuals(static_cast<std::size_t>(num_residuals()));
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> jacobian(
      num_residuals(), static_cast<Eigen::Index>(x.size()));
  const double* const block = x.data();
  double* slopes = jacobian.data();
  Evaluate(&block, residuals.data(), &slopes);
  const auto told = jacobian.topRows(static_cast<Eigen::Index>(rise_row()));
  return told.transpose() * told;
}

bool AllRunsCost::Evaluate(double const* const* parameters, double* residuals,
                           double** jacobians) const {
  const double* x = parameters[0];
  double* jacobian = jacobians == nullptr ? nullptr : jacobians[0];
  const std::size_t width = active_.size();
  if (jacobian != nullptr) {
    std::fill(jacobian, jacobian + static_cast<std::size_t>(num_residuals()) * width, 0.0);
  }
  const auto rows_at = [&](std::size_t row) { return residuals + row; };
  const auto slopes_at = [&](std::size_t row) {
    return jacobian == nullptr ? nullptr : jacobian + row * width;
  };
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < runs_.size(); i = next++) {
      evaluate(runs_[i].cost, columns(runs_[i].run), runs_[i].fixed, x, rows_at(first_row_[i]),
               slopes_at(first_row_[i]));
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
  // The residuals of falling transitions depend on the wire's deviations, which all runs share.
  evaluate(rise_, columns({}), runs_.front().fixed, x, rows_at(rise_row()), slopes_at(rise_row()));
  return true;
}

}  // namespace smaservo::identify
