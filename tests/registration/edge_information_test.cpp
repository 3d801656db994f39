// SPDX-License-Identifier: MIT
#include "mmlins/registration/edge_information.hpp"

#include <gtest/gtest.h>

namespace mmlins::registration {
namespace {

using math::Matrix6d;
using math::Vector6d;

TEST(ComparedInformation, IsThatOfBothDeviationsTogether) {
  Vector6d of_closure, of_graph;
  of_closure << 0.01, 0.02, 0.03, 0.1, 0.2, 0.3;
  of_graph << 0.03, 0.02, 0.01, 0.3, 0.2, 0.1;
  const Matrix6d information = of_closure.cwiseAbs2().cwiseInverse().asDiagonal();
  const Matrix6d covariance = of_graph.cwiseAbs2().asDiagonal();
  const Matrix6d compared = compared_information(information, covariance);
  for (int i = 0; i < 6; ++i) {
    const double expected = 1.0 / (of_closure(i) * of_closure(i) + of_graph(i) * of_graph(i));
    EXPECT_NEAR(compared(i, i) / expected, 1.0, 1e-9);  // rounding
  }
}

TEST(ComparedInformation, SaysNothingOfWhatIsNotDetermined) {
  // Along (1, 1, 0) of the position nothing is known; across it 1 mm.
  Vector6d open = Vector6d::Zero();
  open.segment<2>(3) << M_SQRT1_2, M_SQRT1_2;
  const Matrix6d information = 1e6 * (Matrix6d::Identity() - open * open.transpose());
  const Matrix6d compared = compared_information(information, 1e-4 * Matrix6d::Identity());
  EXPECT_LT((compared * open).norm(), 1e-6);  // of 1e4: rounding
  Vector6d across = Vector6d::Zero();
  across.segment<2>(3) << M_SQRT1_2, -M_SQRT1_2;
  EXPECT_NEAR(across.dot(compared * across), 1.0 / (1e-6 + 1e-4), 1e-3);
}

}  // namespace
}  // namespace mmlins::registration
