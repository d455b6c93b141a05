#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "engine/check.h"

namespace feder::test {

/// The action ends with an InputError that says this.
inline testing::AssertionResult refused(const std::string& part, const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    if (std::string(error.what()).find(part) != std::string::npos) return testing::AssertionSuccess();
    return testing::AssertionFailure() << error.what() << "\nexpected: " << part;
  }
  return testing::AssertionFailure() << "accepted, expected: " << part;
}

}  // namespace feder::test
