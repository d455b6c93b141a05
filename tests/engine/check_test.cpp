#include "engine/check.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <set>
#include <string>

#include "engine/status.h"

namespace feder {
namespace {

const StatusCode kAllCodes[] = {
    StatusCode::kOk,           StatusCode::kDiverged,     StatusCode::kNonFinite,
    StatusCode::kSingular,     StatusCode::kInconsistent, StatusCode::kNotConverged,
    StatusCode::kStepTooSmall, StatusCode::kLimitReached, StatusCode::kRefused,
    StatusCode::kInterrupted,  StatusCode::kIoError,      StatusCode::kOutOfMemory};

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST(Status, IsOkUnlessToldOtherwise) {
  EXPECT_TRUE(Status{}.ok());
  EXPECT_TRUE(Status{}.reason.empty());
  const Status failed = Status::failure(StatusCode::kDiverged, "why");
  EXPECT_FALSE(failed.ok());
  EXPECT_EQ(failed.reason, "why");
}

TEST(Status, HasAWordOfItsOwnForEveryCode) {
  std::set<std::string> words;
  for (StatusCode code : kAllCodes) words.insert(to_string(code));
  EXPECT_EQ(words.size(), std::size(kAllCodes));
  EXPECT_EQ(words.count("unknown"), 0u);
}

TEST(Status, WritesTheWordsOfTheErrorContract) {
  EXPECT_STREQ(to_string(StatusCode::kOk), "ok");
  EXPECT_STREQ(to_string(StatusCode::kNonFinite), "non_finite");
  EXPECT_STREQ(to_string(StatusCode::kNotConverged), "not_converged");
  EXPECT_STREQ(to_string(StatusCode::kStepTooSmall), "step_too_small");
  EXPECT_STREQ(to_string(StatusCode::kOutOfMemory), "out_of_memory");
}

TEST(Status, MapsEveryCodeToTheExitCodeOfTheContract) {
  for (StatusCode code : kAllCodes) {
    const int expected = code == StatusCode::kOk                                                 ? 0
                         : code == StatusCode::kIoError                                          ? 4
                         : code == StatusCode::kOutOfMemory || code == StatusCode::kLimitReached ? 5
                         : code == StatusCode::kInterrupted                                      ? 130
                                                                                                 : 3;
    EXPECT_EQ(exit_code(code), expected) << to_string(code);
  }
}

TEST(Check, PassesSilentlyWhereTheConditionHolds) {
  EXPECT_NO_THROW(FEDER_CHECK(1 + 1 == 2, "arithmetic"));
}

TEST(Check, ThrowsMisuseWithFileConditionAndMessage) {
  EXPECT_THROW(FEDER_CHECK(1 + 1 == 3, "arithmetic"), MisuseError);
  const std::string text = message_of([] { FEDER_CHECK(1 + 1 == 3, "arithmetic"); });
  EXPECT_NE(text.find("check_test.cpp:"), std::string::npos) << text;
  EXPECT_NE(text.find("1 + 1 == 3"), std::string::npos) << text;
  EXPECT_NE(text.find("arithmetic"), std::string::npos) << text;
}

TEST(Check, InputMessagesReadPlaceNameValueUnitExpectation) {
  EXPECT_EQ(message_of([] { fail_input("node 3", "mass", -0.1, "kg", "a finite number > 0"); }),
            "node 3: mass = -0.10000000000000001 kg, expected a finite number > 0");
  EXPECT_EQ(message_of([] { fail_input("node 3", "free mask", 9, "", "a value from 0 to 7"); }),
            "node 3: free mask = 9, expected a value from 0 to 7");
}

TEST(Check, InputIsAnErrorOfTheCallerNotOfTheLibrary) {
  EXPECT_THROW(fail_input("here", "x", 1.0, "m", "2"), InputError);
  EXPECT_THROW(fail_input("here", "x", 1.0, "m", "2"), std::invalid_argument);
}

TEST(Check, NumbersAreRefusedOutsideTheirRangeOnly) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const double tiny = std::numeric_limits<double>::denorm_min();
  for (double bad : {nan, inf, -inf}) {
    EXPECT_THROW(require_finite("p", "x", bad, "m"), InputError) << bad;
    EXPECT_THROW(require_positive("p", "x", bad, "m"), InputError) << bad;
    EXPECT_THROW(require_non_negative("p", "x", bad, "m"), InputError) << bad;
  }
  for (double bad : {0.0, -0.0, -tiny}) EXPECT_THROW(require_positive("p", "x", bad, "m"), InputError) << bad;
  EXPECT_THROW(require_non_negative("p", "x", -tiny, "m"), InputError);
  EXPECT_NO_THROW(require_non_negative("p", "x", -0.0, "m"));
  EXPECT_NO_THROW(require_positive("p", "x", tiny, "m"));
  EXPECT_NO_THROW(require_finite("p", "x", -1e308, "m"));
}

}  // namespace
}  // namespace feder
