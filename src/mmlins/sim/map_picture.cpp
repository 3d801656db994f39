// SPDX-License-Identifier: MIT
#include "mmlins/sim/map_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <set>
#include <utility>

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

constexpr double kPathRate = 5.0;   // [Hz]
constexpr double kLookEvery = 1.5;  // between the places from which the surroundings are drawn [m]
constexpr int kMostLooks = 1500;
constexpr int kRays = 240;           // per place
constexpr double kSight = 60.0;      // [m]
constexpr double kLongSide = 900.0;  // of the drawing [pixels]
constexpr double kMargin = 40.0;     // [pixels]

struct Frame {
  Eigen::AlignedBox2d bounds;  // [m]
  double scale = 1.0;          // [pixels per metre]

  Vector2d size() const { return scale * bounds.sizes() + Vector2d(2 * kMargin, 2 * kMargin); }
  Vector2d at(const Vector2d& p) const {  // north is up
    return {kMargin + scale * (p.x() - bounds.min().x()), kMargin + scale * (bounds.max().y() - p.y())};
  }
};

std::vector<Vector2d> seen_from(const Simulation& simulation, const math::Trajectory& path) {
  double length = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) length += (path[i].pose.t - path[i - 1].pose.t).norm();
  const double apart = std::max(kLookEvery, length / kMostLooks);
  std::vector<Vector2d> seen;
  math::Vector3d last = path.front().pose.t + math::Vector3d(apart, apart, 0.0);
  for (const math::StampedPose& stamped : path) {
    const math::Vector3d& here = stamped.pose.t;
    if ((here - last).norm() < apart) continue;
    last = here;
    for (int k = 0; k < kRays; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kRays;
      const math::Vector3d direction(std::cos(angle), std::sin(angle), 0.0);
      if (const auto hit = simulation.cast({here, direction}, kSight))
        seen.emplace_back((here + hit->range * direction).head<2>());
    }
  }
  return seen;
}

Frame frame_of(const math::Trajectory& path, const std::vector<Vector2d>& seen) {
  Frame frame;
  for (const math::StampedPose& stamped : path) frame.bounds.extend(Vector2d(stamped.pose.t.head<2>()));
  for (const Vector2d& p : seen) frame.bounds.extend(p);
  frame.bounds.extend(Vector2d(frame.bounds.min().array() - 1.0));
  frame.bounds.extend(Vector2d(frame.bounds.max().array() + 1.0));
  frame.scale = kLongSide / frame.bounds.sizes().maxCoeff();
  return frame;
}

// Points that fall on the same pixel are drawn once.
void draw_surroundings(std::string& svg, const Frame& frame, const std::vector<Vector2d>& seen) {
  std::set<std::pair<int, int>> pixels;
  for (const Vector2d& p : seen) {
    const Vector2d at = frame.at(p);
    pixels.emplace(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
  }
  svg += "<path stroke=\"#555\" stroke-width=\"1.4\" stroke-linecap=\"square\" fill=\"none\" d=\"";
  for (const auto& [x, y] : pixels) fmt::format_to(std::back_inserter(svg), "M{} {}h0", x, y);
  svg += "\"/>\n";
}

bool is_spoilt(const Simulation& simulation, Time time) {
  const double seconds = to_seconds(time - simulation.start_time());
  const auto& events = simulation.config().events;
  return std::any_of(events.begin(), events.end(), [&](const degrade::EventSpec& event) {
    return seconds >= event.start && seconds < event.start + event.duration;
  });
}

void draw_path(std::string& svg, const Frame& frame, const Simulation& simulation,
               const math::Trajectory& path) {
  for (const bool spoilt : {false, true}) {
    fmt::format_to(std::back_inserter(svg), "<path stroke=\"{}\" stroke-width=\"{}\" fill=\"none\" d=\"",
                   spoilt ? "#d22" : "#26c", spoilt ? 3.0 : 1.6);
    bool is_drawing = false;
    for (const math::StampedPose& stamped : path) {
      if (is_spoilt(simulation, stamped.time) != spoilt) {
        is_drawing = false;
        continue;
      }
      const Vector2d at = frame.at(stamped.pose.t.head<2>());
      fmt::format_to(std::back_inserter(svg), "{}{:.1f} {:.1f}", is_drawing ? 'L' : 'M', at.x(), at.y());
      is_drawing = true;
    }
    svg += "\"/>\n";
  }
  for (const bool is_end : {false, true}) {
    const Vector2d at = frame.at((is_end ? path.back() : path.front()).pose.t.head<2>());
    fmt::format_to(std::back_inserter(svg), "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\"/>\n",
                   at.x(), at.y(), is_end ? 3 : 5, is_end ? "#000" : "#2a2");
  }
}

// The longest of these that takes up at most a fifth of the picture.
double ruler_length(const Frame& frame) {
  constexpr std::array<double, 9> kLengths{1, 2, 5, 10, 20, 50, 100, 200, 500};
  double best = kLengths.front();
  for (const double length : kLengths) {
    if (length * frame.scale <= 0.2 * kLongSide) best = length;
  }
  return best;
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '<') {
      result += "&lt;";
    } else if (c == '&') {
      result += "&amp;";
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace

std::string map_svg(const Simulation& simulation) {
  const math::Trajectory path = simulation.truth(kPathRate);
  const std::vector<Vector2d> seen = seen_from(simulation, path);
  const Frame frame = frame_of(path, seen);
  const Vector2d size = frame.size();
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
      "{1:.0f}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      size.x(), size.y());
  draw_surroundings(svg, frame, seen);
  draw_path(svg, frame, simulation, path);
  const double ruler = ruler_length(frame);
  const SimulationConfig& config = simulation.config();
  const std::string title =
      fmt::format("{}, {:.0f} s, seed {}", config.sensor.model_name(), config.duration, config.seed);
  svg += fmt::format(
      "<path stroke=\"#000\" stroke-width=\"2\" d=\"M{0} {1:.1f}h{2:.1f}\"/>\n<g font-family=\"sans-serif\" "
      "font-size=\"14\"><text x=\"{0}\" y=\"{3:.1f}\">{4} m</text><text x=\"{0}\" "
      "y=\"24\">{5}</text></g>\n</svg>\n",
      kMargin, size.y() - 14.0, ruler * frame.scale, size.y() - 20.0, ruler, escaped(title));
  return svg;
}

}  // namespace mmlins::sim
