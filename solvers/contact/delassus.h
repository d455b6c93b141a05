#pragma once

#include <Eigen/Core>
#include <functional>

#include "engine/contacts.h"

namespace feder {

/// v = A^-1 [force; 0]: how velocities answer impulses, masked coordinates 0.
using Response = std::function<void(const VectorXd& force, VectorXd& v)>;

/// W = J A^-1 J^T (3 k x 3 k, symmetric) and responses = A^-1 J^T, column by column [1/kg].
void delassus_matrix(const ContactRows& rows, const Response& respond, Eigen::Index coordinates,
                     Eigen::MatrixXd& responses, Eigen::MatrixXd& W);

}  // namespace feder
