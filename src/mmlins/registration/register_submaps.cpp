// SPDX-License-Identifier: MIT
#include "mmlins/registration/register_submaps.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "mmlins/registration/edge_information.hpp"
#include "mmlins/registration/linear_system.hpp"
#include "mmlins/spatial/voxel_table.hpp"

namespace mmlins::registration {

namespace {

using math::Matrix6d;
using math::SE3;
using math::Vector3d;
using math::Vector6d;

constexpr int kMinMatches = 100;      // of all samples
constexpr std::size_t kFew = 1000;    // samples that find the way to the last stage, at least
constexpr double kLevel = 0.9;        // of a normal's z component
constexpr double kSmallTurn = 2e-5;   // a step below which a stage has converged [rad]
constexpr double kSmallShift = 5e-4;  // [m]

/// Some points, evenly spread: the first of each cell, and of those every n-th. Gives their indices.
std::vector<std::size_t> sample(std::span<const Eigen::Vector3f> points, double spacing, int max_samples) {
  struct Taken {};
  spatial::VoxelTable<Taken> taken(spacing);
  std::vector<std::size_t> spread;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto cell = math::cell_at<double>(points[i].cast<double>(), 1.0 / spacing);
    if (taken.find_or_add(cell) == spread.size()) spread.push_back(i);
  }
  const auto limit = static_cast<std::size_t>(max_samples);
  if (spread.size() <= limit) return spread;
  std::vector<std::size_t> samples;
  for (std::size_t i = 0; i < limit; ++i) samples.push_back(spread[i * spread.size() / limit]);
  return samples;
}

/// Whether a point is part of a floor or ceiling.
bool is_level(const std::vector<GaussianMap>& levels, const Vector3d& p) {
  for (auto level = levels.rbegin(); level != levels.rend(); ++level) {
    const SurfaceCell* cell = level->at(p);
    if (cell != nullptr) return cell->num_thin == 1 && std::abs(cell->axes(2, 0)) > kLevel;
  }
  return false;
}

SE3 levelled(const SE3& T) {
  const double yaw = std::atan2(T.R(1, 0) - T.R(0, 1), T.R(0, 0) + T.R(1, 1));
  return {math::so3_exp(Vector3d(0, 0, yaw)), T.t};
}

/// The step that a system asks for; in x, y, z and yaw alone if the frames are to stay level.
Vector6d solve(const LinearSystem& system, bool stay_level) {
  // What next to nothing determines does not move: a thousandth of a point's worth of information per match.
  Matrix6d H = system.H;
  H.diagonal().array() += 1e-3 * system.num_matched;
  Vector6d step = Vector6d::Zero();
  if (stay_level) {
    step.tail<4>() = H.bottomRightCorner<4, 4>().ldlt().solve(system.b.tail<4>());
  } else {
    step = H.ldlt().solve(system.b);
  }
  return step;
}

struct Progress {
  SE3 T_target_source;
  int iterations = 0;
  bool converged = false;
  bool enough = true;
};

struct IterationLimits {
  bool stay_level;
  int min_matches;
  int max_iterations;
};

void iterate(Progress& progress, const std::vector<Vector3d>& samples, const Matching& matching,
             const IterationLimits& limits) {
  progress.converged = false;
  for (int i = 0; i < limits.max_iterations && !progress.converged; ++i) {
    const LinearSystem system = linearise(samples, progress.T_target_source, matching);
    progress.enough = system.num_matched >= limits.min_matches;
    if (!progress.enough) return;
    const Vector6d step = solve(system, limits.stay_level);
    progress.T_target_source = progress.T_target_source * math::se3_exp(step);
    progress.converged = step.head<3>().norm() < kSmallTurn && step.tail<3>().norm() < kSmallShift;
    ++progress.iterations;
  }
}

/// In x, y, z and yaw, from large cells to small ones. The large ones find the way from far off, for which
/// every sample helps; the smallest only lead to where the last stage begins, for which a few are as good.
void approach(Progress& progress, const PreparedSubmap& source, const PreparedSubmap& target,
              const RegistrationConfig& config) {
  const double noise2 = config.surface.point_noise * config.surface.point_noise;
  const double share = static_cast<double>(source.few_samples.size()) /
                       static_cast<double>(std::max<std::size_t>(1, source.samples.size()));
  const int min_of_few = static_cast<int>(std::ceil(share * kMinMatches));
  double kernel = config.coarse_kernel;
  for (std::size_t i = 0; i < target.levels.size() && progress.enough; ++i) {
    // Far off, all surfaces are equally uncertain; the thinnest must not decide alone.
    const Matching matching{&target.levels[i], nullptr, 1.0, kernel, noise2 + 0.25 * kernel * kernel};
    const bool are_smallest = i + 1 == target.levels.size();
    iterate(progress, are_smallest ? source.few_samples : source.samples, matching,
            {true, are_smallest ? min_of_few : kMinMatches, config.max_iterations});
    kernel = std::max(0.5 * kernel, config.fine_kernel);
  }
}

Matching finest_matching(const PreparedSubmap& target, const RegistrationConfig& config) {
  const std::size_t last = target.levels.size() - 1;
  return {&target.levels[last], last > 0 ? &target.levels[last - 1] : nullptr, 0.5, config.fine_kernel,
          config.surface.point_noise * config.surface.point_noise};
}

/// Sums over the residuals at the solution.
struct Account {
  degeneracy::ScanInformation information;
  double chi2 = 0.0;
  double weights = 0.0;
  double squares = 0.0;
  int num_rows = 0;
  int num_on_surface = 0;
  int num_standing = 0;                                // of those
  std::unordered_map<std::uint64_t, double> clusters;  // sum of normalised residuals of each
};

Account take_account(const PreparedSubmap& source, const SE3& T, const Matching& matching,
                     const RegistrationConfig& config) {
  Account account;
  for (std::size_t i = 0; i < source.samples.size(); ++i) {
    const Vector3d& p = source.samples[i];
    const auto residual = residual_of(p, T, matching);
    if (!residual || residual->error.head(residual->num_rows).norm() > config.overlap_distance) continue;
    ++account.num_on_surface;
    account.num_standing += source.stands[i] ? 1 : 0;
    account.information.spurious += spurious_information(*residual, p, T);
    const std::uint64_t block = math::cell_key(math::cell_at<double>(p, 1.0 / config.cluster_size));
    for (int k = 0; k < residual->num_rows; ++k) {
      const auto J = residual->J.row(k);
      account.information.H += residual->weight / residual->variance(k) * J.transpose() * J;
      const double normalised = residual->error(k) / std::sqrt(residual->variance(k));
      account.chi2 += residual->weight * normalised * normalised;
      account.weights += residual->weight;
      account.squares += residual->weight * residual->error(k) * residual->error(k);
      ++account.num_rows;
      // Errors of one block and one orientation of surface rise and fall together. Normals of opposite sign
      // are one orientation, and the sign of the error turns with them.
      Eigen::Index widest = 0;
      const Vector3d normal = T.R * J.tail<3>().transpose();
      normal.cwiseAbs().maxCoeff(&widest);
      const double sign = normal(widest) < 0.0 ? -1.0 : 1.0;
      account.clusters[4 * block + static_cast<std::uint64_t>(widest)] +=
          sign * std::sqrt(residual->weight) * normalised;
    }
  }
  return account;
}

/// docs/math/registration.md, Eq. (4).
double correlation_of(const Account& account, double least) {
  std::vector<double> squares;
  squares.reserve(account.clusters.size());
  for (const auto& entry : account.clusters) squares.push_back(entry.second * entry.second);
  std::sort(squares.begin(), squares.end());  // the order of a hash table is nobody's promise
  double sum = 0.0;
  for (const double square : squares) sum += square;
  return account.chi2 > 0.0 ? std::max(least, sum / account.chi2) : least;
}

/// Overlaps as they may still become: the last stage moves no point that far.
LeastOverlap within_reach(const PreparedSubmap& source, const SE3& T, Matching matching,
                          const RegistrationConfig& config) {
  const double distance = kHopelessDistance * config.overlap_distance;
  matching.reach = 1.0;
  matching.kernel = distance;
  std::size_t near = 0, near_standing = 0, standing = 0;
  for (std::size_t i = 0; i < source.samples.size(); ++i) {
    const auto match = find_surface(T * source.samples[i], matching);
    const bool is_near = match && match->distance <= distance;
    near += is_near ? 1 : 0;
    standing += source.stands[i] ? 1 : 0;
    near_standing += is_near && source.stands[i] ? 1 : 0;
  }
  const auto share = [](std::size_t part, std::size_t all) {
    return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0.0;
  };
  return {share(near, source.samples.size()), share(near_standing, standing)};
}

void assess(Registration& result, const PreparedSubmap& source, const PreparedSubmap& target,
            const RegistrationConfig& config) {
  Account account = take_account(source, result.T_target_source, finest_matching(target, config), config);
  if (account.num_rows == 0) return;
  result.overlap = static_cast<double>(account.num_on_surface) / static_cast<double>(source.samples.size());
  const auto standing = std::count(source.stands.begin(), source.stands.end(), true);
  result.standing_overlap = standing > 0 ? account.num_standing / static_cast<double>(standing) : 0.0;
  result.residual_rms = std::sqrt(account.squares / account.weights);
  result.chi2 = account.chi2 / account.weights;
  result.correlation = correlation_of(account, config.min_correlation);
  const double scale = 1.0 / (std::max(1.0, result.chi2) * result.correlation);
  account.information.H *= scale;
  account.information.spurious *= scale;
  result.observability = degeneracy::analyse_observability(account.information, config.observability);
  result.information = account.information.H;
  for (const JudgedDirection& direction :
       judge_directions(account.information.H, result.observability, config.observability.weak_noise_share)) {
    result.information = reduce_information(result.information, direction);
  }
}

}  // namespace

Fields RegistrationConfig::fields() {
  return {
      group("surface", surface, "what counts as a surface"),
      group("observability", observability, "when a direction of a closure counts as undetermined"),
      field("coarse_cell", coarse_cell, "m", {0.5, 8.0}, "edge of the largest cells"),
      field("num_levels", num_levels, "", {1.0, 5.0}, "grids, each with half the cells of the one before"),
      field("sample_spacing", sample_spacing, "m", {0.1, 4.0}, "between the points that are registered"),
      field("max_samples", max_samples, "", {200.0, 100000.0}, "of them, at most"),
      field("max_iterations", max_iterations, "", {1.0, 200.0}, "of one stage"),
      field("coarse_kernel", coarse_kernel, "m", {0.05, 10.0},
            "scale of the robust kernel of the first stage"),
      field("fine_kernel", fine_kernel, "m", {0.01, 2.0}, "the same of the last stage"),
      field("overlap_distance", overlap_distance, "m", {0.01, 2.0},
            "from a surface that still counts as on it"),
      field("cluster_size", cluster_size, "m", {0.5, 50.0},
            "edge of the blocks within which errors may be alike"),
      field("min_correlation", min_correlation, "", {1.0, 1000.0},
            "residuals that are worth one, at least; the data may say more"),
  };
}

PreparedSubmap prepare(const keyframe::Submap& submap, const RegistrationConfig& config) {
  PreparedSubmap prepared;
  double cell = config.coarse_cell;
  for (int i = 0; i < config.num_levels; ++i, cell *= 0.5) {
    prepared.levels.emplace_back(submap.points, cell, config.surface);
  }
  for (const std::size_t i : sample(submap.points, config.sample_spacing, config.max_samples)) {
    prepared.samples.push_back(submap.points[i].cast<double>());
    prepared.viewpoints.push_back(submap.viewpoints[submap.views[i]].cast<double>());
    prepared.stands.push_back(!is_level(prepared.levels, prepared.samples.back()));
  }
  const std::size_t step = std::max<std::size_t>(1, prepared.samples.size() / kFew);
  for (std::size_t i = 0; i < prepared.samples.size(); i += step)
    prepared.few_samples.push_back(prepared.samples[i]);
  return prepared;
}

Registration register_submaps(const PreparedSubmap& source, const PreparedSubmap& target, const SE3& T_guess,
                              const RegistrationConfig& config, const LeastOverlap& least) {
  const Matching finest = finest_matching(target, config);
  Progress progress{levelled(T_guess)};
  approach(progress, source, target, config);
  Registration result;
  result.T_target_source = progress.T_target_source;
  result.iterations = progress.iterations;
  if (!progress.enough) return result;
  if (least.all > 0.0 || least.standing > 0.0) {
    const LeastOverlap reach = within_reach(source, progress.T_target_source, finest, config);
    if (reach.all < least.all || reach.standing < least.standing) {
      result.status = RegistrationStatus::kHopeless;
      result.overlap = reach.all;
      result.standing_overlap = reach.standing;
      return result;
    }
  }
  iterate(progress, source.samples, finest, {false, kMinMatches, config.max_iterations});
  result.T_target_source = progress.T_target_source;
  result.iterations = progress.iterations;
  if (!progress.enough) return result;
  result.status = progress.converged ? RegistrationStatus::kConverged : RegistrationStatus::kNotConverged;
  assess(result, source, target, config);
  return result;
}

Registration register_submaps(const keyframe::Submap& source, const keyframe::Submap& target,
                              const SE3& T_target_source, const RegistrationConfig& config) {
  return register_submaps(prepare(source, config), prepare(target, config), T_target_source, config);
}

}  // namespace mmlins::registration
