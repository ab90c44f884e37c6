// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/minimize.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/initialization/translations.h"
#include "core/optimize/linear/normal_equations.h"

namespace enfilade::optimize {
namespace {

// Below this share of the predicted decrease the model is not trusted in the translations.
constexpr double kPoorGain = 0.75;
// A decrease of chi2 below this is rounding error.
constexpr double kNoDecrease = 1e-15;
constexpr double kFirstDamping = 1e-6;
constexpr double kLeastDamping = 1e-9;
constexpr double kMostDamping = 1e12;

class Descent {
 public:
  Descent(const MinimizeOptions& options, const GraphLayout& layout, IndexedGraph& graph)
      : options_(options), layout_(layout), graph_(graph), cost_(GraphCost(graph, graph.poses, options.kernel)) {}

  Minimum Run() {
    Minimum minimum;
    bool moved = true;
    while (layout_.structure.size > 0 && !minimum.converged && minimum.iterations < options_.max_iterations &&
           damping_ < kMostDamping) {
      if (moved) Linearize(graph_, layout_, options_.kernel, equations_);
      moved = false;
      ++minimum.iterations;
      const std::optional<Eigen::VectorXd> step = SolveStep();
      if (!step) {
        RaiseDamping();
        continue;
      }
      const double predicted = PredictedDecrease(layout_.structure, equations_, *step);
      const bool at_rest = IsNegligible(predicted) || step->cwiseAbs().maxCoeff() <= options_.step_tolerance;
      auto [poses, cost] = Try(*step, predicted);
      const double decrease = cost_ - cost;
      if (decrease >= 0.0) {
        graph_.poses = std::move(poses);
        cost_ = cost;
        moved = true;
        minimum.converged = IsNegligible(Remaining(decrease));
        if (decrease > 0.25 * predicted) LowerDamping();
      } else {
        RaiseDamping();
      }
      // A step may be short because it is damped, not because the minimum is near.
      minimum.converged = (minimum.converged || at_rest) && damping_ <= kFirstDamping;
    }
    minimum.converged = minimum.converged || layout_.structure.size == 0;
    minimum.cost = cost_;
    return minimum;
  }

 private:
  bool IsNegligible(double decrease) const {
    return decrease <= options_.relative_tolerance * cost_ || decrease <= kNoDecrease;
  }

  // How much all further steps will still lower the cost, if the decreases go on as a geometric series with the ratio
  // of the last two. An upper estimate: close to the minimum the ratio falls.
  double Remaining(double decrease) {
    const double share = decrease / std::exchange(last_decrease_, decrease);
    return share < 1.0 ? decrease * share / (1.0 - share) : std::numeric_limits<double>::infinity();
  }

  void RaiseDamping() { damping_ = std::max(10.0 * damping_, kFirstDamping); }
  void LowerDamping() { damping_ = damping_ <= kLeastDamping ? 0.0 : 0.1 * damping_; }

  // Solves (H + damping diag(H)) dx = b; empty if that fails.
  std::optional<Eigen::VectorXd> SolveStep() {
    factor_ = equations_.H;
    for (Eigen::Matrix3d& block : factor_.diagonal) block.diagonal() *= 1.0 + damping_;
    if (!Factorize(layout_.structure, factor_)) return std::nullopt;
    Eigen::VectorXd step = equations_.b;
    SolveFactorized(layout_.structure, factor_, step);
    if (!step.allFinite()) return std::nullopt;
    return step;
  }

  std::pair<std::vector<Pose2>, double> Try(const Eigen::VectorXd& step, double predicted) const {
    std::vector<Pose2> poses = Moved(layout_, graph_.poses, step);
    const double cost = GraphCost(graph_, poses, options_.kernel);
    if (cost_ - cost >= kPoorGain * predicted || IsNegligible(predicted)) return {std::move(poses), cost};
    std::vector<Pose2> projected = poses;
    if (!SolveTranslations(graph_, layout_, options_.kernel, graph_.poses, projected)) return {std::move(poses), cost};
    const double projected_cost = GraphCost(graph_, projected, options_.kernel);
    if (projected_cost < cost) return {std::move(projected), projected_cost};
    return {std::move(poses), cost};
  }

  const MinimizeOptions& options_;
  const GraphLayout& layout_;
  IndexedGraph& graph_;
  double cost_;
  double damping_ = 0.0;
  double last_decrease_ = 0.0;  // of the last step taken
  NormalEquations equations_;
  BlockMatrix<3> factor_;
};

}  // namespace

Minimum Minimize(const MinimizeOptions& options, const GraphLayout& layout, IndexedGraph& graph) {
  return Descent(options, layout, graph).Run();
}

}  // namespace enfilade::optimize
