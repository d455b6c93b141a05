#pragma once

#include <string>
#include <vector>

#include "models/model.h"

namespace feder {

/// Every model there is, in the order of THE LIST in catalog.cpp.
const std::vector<ModelInfo>& catalog();

/// Makes a model from "name", "name:key=value,key=value", "S1(100)", "S3b(30,10)" or "S1(100):key=value".
/// Numbers are SI; stiffness may be "inf" or "rigid" where the model allows rods; lists of modes read
/// "1:1e-3/3:5e-4". Throws InputError naming the unknown model or parameter and its nearest valid name, or
/// the bad value.
Model make_model(const std::string& spec);

}  // namespace feder
