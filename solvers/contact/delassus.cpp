#include "solvers/contact/delassus.h"

namespace feder {

void delassus_matrix(const ContactRows& rows, const Response& respond, Eigen::Index coordinates,
                     Eigen::MatrixXd& responses, Eigen::MatrixXd& W) {
  const int size = 3 * rows.count();
  responses.resize(coordinates, size);
  W.resize(size, size);
  VectorXd unit = VectorXd::Zero(size), force, column, velocity;
  for (int i = 0; i < size; ++i) {
    force.setZero(coordinates);
    unit[i] = 1.0;
    rows.add_impulses(unit, force);
    unit[i] = 0.0;
    respond(force, column);
    responses.col(i) = column;
    rows.multiply(column, velocity);
    W.col(i) = velocity;
  }
  W = (0.5 * (W + W.transpose())).eval();
}

}  // namespace feder
